// No run corrupts or loses a file: neither its inputs, nor older outputs, nor its other results.
#include "CommandRunner.h"
#include "SyntheticImages.h"

#include "Core/Base/NumberText.h"
#include "IO/VolumeIO.h"

#include <nlohmann/json.hpp>

#include <map>

namespace fs = std::filesystem;

namespace innergs::test {
namespace {

class OutputTest : public CommandTest {
protected:
  void SetUp() override {
    CommandTest::SetUp();
    writeVolume(phantom(), path("scan.nii"));
    Volume mask = phantom();
    for (float& voxel : mask.voxels)
      voxel = 1;
    writeVolume(mask, path("mask.nii"));
    write("old.nii", "what was there before");
    write("old.json", "what was there before");
    expectSuccess(run(quickly({"reconstruct", path("scan.nii"), "-q", "--save-model", path("m.innergs")})));
  }

  /// Every file in the test's folder with its bytes, except the runner's own.
  std::map<std::string, std::string> everything() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(folder_)) {
      const std::string name = fs::relative(entry.path(), folder_).string();
      if (entry.is_regular_file() && name != "stdout.txt" && name != "stderr.txt")
        files[name] = contents(name);
    }
    return files;
  }

  /// "@name" is a path in the test's folder.
  void expectRefused(const std::vector<std::string>& words, const std::string& mention) {
    std::vector<std::string> arguments;
    std::string shown;
    for (const std::string& word : words) {
      arguments.push_back(word[0] == '@' ? path(word.substr(1)) : word);
      shown += word.substr(0, 60) + " ";
    }
    SCOPED_TRACE(shown);
    const auto before = everything();
    expectOneSentence(run(arguments), 1,
                      mention); // a fit with the defaults would take far longer than a test may
    EXPECT_EQ(everything(), before);
  }
};

// The README's promise: outputs are rejected before the work starts, not after it.
TEST_F(OutputTest, RefusedBeforeTheStart) {
  const std::string tooLong(260, 'x');
  fs::create_directory(folder_ / "dicom");
  write("dicom/1.dcm", "a slice");
  fs::create_hard_link(folder_ / "scan.nii", folder_ / "hard.nii");
#ifndef _WIN32
  fs::create_symlink("scan.nii", folder_ / "link.nii");
  fs::create_symlink("m.innergs", folder_ / "link.innergs");
#else
  fs::create_hard_link(folder_ / "scan.nii", folder_ / "link.nii");
  fs::create_hard_link(folder_ / "m.innergs", folder_ / "link.innergs");
#endif
  const struct {
    std::vector<std::string> words;
    const char* mention;
  } cases[] = {
      {{"reconstruct", "@scan.nii", "-o", "@scan.nii"}, "overwrite"},
      {{"reconstruct", "@scan.nii", "-o", "@out/../scan.nii"}, "overwrite"},
      {{"reconstruct", "@scan.nii", "-o", "@link.nii"}, "overwrite"},
      {{"reconstruct", "@link.nii", "-o", "@scan.nii"}, "overwrite"},
      {{"reconstruct", "@scan.nii", "-o", "@hard.nii"}, "overwrite"},
      {{"reconstruct", "@scan.nii", "--mask", "@mask.nii", "-o", "@mask.nii"}, "overwrite"},
      {{"reconstruct", "@scan.nii", "--reference", "@mask.nii", "-o", "@mask.nii"}, "overwrite"},
      {{"reconstruct", "@scan.nii", "--resume", "@m.innergs", "-o", "@out/v.nii", "--report", "@m.innergs"},
       "overwrite"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--report", "@scan.nii"}, "overwrite"},
      {{"reconstruct", "@scan.nii", "@link.nii", "-o", "@out/v.nii"}, "twice"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--roi", "900,910,0,10,0,10"}, "(x)"},
      {{"reconstruct", "@dicom", "-o", "@out/v.nii", "--report", "@dicom/1.dcm"}, "overwrite"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--report", "@out/v.nii"}, "one file"},
      {{"reconstruct", "@scan.nii", "--save-model", "@link.innergs", "--report", "@m.innergs"}, "one file"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--report", "@out/../out/v.nii"}, "one file"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--save-model", "@out/m.nii"}, ".innergs"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--ply", "@out/m.innergs"}, ".ply"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.txt"}, ".nii.gz"},
      {{"reconstruct", "@scan.nii", "-o", "@out/" + tooLong + ".nii"}, "too long"},
      {{"reconstruct", "@scan.nii", "-o", "@old.nii", "--report", "@out/" + tooLong}, "too long"},
      {{"reconstruct", "@scan.nii", "-o", "@old.nii", "--save-model", "@none/m.innergs"}, "none"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--thickness", "0"}, "--thickness"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--thickness", "400"}, "400 mm"},
      {{"reconstruct", "@scan.nii", "-o", "@out/v.nii", "--type", "uint8"}, "uint16"},
      {{"slice", "@m.innergs", "--plane", "axial", "-o", "@m.innergs"}, ".nii.gz"},
      {{"slice", "@scan.nii", "--plane", "axial", "-o", "@scan.nii"}, "overwrite"},
      {{"slice", "@m.innergs", "--plane", "axial", "-o", "@out/" + tooLong + ".png"}, "too long"},
      {{"slice", "@m.innergs", "--plane", "axial", "-o", "@none/s.png"}, "none"},
      {{"resample", "@m.innergs", "--reference", "@scan.nii", "-o", "@scan.nii"}, "overwrite"},
      {{"resample", "@m.innergs", "-o", "@old.nii", "--type", "uint8"}, "int16"},
      {{"simulate", "@scan.nii", "--thickness", "4", "-o", "@scan.nii"}, "overwrite"},
      {{"simulate", "@scan.nii", "--thickness", "4", "-o", "@old.nii", "--type", "uint8"}, "uint16"},
      {{"evaluate", "@scan.nii", "--save-volume", "@scan.nii"}, "overwrite"},
      {{"evaluate", "@scan.nii", "--csv", "@scan.nii"}, "overwrite"},
      {{"evaluate", "@scan.nii", "--csv", "@old.json", "--json", "@old.json"}, "one file"},
      {{"evaluate", "@scan.nii", "--picture", "@out/p.jpg"}, ".png"},
      {{"evaluate", "@scan.nii", "--json", "@none/t.json"}, "none"},
      {{"experiment", "contour", "-o", "@old.nii"}, "folder"},
  };
  for (const auto& c : cases)
    expectRefused(c.words, c.mention);
}

// An input that an output named with -axial would overwrite.
TEST_F(OutputTest, NamesMadeByTheCommandAreChecked) {
  fs::copy_file(folder_ / "scan.nii", folder_ / "s-axial.nii");
  expectRefused({"simulate", "@s-axial.nii", "--thickness", "2", "--orthogonal", "2", "-o", "@s.nii"},
                "overwrite");
}

// A resumed model may be its own output.
TEST_F(OutputTest, AResumedModelMayBeReplaced) {
  const Outcome outcome = run(quickly({"reconstruct", path("scan.nii"), "-q", "--resume", path("m.innergs"),
                                       "--save-model", path("m.innergs")}));
  EXPECT_EQ(outcome.err.find("overwrite"), std::string::npos) << outcome.err;
}

#ifndef _WIN32
// A model that exceeds the limit on file size, as on a full disk: the volume and the report are kept.
TEST_F(OutputTest, OneFailureLeavesTheOtherOutputs) {
  writeVolume(phantom({48, 48, 48}), path("large.nii"));
  const auto before = contents("m.innergs");
  const Outcome outcome = run(
      quickly({"reconstruct", path("large.nii"), "-q", "--spacing", "12", "--save-model", path("m.innergs"),
               "-o", path("out/v.nii"), "--ply", path("out/m.ply"), "--report", path("out/r.json")}),
      "trap '' XFSZ; ulimit -f 32; exec ");
  EXPECT_EQ(outcome.exitCode, 1) << outcome.err;
  const std::string last = outcome.err.substr(outcome.err.rfind('\n', outcome.err.size() - 2) + 1);
  EXPECT_NE(last.find("m.innergs' could not be written"), std::string::npos) << outcome.err;
  EXPECT_NE(last.find("out/v.nii"), std::string::npos) << outcome.err;
  EXPECT_EQ(contents("m.innergs"), before);
  EXPECT_EQ(readVolume(path("out/v.nii")).geometry.size, (std::array<std::int64_t, 3>{4, 4, 4}));
  const auto report = nlohmann::json::parse(contents("out/r.json"));
  EXPECT_TRUE(report.at("output").at("model").is_null());
  EXPECT_EQ(report.at("output").at("volume"), path("out/v.nii"));
  EXPECT_NE(report.at("warnings").dump().find("could not be written"), std::string::npos);
}
#endif

TEST_F(OutputTest, TypesThatFitAreWritten) {
  expectSuccess(run({"resample", path("m.innergs"), "--type", "int16", "-o", path("out/v.nii")}));
  // A plane through nearly uniform air, from a model with many values.
  expectSuccess(run({"slice", path("m.innergs"), "--plane", "axial", "--size", "2", "--type", "int16", "-o",
                     path("out/s.nii")}));
}

TEST_F(OutputTest, PlySaysInNumbersWhatItLeavesOut) {
  writeVolume(phantom({24, 28, 8}, 4), path("thick.nii"));
  const Outcome outcome = run(quickly({"reconstruct", path("thick.nii"), "-q", "--ply", path("out/m.ply")}));
  EXPECT_EQ(outcome.exitCode, 0);
  EXPECT_NE(outcome.err.find(" Gaussians alone: it leaves out the residual grid of "), std::string::npos)
      << outcome.err;
  EXPECT_NE(outcome.err.find(" values (RMS "), std::string::npos) << outcome.err;
}

TEST_F(OutputTest, ASliceShowsHowFarTheModelMayBeOff) {
  Volume deviation = phantom();
  const GridGeometry& g = deviation.geometry;
  const Affine3 map = g.indexToWorld();
  float largest = 0;
  for (std::int64_t v = 0; v < g.voxelCount(); ++v) {
    const Vec3 at =
        map({double(v % g.size[0]), double(v / g.size[0] % g.size[1]), double(v / (g.size[0] * g.size[1]))});
    deviation.voxels[v] = static_cast<float>(200 + at[0] + 2 * at[1] - at[2]);
    largest = std::max(largest, deviation.voxels[v]);
  }
  writeVolume(deviation, path("deviation.nii"));
  expectSuccess(run({"slice", path("m.innergs"), "--normal", "1,2,3", "--size", "9", "--uncertainty",
                     path("deviation.nii"), "-o", path("out/on.nii")}));
  const Volume on = readVolume(path("out/on.nii"));
  const Affine3 pixels = on.geometry.indexToWorld(), toIndex = inverse(map);
  int inside = 0;
  for (std::int64_t v = 0; v < 81; ++v) {
    const Vec3 at = pixels({double(v % 9), double(v / 9), 0}), index = toIndex(at);
    bool within = true;
    for (int a = 0; a < 3; ++a)
      within = within && index[a] >= 0 && index[a] <= double(g.size[a] - 1);
    if (!within) continue;
    EXPECT_NEAR(on.voxels[v], 200 + at[0] + 2 * at[1] - at[2], 1e-2);
    ++inside;
  }
  EXPECT_GT(inside, 60);
  const Outcome beside = run({"slice", path("m.innergs"), "--plane", "axial", "--size", "300",
                              "--uncertainty", path("deviation.nii"), "-o", path("out/on.nii")});
  EXPECT_EQ(beside.exitCode, 0) << beside.err;
  EXPECT_FLOAT_EQ(readVolume(path("out/on.nii")).voxels.front(), largest) << "beside the volume";
}

TEST_F(OutputTest, ASliceShowsWhereNothingWasMeasured) {
  Volume measured = phantom();
  const GridGeometry& g = measured.geometry;
  for (std::int64_t v = 0; v < g.voxelCount(); ++v)
    measured.voxels[v] = v % g.size[0] < g.size[0] / 2 ? 0 : 1;
  writeVolume(measured, path("measured.nii"), OutputType::UInt8);
  const std::vector<std::string> words{"slice", path("m.innergs"), "--normal",
                                       "1,2,3", "--measured",      path("measured.nii")};
  const auto with = [&](std::vector<std::string> more) {
    more.insert(more.begin(), words.begin(), words.end());
    return run(more);
  };
  const Outcome outcome = with({"--size", "40", "-o", path("out/on.nii")});
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  const Volume on = readVolume(path("out/on.nii"));
  const Affine3 pixels = on.geometry.indexToWorld(), toIndex = inverse(g.indexToWorld());
  int marked = 0, bare = 0;
  for (std::int64_t v = 0; v < 1600; ++v) {
    const Vec3 index = toIndex(pixels({double(v % 40), double(v / 40), 0}));
    bool within = true;
    for (int a = 0; a < 3; ++a)
      within = within && index[a] >= -0.5 && index[a] <= double(g.size[a]) - 0.5;
    const bool expected = within && std::lround(index[0]) >= g.size[0] / 2;
    if (std::abs(index[0] + 0.5 - std::round(index[0] + 0.5)) < 1e-3) continue; // between two voxels
    EXPECT_EQ(on.voxels[v], expected ? 1 : 0) << v;
    ++(expected ? marked : bare);
  }
  EXPECT_GT(marked, 50);
  EXPECT_GT(bare, 50);
  EXPECT_EQ(with({"-o", path("out/on.png")}).exitCode, 0);
  EXPECT_EQ(with({"--window", "3", "-o", path("out/on.png")}).exitCode, 2);
  EXPECT_EQ(with({"--uncertainty", path("measured.nii"), "-o", path("out/on.nii")}).exitCode, 2);
}

// Accepts positions as 3D Slicer and the app show them.
TEST_F(OutputTest, PositionsInEitherFrame) {
  const Vec3 c = phantom().geometry.centre();
  const auto numbers = [](const Vec3& v) {
    return formatted("%f", v[0]) + "," + formatted("%f", v[1]) + "," + formatted("%f", v[2]);
  };
  const auto written = [&](std::vector<std::string> words, const std::string& name) {
    words.insert(words.end(), {"-q", "-o", path(name)});
    expectSuccess(run(words));
    return contents(name);
  };
  const auto expectSame = [&](std::vector<std::string> lps, std::vector<std::string> ras) {
    SCOPED_TRACE(lps[2]);
    ras.push_back("--ras");
    EXPECT_EQ(written(lps, "out/lps.nii"), written(ras, "out/ras.nii"));
  };
  const std::string m = path("m.innergs");
  const Vec3 a{c[0] + 2, c[1] - 3, c[2] + 1}, flipped{-a[0], -a[1], a[2]};
  expectSame({"slice", m, "--plane", "sagittal", "--position", formatted("%f", a[0])},
             {"slice", m, "--plane", "sagittal", "--position", formatted("%f", -a[0])});
  expectSame({"slice", m, "--plane", "axial", "--position", formatted("%f", a[2])},
             {"slice", m, "--plane", "axial", "--position", formatted("%f", a[2])});
  expectSame({"slice", m, "--normal", "1,2,3", "--center", numbers(a)},
             {"slice", m, "--normal", "-1,-2,3", "--center", numbers(flipped)});
  expectSame({"slice", m, "--u", "1,0,0", "--v", "0,0.8,0.6", "--origin", numbers(a), "--size", "5"},
             {"slice", m, "--u", "-1,0,0", "--v", "0,-0.8,0.6", "--origin", numbers(flipped), "--size", "5"});
  const auto box = [&](const Vec3& v) {
    std::string roi;
    for (const double x : {v[0], v[1], v[2]})
      roi += (roi.empty() ? "" : ",") + formatted("%f", x - 4) + "," + formatted("%f", x + 5);
    return roi;
  };
  const auto turned = [&](const Vec3& v) {
    const auto pair = [](double low, double high) {
      return formatted("%f", low) + "," + formatted("%f", high);
    };
    return pair(-v[0] - 5, -v[0] + 4) + "," + pair(-v[1] - 5, -v[1] + 4) + "," + pair(v[2] - 4, v[2] + 5);
  };
  expectSame({"resample", m, "--roi", box(a)}, {"resample", m, "--roi", turned(a)});
  const Outcome beside =
      run({"slice", m, "--ras", "--plane", "coronal", "--position", "900", "-o", path("out/no.nii")});
  expectOneSentence(beside, 1, "(RAS mm)");
  const auto info = nlohmann::json::parse(run({"info", path("scan.nii"), "--json"}).out);
  for (int axis = 0; axis < 3; ++axis) {
    const double sign = axis < 2 ? -1 : 1;
    EXPECT_NEAR(info.at("centre_mm_lps")[axis].get<double>(), c[axis], 1e-4);
    EXPECT_NEAR(info.at("centre_mm_ras")[axis].get<double>(), sign * c[axis], 1e-4);
    EXPECT_EQ(info.at("origin_mm_ras")[axis].get<double>(),
              sign * info.at("origin_mm_lps")[axis].get<double>());
  }
}

} // namespace
} // namespace innergs::test
