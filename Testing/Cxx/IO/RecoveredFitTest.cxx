#include "IO/RecoveredFit.h"

#include "IO/DynamicModelFile.h"
#include "IO/ModelFile.h"
#include "TestFiles.h"

#include "TestFields.h"

namespace innergs::test {
namespace {

Model stopped() {
  Model model;
  model.field = randomField(5, true);
  model.iteration = 37;
  model.optimizer.moment1.assign(80, 0.5f);
  model.optimizer.moment2.assign(80, 0.25f);
  return model;
}

TEST(RecoveredFit, SaysWhatItTakesToGoOn) {
  const TemporaryFolder folder;
  RecoveredFit about;
  about.inputs = "Kopf ä/ö: T2*; T1";
  about.mask = "Brain";
  about.settings.preset = Preset::Best;
  about.settings.iterations = 240;
  about.settings.seed = 1234567890123456789u;
  about.settings.device = "cpu";
  about.iterations = 480;
  const auto file = writeRecoveredFit(stopped(), about, folder / "new" / "recovery");
  const auto found = recoveredFits(folder / "new" / "recovery");
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].file, file);
  EXPECT_EQ(found[0].inputs, about.inputs);
  EXPECT_EQ(found[0].mask, about.mask);
  EXPECT_EQ(found[0].settings, about.settings);
  EXPECT_EQ(found[0].iteration, 37);
  EXPECT_EQ(found[0].iterations, 480);
  ModelNotes notes;
  EXPECT_EQ(readModel(file, &notes).optimizer.moment1, stopped().optimizer.moment1);
  EXPECT_EQ(notes["Inputs"], about.inputs);
}

TEST(RecoveredFit, OfAMovingScan) {
  const TemporaryFolder folder;
  StoppedDynamicFit fit;
  fit.field.kind = DynamicKind::Intensity; // the smallest field there is; the state is what counts
  fit.field.canonical = randomField(5, true);
  fit.field.times = {0, 0.7};
  fit.field.change = {0, 0.7, 4};
  fit.field.changes.assign(20, 1.f);
  fit.state.step = 12;
  fit.state.key = "key";
  fit.state.steps = {12};
  fit.state.moments.assign(8, 0.5f);
  RecoveredFit about;
  about.inputs = "Wrist";
  about.settings.kind = DynamicKind::Motion;
  about.settings.knots = 9;
  about.iterations = 400;
  about.interval = 0.7;
  const auto first = writeRecoveredFit(fit, about, folder.path());
  const auto found = recoveredFits(folder.path());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_TRUE(found[0].dynamic);
  EXPECT_EQ(found[0].settings, about.settings);
  EXPECT_EQ(found[0].iteration, 12);
  EXPECT_EQ(found[0].iterations, 400);
  EXPECT_EQ(found[0].interval, 0.7);
  EXPECT_EQ(readStoppedFit(first)->state.moments, fit.state.moments);
  dropRecoveredFit(first, folder / "elsewhere");
  EXPECT_TRUE(std::filesystem::exists(first));
  dropRecoveredFit(first, folder.path());
  EXPECT_FALSE(std::filesystem::exists(first));
}

TEST(RecoveredFit, OfAStoppedMovingScanOnlyWhereThereIsAState) {
  const TemporaryFolder folder;
  DynamicResult result;
  RecoveredFit about;
  about.inputs = "Wrist";
  writeStoppedFit(result, about, folder.path());
  DynamicField field;
  field.kind = DynamicKind::Intensity;
  field.canonical = randomField(5, true);
  field.times = {0, 0.7};
  field.change = {0, 0.7, 4};
  field.changes.assign(20, 1.f);
  result.field = std::make_shared<const DynamicField>(field);
  writeStoppedFit(result, about, folder.path());
  EXPECT_TRUE(about.file.empty());
  EXPECT_TRUE(recoveredFits(folder.path()).empty());
  result.state.step = 12;
  result.state.key = "key";
  result.state.steps = {12};
  result.state.moments.assign(8, 0.5f);
  result.steps = 400;
  writeStoppedFit(result, about, folder.path());
  const auto found = recoveredFits(folder.path());
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].file, about.file);
  EXPECT_TRUE(found[0].dynamic);
  EXPECT_EQ(found[0].iteration, 12);
  EXPECT_EQ(found[0].iterations, 400);
}

TEST(RecoveredFit, OthersFilesAreNone) {
  const TemporaryFolder folder;
  EXPECT_TRUE(recoveredFits(folder / "missing").empty());
  writeModel(stopped(), folder / "a model.innergs", {{"Inputs", "T2"}});
  writeBytes(folder / "damaged.innergs", "no model");
  EXPECT_TRUE(recoveredFits(folder.path()).empty());
}

TEST(RecoveredFit, TheNewestTenStay) {
  const TemporaryFolder folder;
  RecoveredFit about;
  about.inputs = std::string(200, 'x'); // longer than a file's name may be
  std::vector<std::filesystem::path> written;
  for (int n = 0; n < 12; ++n) {
    written.push_back(writeRecoveredFit(stopped(), about, folder.path()));
    // as minutes apart
    std::filesystem::last_write_time(written.back(), std::filesystem::file_time_type::clock::now() -
                                                         std::chrono::minutes(20 - n));
  }
  const auto found = recoveredFits(folder.path());
  ASSERT_EQ(found.size(), 10u);
  EXPECT_EQ(found.front().file, written.back());
  EXPECT_EQ(found.back().file, written[2]);
}

TEST(RecoveredFit, AFolderThatCannotBeMadeIsRefused) {
  const TemporaryFolder folder;
  writeBytes(folder / "file", "x");
  EXPECT_THROW(writeRecoveredFit(stopped(), {}, folder / "file"), Error);
}

} // namespace
} // namespace innergs::test
