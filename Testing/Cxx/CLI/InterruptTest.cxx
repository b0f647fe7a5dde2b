#include "CommandRunner.h"
#include "SyntheticImages.h"

#include "IO/ModelFile.h"
#include "IO/TimeSeriesWriting.h"
#include "IO/VolumeIO.h"

#include <nlohmann/json.hpp>

#include <cmath>
#include <cstring>

#ifndef _WIN32
#include <chrono>
#include <csignal>
#include <fcntl.h>
#include <sys/wait.h>
#include <thread>
#include <unistd.h>
#endif

namespace innergs::test {
namespace {

class InterruptTest : public CommandTest {
protected:
  void SetUp() override {
    CommandTest::SetUp();
    writeVolume(phantom({48, 48, 48}), path("scan.nii"));
  }
  // A fit of a few seconds, long enough to be interrupted.
  std::vector<std::string> longFit(const std::string& model) {
    return {"reconstruct", path("scan.nii"), "--gaussians", "4000",         "--iterations",
            "200",         "--threads",      "2",           "--save-model", path(model)};
  }

#ifndef _WIN32
  // Starts the command, sends the signal once log.txt contains the text, and returns the exit code (-1:
  // killed by a signal).
  int interrupted(const std::vector<std::string>& arguments, int signal, const char* text) {
    const pid_t child = fork();
    if (child == 0) {
      const int file = open(path("log.txt").c_str(), O_CREAT | O_TRUNC | O_WRONLY, 0600);
      dup2(file, STDOUT_FILENO);
      dup2(file, STDERR_FILENO);
      std::vector<char*> argv{const_cast<char*>(INNERGS_COMMAND)};
      for (const auto& argument : arguments)
        argv.push_back(const_cast<char*>(argument.c_str()));
      argv.push_back(nullptr);
      execv(INNERGS_COMMAND, argv.data());
      _exit(127);
    }
    int status = 0;
    bool running = true;
    while (running && contents("log.txt").find(text) == std::string::npos) {
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      running = waitpid(child, &status, WNOHANG) == 0;
    }
    if (running) {
      kill(child, signal);
      waitpid(child, &status, 0);
    }
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
#endif
};

#ifndef _WIN32
TEST_F(InterruptTest, KeepsWhatWasAskedForAndResumesToTheSameResult) {
  const std::string report = path("r.json"), volume = path("v.nii");
  auto arguments = longFit("part.innergs");
  for (const auto& word : {std::string("-o"), volume, std::string("--report"), report})
    arguments.push_back(word);
  const int code = interrupted(arguments, SIGINT, "itting");
  const std::string log = contents("log.txt");
  ASSERT_EQ(code, 130) << log;
  EXPECT_NE(log.find("Interrupted"), std::string::npos) << log;
  EXPECT_NE(log.find(path("part.innergs")), std::string::npos) << log;
  EXPECT_EQ(readVolume(volume).geometry.voxelCount(), 48 * 48 * 48);
  const auto told = nlohmann::json::parse(contents("r.json"));
  EXPECT_TRUE(told.at("interrupted").get<bool>());
  EXPECT_GT(told.at("seconds").at("fit").get<double>(), 0);
  const Model part = readModel(path("part.innergs"));
  EXPECT_LT(part.iteration, 200);
  EXPECT_FALSE(part.complete());

  auto resumed = longFit("resumed.innergs"), whole = longFit("whole.innergs");
  for (const auto& word : {std::string("--resume"), path("part.innergs")})
    resumed.push_back(word);
  expectSuccess(run(resumed));
  expectSuccess(run(whole));
  EXPECT_TRUE(contents("resumed.innergs") == contents("whole.innergs"));
}

TEST_F(InterruptTest, WhileTheQualityIsJudgedTheFitIsKept) {
  auto arguments = longFit("judged.innergs");
  arguments[5] = "20"; // iterations
  auto plain = arguments;
  plain.back() = path("plain.innergs");
  for (const auto& word :
       {std::string("--held-out"), std::string("0.1"), std::string("--report"), path("r.json")})
    arguments.push_back(word);
  const int code = interrupted(arguments, SIGINT, "Judging");
  ASSERT_EQ(code, 130) << contents("log.txt");
  EXPECT_NE(contents("log.txt").find("result itself is complete"), std::string::npos) << contents("log.txt");
  const auto report = nlohmann::json::parse(contents("r.json"));
  EXPECT_FALSE(report.at("interrupted").get<bool>());
  EXPECT_EQ(report.at("quality").at("judging"), "stopped");
  EXPECT_TRUE(report.at("quality").at("held_out_psnr_db").is_null());
  expectSuccess(run(plain));
  const auto judged = readModel(path("judged.innergs")).field.gaussians,
             whole = readModel(path("plain.innergs")).field.gaussians;
  ASSERT_EQ(judged.size(), whole.size());
  EXPECT_EQ(std::memcmp(judged.data(), whole.data(), sizeof(Gaussian) * whole.size()), 0);
}

TEST_F(InterruptTest, MovingScansAreResumedToTheSameResult) {
  TimeSeries series;
  series.geometry.size = {24, 24, 10};
  for (int f = 0; f < 8; ++f) {
    auto& frame = series.frames.emplace_back();
    for (int v = 0; v < 24 * 24 * 10; ++v)
      frame.push_back(static_cast<float>(
          100 * std::exp(-0.02 * (std::pow(v % 24 - 8 - f, 2) + std::pow(v / 24 % 24 - 12, 2)))));
    series.times.push_back(0.5 * f);
  }
  writeTimeSeries(series, path("moving.nii.gz"));
  const auto fit = [&](const char* model) {
    return std::vector<std::string>{"interpolate", path("moving.nii.gz"), "--kind",   "network", "--rounds",
                                    "20",          "--save-model",        path(model)};
  };
  const int code = interrupted(fit("part.innergs"), SIGINT, "itting");
  const std::string log = contents("log.txt");
  ASSERT_EQ(code, 130) << log;
  EXPECT_NE(log.find(path("part.innergs")), std::string::npos) << log;
  auto resumed = fit("resumed.innergs"), other = resumed;
  for (auto* arguments : {&resumed, &other})
    for (const auto& word : {std::string("--resume"), path("part.innergs")})
      arguments->push_back(word);
  expectSuccess(run(resumed));
  expectSuccess(run(fit("whole.innergs")));
  EXPECT_TRUE(contents("resumed.innergs") == contents("whole.innergs"));
  other[5] = "21"; // rounds
  expectOneSentence(run(other), 1, "other settings");
  resumed.back() = path("whole.innergs");
  expectOneSentence(run(resumed), 1, "nothing to resume");
}

TEST_F(InterruptTest, TerminationIsAsCleanAsCtrlC) {
  const int code = interrupted(longFit("part.innergs"), SIGTERM, "itting");
  EXPECT_EQ(code, 130) << contents("log.txt");
  EXPECT_GT(readModel(path("part.innergs")).field.size(), 0);
}

TEST_F(InterruptTest, EvaluationStopsAndLeavesNothing) {
  const int code = interrupted({"evaluate", path("scan.nii"), "--thickness", "4", "--prediction", "none",
                                "--gaussians", "4000", "--iterations", "200", "--threads", "2", "--json",
                                path("out/e.json"), "--picture", path("out/p.png")},
                               SIGINT, "itting");
  EXPECT_EQ(code, 130) << contents("log.txt");
  EXPECT_NE(contents("log.txt").find("\ninnergs: "), std::string::npos) << contents("log.txt");
  EXPECT_EQ(filesIn("out").size(), 0u);
}

TEST_F(InterruptTest, ExperimentsKeepTheTablesThatAreComplete) {
  const int code = interrupted({"experiment", "contour", "static", "--volume", path("scan.nii"),
                                "--gaussians", "4000", "--output", path("out")},
                               SIGINT, "itting");
  EXPECT_EQ(code, 130) << contents("log.txt");
  EXPECT_NE(contents("log.txt").find("\ninnergs: "), std::string::npos) << contents("log.txt");
  EXPECT_TRUE(exists("out/contour.csv"));
  EXPECT_FALSE(exists("out/static.csv"));
  EXPECT_EQ(filesIn("out").size(), 2u);
}
#endif

TEST_F(InterruptTest, ResumeOnAnotherScanStartsANewFitAndWarns) {
  expectSuccess(run(quickly({"reconstruct", path("scan.nii"), "-q", "--save-model", path("m.innergs")})));
  writeVolume(phantom({32, 32, 32}), path("other.nii"));
  const Outcome outcome = run(quickly(
      {"reconstruct", path("other.nii"), "-q", "--resume", path("m.innergs"), "-o", path("out/v.nii")}));
  EXPECT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_EQ(outcome.err.substr(0, 17), "innergs: warning:") << outcome.err;
  EXPECT_EQ(readVolume(path("out/v.nii")).geometry.voxelCount(), 32 * 32 * 32);
}

} // namespace
} // namespace innergs::test
