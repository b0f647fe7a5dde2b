#include "CommandRunner.h"
#include "SettingTexts.h"
#include "SyntheticImages.h"

#include "IO/VolumeIO.h"

#include <nlohmann/json.hpp>

namespace innergs::test {
namespace {

using SettingsTest = CommandTest;

std::vector<std::string> optionOf(const Setting& row, const std::string& text) {
  if (row.type() != Setting::Type::Flag) return {"--" + row.option(), text};
  return {(text == "true" ? "--" : "--no-") + row.option()};
}

TEST_F(SettingsTest, EveryOneHasAnOption) {
  for (const char* command : {"reconstruct", "interpolate"}) {
    const bool moving = command == std::string("interpolate");
    const std::vector<std::string> plain{command, path("none.nii"), "-o", path("out.nii")};
    std::vector<std::string> all = plain;
    for (const Setting& row : settingsTable()) {
      const std::vector<std::string> option = optionOf(row, otherText(row));
      if (moving ? concernsDynamicScans(row) : row.group != Setting::Group::Dynamic) {
        all.insert(all.end(), option.begin(), option.end());
      } else {
        std::vector<std::string> arguments = plain;
        arguments.insert(arguments.end(), option.begin(), option.end());
        EXPECT_EQ(run(arguments).exitCode, 2) << command << " " << row.name;
      }
    }
    const Outcome outcome = run(all);
    EXPECT_EQ(outcome.exitCode, 1) << outcome.err; // the options are accepted: 2 is wrong usage
  }
}

TEST_F(SettingsTest, EveryOneIsInTheReport) {
  writeVolume(phantom(), path("scan.nii"));
  std::vector<std::string> arguments{
      "reconstruct",     path("scan.nii"), "--report", path("r.json"), "--save-model",
      path("m.innergs"), "--gaussians",    "300",      "--iterations", "5",
      "--quiet"};
  const std::vector<std::string> asked{"fill",     "cutoff",  "lossWeight", "plateauFactor",
                                       "relocate", "threads", "seed"};
  for (const std::string& name : asked)
    for (const std::string& word : optionOf(settingNamed(name), otherText(settingNamed(name))))
      arguments.push_back(word);
  expectSuccess(run(arguments));
  const auto settings = nlohmann::json::parse(contents("r.json")).at("settings");
  for (const Setting& row : settingsTable())
    EXPECT_EQ(settings.contains(row.name), row.group != Setting::Group::Dynamic) << row.name;
  EXPECT_EQ(settings.at("fill"), 1.0 / 3);
  EXPECT_EQ(settings.at("lossWeight"), 1.0 / 3);
  EXPECT_EQ(settings.at("cutoff"), 1.3333333333333333);
  EXPECT_EQ(settings.at("plateauFactor"), 1.0 / 3);
  EXPECT_EQ(settings.at("relocate"), false);
  EXPECT_EQ(settings.at("consistency"), true);
  EXPECT_EQ(settings.at("seed"), 18000000000000000001u);
  EXPECT_EQ(settings.at("threads"), 7);
  EXPECT_EQ(settings.at("loss"), "l2"); // as chosen by the program
  EXPECT_EQ(settings.at("paperStopRule"), false);
}

TEST_F(SettingsTest, WhatIsNoSuchValueIsRefused) {
  for (const std::string value : {"--seed=-1", "--plateau-factor=0,5", "--device=abacus"})
    expectOneSentence(run({"reconstruct", "a.nii", "-o", "b.nii", value}), 2, value.substr(2, 4));
  for (const std::string value : {"--cutoff=9", "--threads=-1"}) // out of range
    expectOneSentence(run({"reconstruct", "a.nii", "-o", "b.nii", value}), 1, value.substr(2, 4));
}

} // namespace
} // namespace innergs::test
