#include "Core/Settings/SettingsTable.h"
#include "SettingTexts.h"

#include "Core/Base/Failure.h"
#include "Core/Job/Resume.h"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

namespace innergs {
namespace {

std::string refusal(const std::string& name, const std::string& text) {
  return sentenceOf([&] {
    Settings settings;
    const Setting& row = settingNamed(name);
    row.setText(settings, text);
    row.check(settings);
  });
}

TEST(SettingsTable, EveryRowHasOneNameAndSaysWhatItIs) {
  std::set<std::string> names;
  for (const Setting& row : settingsTable()) {
    SCOPED_TRACE(row.name);
    EXPECT_TRUE(names.insert(row.name).second);
    EXPECT_NE(std::string(row.label), "");
    EXPECT_NE(std::string(row.text), "");
    EXPECT_EQ(row.words.empty(), row.type() != Setting::Type::Choice);
    EXPECT_NE(automaticText(row), "");
    EXPECT_EQ(&settingNamed(row.name), &row);
  }
  EXPECT_EQ(settingNamed("plateauFactor").option(), "plateau-factor");
  EXPECT_EQ(settingNamed("beta1").option(), "beta1");
}

TEST(SettingsTable, EveryValueComesBackAsItWas) {
  Settings all;
  for (const Setting& row : settingsTable()) {
    SCOPED_TRACE(row.name);
    const std::string text = test::otherText(row);
    Settings settings;
    EXPECT_EQ(row.isIn(settings), !row.member.optional);
    row.setText(settings, text);
    EXPECT_FALSE(settings == Settings()) << text;
    checkSettings(settings);
    Settings again;
    row.setText(again, row.textIn(settings));
    EXPECT_TRUE(again == settings) << row.textIn(settings);
    if (const auto number = row.numberIn(settings); number && row.type() != Setting::Type::Natural) {
      row.setNumber(again, number);
      EXPECT_TRUE(again == settings) << *number;
    }
    row.setText(all, text);
    row.setText(settings, ""); // unset
    EXPECT_TRUE(settings == Settings());
  }
  for (const Setting& row : settingsTable()) { // no row changed another's member
    Settings alone;
    row.setText(alone, test::otherText(row));
    EXPECT_EQ(row.textIn(all), row.textIn(alone)) << row.name;
  }
}

TEST(SettingsTable, NumbersKeepAllTheirDigits) {
  Settings settings;
  settings.lossWeight = 1.0 / 3;
  settings.plateau.threshold = 1e-4;
  settings.seed = std::numeric_limits<std::uint64_t>::max();
  EXPECT_EQ(settingNamed("lossWeight").textIn(settings), "0.3333333333333333");
  EXPECT_EQ(settingNamed("plateauThreshold").textIn(settings), "0.0001");
  EXPECT_EQ(settingNamed("seed").textIn(settings), "18446744073709551615");
}

TEST(SettingsTable, WhatIsNoSuchValueIsRefused) {
  EXPECT_NE(refusal("plateauFaktor", "1").find("did you mean plateauFactor"), std::string::npos);
  EXPECT_NE(refusal("Seed", "1").find("did you mean seed"), std::string::npos);
  EXPECT_NE(refusal("preset", "slow").find("fast|balanced|best|paper"), std::string::npos);
  EXPECT_NE(refusal("device", "abacus").find("abacus"), std::string::npos);
  for (const char* text : {"-1", "1.5", "18446744073709551616x", "one"})
    EXPECT_NE(refusal("seed", text), "") << text;
  for (const char* text : {"0", "-3", "1.5", "1e3", "99999999999999999999", "many"})
    EXPECT_NE(refusal("iterations", text), "") << text;
  for (const char* text : {"2,2", "2.2 ", "abc", "nan", "inf", "0.99", "5.01"})
    EXPECT_NE(refusal("cutoff", text), "") << text;
  EXPECT_NE(refusal("relocate", "perhaps"), "");
  Settings settings;
  EXPECT_THROW(settingNamed("preset").setNumber(settings, 4), Error);
  EXPECT_THROW(settingNamed("seed").setNumber(settings, -1), Error);
  EXPECT_THROW(settingNamed("device").setNumber(settings, 1), Error);
  EXPECT_EQ(refusal("cutoff", "9"), "Cut-off radius (cutoff) must be between 1 and 5 σ, not 9.");
}

TEST(SettingsTable, RangesReachToTheirEnds) { // for values outside: JobSettings.OutOfRangeAreRefused
  const auto accepted = [](const Setting& row, double x) {
    Settings settings;
    row.setNumber(settings, x);
    return sentenceOf([&] { row.check(settings); }) == "";
  };
  for (const Setting& row : settingsTable()) {
    if (row.type() != Setting::Type::Real && row.type() != Setting::Type::Integer) continue;
    EXPECT_EQ(accepted(row, row.range.lowest), std::isfinite(row.range.lowest) && !row.range.open)
        << row.name;
    EXPECT_EQ(accepted(row, row.range.highest), std::isfinite(row.range.highest) && !row.range.openHigh)
        << row.name;
  }
}

TEST(SettingsTable, WhatThePresetSaysIsFilledIn) {
  EXPECT_EQ(automaticText(settingNamed("loss")), "l2; preset paper: l1");
  EXPECT_EQ(automaticText(settingNamed("densifyEvery")), "never; preset paper: 10");
  EXPECT_EQ(automaticText(settingNamed("maxGaussians")), "as many as at the start");
  Settings settings;
  settings.loss = LossKind::Huber;
  settings.maxGaussians = 5;
  const Settings filled = withPresetValues(settings);
  EXPECT_EQ(filled.loss, LossKind::Huber);
  EXPECT_EQ(filled.densifyEvery, 10);
  EXPECT_FALSE(filled.gaussians.has_value());
}

/// Only a fit with the same key continues bit for bit.
TEST(SettingsTable, TheKeyOfAFitNamesWhatChangesIt) {
  for (const Setting& row : settingsTable()) {
    Settings plain, changed;
    for (Settings* settings : {&plain, &changed}) { // gives every row an effect
      settings->loss = LossKind::Huber;
      settings->schedule = Schedule::Plateau;
      settings->densifyEvery = 5;
    }
    const bool isOne = row.textIn(plain) == test::otherText(row);
    row.setText(changed, isOne ? row.words.front().name : test::otherText(row));
    const std::string key = settingsKey(changed, "x"), text = settingsText(changed, 0);
    EXPECT_EQ(key != settingsKey(plain, "x"), row.part == Setting::Part::Fit) << row.name;
    EXPECT_EQ(text != settingsText(plain, 0), row.part != Setting::Part::Speed) << row.name;
  }
  EXPECT_NE(settingsKey({}, "x"), settingsKey({}, "y"));
}

TEST(SettingsTable, DocumentationListsIt) {
  std::ifstream file(INNERGS_DOCS "/settings.md");
  std::stringstream text;
  text << file.rdbuf();
  EXPECT_NE(text.str().find(settingsMarkdown()), std::string::npos)
      << "Docs/settings.md must hold this table:\n"
      << settingsMarkdown();
}

} // namespace
} // namespace innergs
