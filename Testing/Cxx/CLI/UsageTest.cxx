#include "CommandRunner.h"

#include <nlohmann/json.hpp>

namespace innergs::test {
namespace {

using UsageTest = CommandTest;

TEST_F(UsageTest, PrintsVersionAndHelp) {
  const Outcome version = run({"--version"});
  EXPECT_EQ(version.exitCode, 0);
  EXPECT_EQ(version.out.substr(0, 8), "innergs ");
  for (const char* command : {"reconstruct", "slice", "resample", "interpolate", "segment", "simulate",
                              "evaluate", "experiment", "info"}) {
    const Outcome help = run({command, "--help"});
    EXPECT_EQ(help.exitCode, 0);
    EXPECT_NE(help.out.find("Examples:"), std::string::npos) << command;
    EXPECT_NE(help.out.find(std::string("innergs ") + command), std::string::npos) << command;
    EXPECT_EQ(help.err, "");
  }
}

TEST_F(UsageTest, WrongUsageIsOneSentenceAndCode2) {
  expectOneSentence(run({}), 2);
  expectOneSentence(run({"reconstuct", "a.nii"}), 2, "'reconstuct'");
  expectOneSentence(run({"reconstruct"}), 2);
  expectOneSentence(run({"reconstruct", "a.nii"}), 2, "--output");
  expectOneSentence(run({"reconstruct", "a.nii", "-o", "b.nii", "--preset", "slow"}), 2,
                    "fast|balanced|best");
  expectOneSentence(run({"reconstruct", "a.nii", "-o", "b.nii", "--roi", "1,2,3"}), 2, "6");
  expectOneSentence(run({"reconstruct", "a.nii", "-o", "b.nii", "--spacing", "1,x,1"}), 2, "x");
  expectOneSentence(run({"reconstruct", "a.nii", "-o", "b.nii", "--spacing", "1", "--reference", "c.nii"}),
                    2);
  expectOneSentence(run({"reconstruct", "a.nii", "-o", "b.nii", "--no-such-option"}), 2, "--no-such-option");
  expectOneSentence(run({"slice", "m.innergs", "-o", "b.nii"}), 2, "--plane");
  expectOneSentence(run({"slice", "m.innergs", "--plane", "axial", "-o", "b.nii", "--window", "9"}), 2,
                    ".png");
  expectOneSentence(run({"slice", "m.innergs", "--plane", "axial", "-o", "b.png", "--type", "int16"}), 2,
                    "8 bits");
  expectOneSentence(run({"simulate", "a.nii", "-o", "b.nii"}), 2, "--thickness");
  expectOneSentence(run({"simulate", "a.nii", "-o", "b.nii", "--thickness", "0"}), 2, "--thickness");
}

TEST_F(UsageTest, InfoAboutTheProgram) {
  const Outcome outcome = run({"info", "--json"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  const auto info = nlohmann::json::parse(outcome.out);
  EXPECT_EQ("innergs " + info.at("innergs").get<std::string>() + "\n", run({"--version"}).out);
  EXPECT_FALSE(info.at("itk").get<std::string>().empty());
  EXPECT_EQ(info.at("instruction_sets").back(), "scalar");
  EXPECT_GE(info.at("threads").get<int>(), 1);
  EXPECT_NE(run({"info"}).out.find("instruction sets"), std::string::npos);
}

} // namespace
} // namespace innergs::test
