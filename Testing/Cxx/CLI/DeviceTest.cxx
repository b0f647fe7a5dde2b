#include "CommandRunner.h"
#include "SyntheticImages.h"
#include "TextContains.h"

#include "Core/Motion/TimeSeries.h"
#include "IO/TimeSeriesWriting.h"
#include "IO/VolumeIO.h"

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

namespace innergs::test {
namespace {

/// The command with one of the fake plugins (../Device), each of which is rejected or fails in its own way.
class DeviceTest : public CommandTest {
protected:
  static std::string with(const std::string& folder, const std::string& fault = "") {
    return "INNERGS_PLUGIN_PATH='" + folder + "' INNERGS_FAKE='" + fault + "' ";
  }
  static std::string fake(const std::string& plugin, const std::string& fault = "") {
    return with(INNERGS_FAKE_PLUGINS "/" + plugin, fault);
  }
  static nlohmann::json reportOf(const std::string& text) { return nlohmann::json::parse(text); }
  Outcome reconstruct(const std::string& device, const std::string& prefix) const {
    return run(quickly({"reconstruct", path("scan.nii"), "-o", path("out/v.nii"), "--report",
                        path("out/r.json"), "--device", device}),
               prefix);
  }
  std::string libraryName() const { return std::filesystem::path(INNERGS_FAKE_LIBRARY).filename().string(); }
};

} // namespace

TEST_F(DeviceTest, InfoListsThem) {
  const Outcome text = run({"info"}, fake("good"));
  EXPECT_EQ(text.exitCode, 0) << text.err;
  for (const char* part : {"cuda:0", "Fake One", "cuda:1", "Fake Two", "9.0"})
    EXPECT_TRUE(has(text.out, part)) << text.out;
  const auto json = nlohmann::json::parse(run({"info", "--json"}, fake("good")).out);
  EXPECT_EQ(json["devices"]["cuda:0"]["memory_bytes"], 8'000'000'000);
  EXPECT_EQ(json["devices"]["cuda:1"]["compute_capability"], "9.0");
}

TEST_F(DeviceTest, InfoSaysInOneLineWhyThereIsNone) {
  std::filesystem::create_directories(folder_ / "garbage");
  write("garbage/" + libraryName(), "This is no library at all.");
  std::ifstream whole(INNERGS_FAKE_LIBRARY, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(whole), {}};
  ASSERT_GT(bytes.size(), 20'000u);
  std::vector<std::pair<std::string, std::string>> cases{
      {fake("good", "none"), "No NVIDIA driver is installed."},
      {fake("good", "throws"), "nothing answers"},
      {fake("other"), "another build"},
      {fake("refuses"), "it does not like to"},
      {fake("symbol"), "not a plugin"},
      {with(path("garbage")), "cannot be loaded"},
  };
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{40}, std::size_t{4096}, bytes.size() / 2, bytes.size() - 1}) {
    const std::string name = "short" + std::to_string(size);
    std::filesystem::create_directories(folder_ / name);
    write(name + "/" + libraryName(), bytes.substr(0, size));
    cases.push_back({with(path(name)), "cannot be loaded"});
  }
  for (const auto& [prefix, says] : cases) {
    SCOPED_TRACE(prefix);
    const Outcome outcome = run({"info"}, prefix);
    EXPECT_EQ(outcome.exitCode, 0);
    EXPECT_EQ(outcome.err, "");
    const std::size_t at = outcome.out.find("devices:");
    ASSERT_NE(at, std::string::npos) << outcome.out;
    const std::string line = outcome.out.substr(at, outcome.out.find('\n', at) - at);
    EXPECT_TRUE(has(line, "CPU only. ")) << line;
    EXPECT_TRUE(has(line, says)) << line;
    EXPECT_EQ(line.back(), '.') << line;
    expectSuccess(run({"info", "--json"}, prefix));
  }
}

TEST_F(DeviceTest, IsFoundBesideTheProgramAndWhereItIsInstalled) {
  namespace fs = std::filesystem;
  const fs::path root = folder_ / "with space";
  fs::create_directories(root / "bin");
  fs::copy_file(INNERGS_COMMAND, root / "bin/innergs");
  const auto info = [&](const std::string& prefix, const std::string& command) {
    const std::string output = path("info.txt");
    EXPECT_EQ(std::system((prefix + " " + command + " info > '" + output + "' 2>&1").c_str()), 0);
    return contents("info.txt");
  };
  const std::string absolute = "'" + (root / "bin/innergs").string() + "'";
  EXPECT_FALSE(has(info("", absolute), "Fake"));
  for (const char* where : {"bin", "lib", "lib/innergs"}) {
    SCOPED_TRACE(where);
    fs::create_directories(root / where);
    const fs::path plugin = root / where / libraryName();
    fs::copy_file(INNERGS_FAKE_LIBRARY, plugin);
    EXPECT_TRUE(has(info("", absolute), "Fake Two"));
    EXPECT_TRUE(has(info("cd / && PATH='" + (root / "bin").string() + "':\"$PATH\"", "innergs"), "Fake Two"));
    EXPECT_TRUE(has(info(fake("other"), absolute), "another build")) << "the path comes first";
    EXPECT_TRUE(has(info(with(path("nowhere")), absolute), "Fake Two"));
    fs::remove(plugin);
  }
}

TEST_F(DeviceTest, IsChosenReportedAndLeftWhenItFails) {
  writeVolume(phantom(), path("scan.nii"));
  const Outcome small = reconstruct("auto", fake("good"));
  EXPECT_TRUE(has(small.err, "The fit is small")) << small.err;
  const Outcome good = reconstruct("cuda", fake("good"));
  ASSERT_EQ(good.exitCode, 0) << good.err;
  EXPECT_TRUE(has(good.err, "On Fake Two (cuda:1)")) << good.err;
  auto report = reportOf(contents("out/r.json"));
  EXPECT_EQ(report["device"]["asked"], "cuda");
  EXPECT_EQ(report["device"]["used"], "cuda:1");
  EXPECT_EQ(report["device"]["name"], "Fake Two");
  EXPECT_TRUE(report["warnings"].empty());

  const Outcome failing = reconstruct("cuda:0", fake("good", "iteration:3"));
  ASSERT_EQ(failing.exitCode, 0) << failing.err;
  EXPECT_TRUE(has(failing.err, "innergs: warning: ")) << failing.err;
  EXPECT_TRUE(has(failing.err, "The device has no memory left.")) << failing.err;
  report = reportOf(contents("out/r.json"));
  EXPECT_EQ(report["device"]["asked"], "cuda:0");
  EXPECT_EQ(report["device"]["used"], "cpu");
  EXPECT_TRUE(has(report["device"]["reason"], "Fake One (cuda:0) failed after iteration 2"))
      << report["device"]["reason"];
  EXPECT_EQ(report["iterations"], 6);

  const Outcome cpu = reconstruct("cpu", fake("good"));
  ASSERT_EQ(cpu.exitCode, 0) << cpu.err;
  report = reportOf(contents("out/r.json"));
  EXPECT_EQ(report["device"]["used"], "cpu");
  EXPECT_TRUE(has(report["device"]["reason"], "as asked")) << report["device"]["reason"];

  for (const auto& prefix : {fake("other"), fake("good", "none"), fake("symbol")}) {
    const Outcome none = reconstruct("auto", prefix);
    ASSERT_EQ(none.exitCode, 0) << none.err;
    EXPECT_TRUE(has(none.err, "On the CPU. ")) << none.err;
    EXPECT_FALSE(has(none.err, "warning")) << none.err;
  }
}

TEST_F(DeviceTest, FitsMovingScans) {
  TimeSeries series;
  series.geometry.size = {14, 12, 5};
  for (int f = 0; f < 4; ++f) {
    series.times.push_back(f);
    auto& frame = series.frames.emplace_back();
    for (int v = 0; v < 14 * 12 * 5; ++v)
      frame.push_back(static_cast<float>(
          100 * std::exp(-0.1 * (std::pow(v % 14 - 5 - 0.7 * f, 2) + std::pow(v / 14 % 12 - 6, 2)))));
  }
  writeTimeSeries(series, path("moving.nii.gz"));
  const auto fit = [&](const std::string& device, const std::string& prefix) {
    return run({"interpolate", path("moving.nii.gz"), "--kind", "motion", "--rounds", "5", "--at", "1.5",
                "-o", path("out/at.nii"), "--report", path("out/r.json"), "--device", device},
               prefix);
  };
  const Outcome good = fit("cuda", fake("good"));
  ASSERT_EQ(good.exitCode, 0) << good.err;
  EXPECT_TRUE(has(good.err, "On Fake Two (cuda:1)")) << good.err;
  auto report = reportOf(contents("out/r.json"));
  EXPECT_EQ(report["device"]["asked"], "cuda");
  EXPECT_EQ(report["device"]["used"], "cuda:1");
  EXPECT_TRUE(report["notes"].empty());
  const Outcome failing = fit("cuda:0", fake("good", "gradient:9"));
  ASSERT_EQ(failing.exitCode, 0) << failing.err;
  EXPECT_TRUE(has(failing.err, "innergs: warning: On the CPU. Fake One (cuda:0) failed on frame"))
      << failing.err;
  report = reportOf(contents("out/r.json"));
  EXPECT_EQ(report["device"]["used"], "cpu");
  std::filesystem::remove(path("out/at.nii"));
  expectOneSentence(fit("cuda", fake("good", "none")), 1, "No NVIDIA driver is installed.");
  EXPECT_FALSE(exists("out/at.nii"));
}

TEST_F(DeviceTest, IsAnErrorWhereItIsNot) {
  writeVolume(phantom(), path("scan.nii"));
  expectOneSentence(reconstruct("cuda", fake("good", "none")), 1, "No NVIDIA driver is installed.");
  expectOneSentence(reconstruct("cuda:2", fake("good")), 1, "cuda:1");
  expectOneSentence(reconstruct("cuda", fake("other")), 1, "another build");
  EXPECT_EQ(reconstruct("gpu", fake("good")).exitCode, 2);
  EXPECT_FALSE(exists("out/v.nii"));
}

TEST_F(DeviceTest, RendersModelsWhereAsked) {
  writeVolume(phantom(), path("scan.nii"));
  expectSuccess(run(quickly({"reconstruct", path("scan.nii"), "--save-model", path("m.innergs")})));
  const auto render = [&](const std::string& command, const std::string& device, const std::string& fault) {
    std::vector<std::string> words{command, path("m.innergs"), "-o", path("out/v.nii"), "--device", device};
    if (command == "slice") words.insert(words.end(), {"--plane", "axial"});
    return run(words, fake("good", fault));
  };
  const auto rendered = [&](const std::string& command, const std::string& device, const std::string& fault) {
    const Outcome outcome = render(command, device, fault);
    EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
    return readVolume(path("out/v.nii")).voxels;
  };
  for (const std::string command : {"resample", "slice"}) {
    const auto cpu = rendered(command, "cpu", "mark");
    EXPECT_EQ(rendered(command, "auto", "mark"), cpu) << "too small to pay";
    EXPECT_EQ(rendered(command, "cuda", "render"), cpu);
    EXPECT_NE(rendered(command, "cuda", "later"), cpu);
    expectOneSentence(render(command, "cuda", "mark"), 1, "in its self-check, its rendering is");
    expectOneSentence(render(command, "cuda", "none"), 1, "No NVIDIA driver is installed.");
  }
}

} // namespace innergs::test
