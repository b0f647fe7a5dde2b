#include "CommandRunner.h"
#include "SyntheticImages.h"

#include "Core/Base/NumberText.h"
#include "IO/VolumeIO.h"

#include <itkImageFileReader.h>
#include <itkPNGImageIO.h>
#include <itkRGBPixel.h>

#include <algorithm>
#include <set>
#include <sstream>

namespace innergs::test {
namespace {

using ExperimentTest = CommandTest;

std::vector<std::vector<std::string>> rowsOf(const std::string& csv) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back(1);
    bool quoted = false;
    for (const char c : line) {
      if (c == '"')
        quoted = !quoted;
      else if (c == ',' && !quoted)
        rows.back().emplace_back();
      else
        rows.back().back() += c;
    }
  }
  return rows;
}

/// Every row has one cell per column and says what it was measured on.
void expectTable(const std::vector<std::vector<std::string>>& rows, const std::string& columns) {
  ASSERT_GT(rows.size(), 1u) << columns;
  std::string heading;
  for (const auto& name : rows.front())
    heading += (heading.empty() ? "" : ",") + name;
  EXPECT_EQ(heading, columns);
  for (const auto& row : rows) {
    ASSERT_EQ(row.size(), rows.front().size()) << columns;
    EXPECT_FALSE(row.back().empty()) << columns;
  }
}

/// A picture large enough to look at that is not empty.
void expectPicture(const std::string& file) {
  using Image = itk::Image<itk::RGBPixel<unsigned char>, 2>;
  const auto reader = itk::ImageFileReader<Image>::New();
  reader->SetImageIO(itk::PNGImageIO::New());
  reader->SetFileName(file);
  ASSERT_NO_THROW(reader->Update()) << file;
  const auto size = reader->GetOutput()->GetBufferedRegion().GetSize();
  EXPECT_GE(size[0], 200u) << file;
  EXPECT_GE(size[1], 150u) << file;
  std::set<std::array<unsigned char, 3>> colours;
  const auto* pixels = reader->GetOutput()->GetBufferPointer();
  for (std::size_t n = 0; n < size[0] * size[1]; ++n)
    colours.insert({pixels[n][0], pixels[n][1], pixels[n][2]});
  EXPECT_GE(colours.size(), 8u) << file;
}

TEST_F(ExperimentTest, AllOfThemOnAPhantom) {
  writeVolume(phantom({26, 30, 24}), path("head.nii"));
  const Outcome outcome = run({"experiment", "--all", "--quick", "--volume", path("head.nii"), "--output",
                               path("tables"), "--gaussians", "400", "-q"});
  ASSERT_EQ(outcome.exitCode, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");

  const auto table = [&](const std::string& name) { return rowsOf(contents("tables/" + name + ".csv")); };
  expectTable(table("selection"),
              "selection,box_area,paper_area,false_positives,paper_false_positives,false_negatives,"
              "paper_false_negatives,candidates,paper_candidates,per_contributing,microseconds,"
              "scalar_microseconds,measured_on");
  expectTable(table("contour"), "measure,value,paper,compared,measured_on");
  expectTable(table("text"), "phrases,by,naming_one,top_1,top_3,wrong,side_flipped,suggested,must_not_match,"
                             "false_accepts,any_suggested,ms_a_phrase,ms_unread,slowest_ms,measured_on");
  expectTable(table("static"), "method,plane,gaussians,psnr_db,paper_psnr_db,ssim,paper_ssim,seconds,"
                               "paper_seconds,estimated_memory_mb,measured_on");
  expectTable(table("static-held-out"),
              "method,gaussians,psnr_db,paper_psnr_db,ssim,seconds,estimated_memory_mb,measured_on");
  for (const char* name :
       {"blending", "initialisation", "densification", "optimiser", "gaussians", "selection"}) {
    const std::string densified = name == std::string("densification") ? "pruned,split,cloned," : "";
    expectTable(
        table(std::string("ablation-") + name),
        "choice,gaussians,iterations,psnr_db,paper_psnr_db,ssim,paper_ssim,seconds,ms_iteration,render_ms,"
        "fitted_samples_psnr_db," +
            densified + "measured_on");
    expectTable(table(std::string("ablation-") + name + "-curves"),
                "choice,iteration,seconds,psnr_db,measured_on");
  }
  expectTable(table("ablation-prediction"),
              "case,part,family,psnr_db,over_best_interpolation_db,ssim,seconds,cpu_seconds,measured_on");
  for (const char* name :
       {"contour", "static", "ablation-blending", "ablation-initialisation", "ablation-densification",
        "ablation-optimiser", "ablation-gaussians", "ablation-selection", "ablation-prediction"})
    expectPicture(path(std::string("tables/") + name + ".png"));
  expectTable(table("dynamic"),
              "method,gaussians,psnr_db,ssim,above_linear_db,frames_above_previous,seconds,measured_on");
  expectTable(table("dynamic-frames"), "method,frame,time_s,psnr_db,ssim,measured_on");
  EXPECT_EQ(filesIn("tables").size(), 8u + 6 * 2 + 9);

  // What readers must be told.
  for (const char* words : {"32.47", "145x174x145", "not for 400", "held-out slices (P)",
                            "held-out slices (H)", "Nothing is held out", "not held out"})
    EXPECT_NE(outcome.out.find(words), std::string::npos) << words;
}

TEST_F(ExperimentTest, SegmentationComparesWithLabelsLeftOut) {
  const Volume head = phantom({26, 30, 24});
  Volume labels = head;
  for (float& voxel : labels.voxels)
    voxel = voxel > 500 ? 2.f : voxel > 200 ? 1.f : 0.f;
  writeVolume(head, path("head.nii"));
  writeVolume(labels, path("labels.nii"), OutputType::UInt8);
  write("names.json", R"({"1": "skull", "2": "brain"})");
  const std::vector<std::string> arguments{"experiment",     "segmentation", "--quick",      "--volume",
                                           path("head.nii"), "-o",           path("tables"), "-q"};
  expectOneSentence(run(arguments), 2, "--labels");
  std::vector<std::string> all = arguments;
  for (const std::string& word :
       {std::string("--labels"), path("labels.nii"), std::string("--label-names"), path("names.json")})
    all.push_back(word);
  expectSuccess(run(all));
  const auto rows = rowsOf(contents("tables/segmentation.csv"));
  expectTable(
      rows, "labels,labelled,classes,method,dice,iou,pixel_accuracy,top5_dice,top5_iou,top5_accuracy,seconds,"
            "measured_on");
  ASSERT_EQ(rows.size(), 8u); // three methods with all slices, four with every 5th
  EXPECT_EQ(rows[4].back(), "slices not labelled");
  EXPECT_EQ(rowsOf(contents("tables/segmentation-classes.csv")).size(), 5u);
  EXPECT_EQ(rowsOf(contents("tables/segmentation-grids.csv")).size(), 15u);
  EXPECT_EQ(rowsOf(contents("tables/segmentation-queries.csv")).size(), 2u);
}

TEST_F(ExperimentTest, CoversEveryBlendingAndPlane) {
  writeVolume(phantom({26, 30, 24}), path("head.nii"));
  expectSuccess(run({"experiment", "static", "--quick", "--volume", path("head.nii"), "-o", path("tables"),
                     "--gaussians", "300", "-q"}));
  const auto rows = rowsOf(contents("tables/static.csv"));
  for (const char* method : {"alpha, the paper's training", "alpha", "additive", "normalised", "linear"})
    for (const char* plane : {"axial", "coronal", "sagittal", "average"}) {
      const auto row = std::find_if(rows.begin(), rows.end(),
                                    [&](const auto& r) { return r[0] == method && r[1] == plane; });
      ASSERT_NE(row, rows.end()) << method << " " << plane;
      EXPECT_GT(leadingNumber((*row)[3]).value(), 5) << method << " " << plane;
      const double ssim = leadingNumber((*row)[5]).value();
      EXPECT_GT(ssim, 0.2) << method << " " << plane;
      EXPECT_LT(ssim, 1) << method << " " << plane; // held out, so no method knows it exactly
    }
}

TEST_F(ExperimentTest, SimulationsNeedNoVolume) {
  expectSuccess(run({"experiment", "contour", "selection", "--quick", "-o", path("a/b"), "-q"}));
  const auto rows = rowsOf(contents("a/b/selection.csv"));
  ASSERT_EQ(rows.size(), 4u);
  EXPECT_EQ(rows[3][0], "exact");
  EXPECT_EQ(leadingNumber(rows[3][5]).value(), 0);    // false negatives
  EXPECT_LE(leadingNumber(rows[3][7]).value(), 1.6);  // candidates per pixel
  EXPECT_LE(leadingNumber(rows[3][9]).value(), 1.01); // relative to the contributing ones
  EXPECT_GT(leadingNumber(rows[2][9]).value(), 2);
  EXPECT_EQ(filesIn("a/b").size(), 3u);
}

TEST_F(ExperimentTest, BadArgumentsAreOneSentence) {
  writeVolume(phantom({26, 30, 24}), path("head.nii"));
  const std::string out = path("tables");
  expectOneSentence(run({"experiment", "-o", out}), 2, "--all");
  expectOneSentence(run({"experiment", "selection"}), 2, "--output");
  expectOneSentence(run({"experiment", "selections", "-o", out}), 2, "'selections' is not one of");
  expectOneSentence(run({"experiment", "selection", "--all", "-o", out}), 2, "not both");
  expectOneSentence(run({"experiment", "static", "-o", out}), 2, "--volume");
  expectOneSentence(run({"experiment", "--all", "-o", out}), 2, "--volume");
  expectOneSentence(run({"experiment", "static", "--volume", path("none.nii"), "-o", out}), 1, "none.nii");
  expectOneSentence(
      run({"experiment", "static", "--volume", path("head.nii"), "-o", out, "--gaussians", "0"}), 1,
      "between 1 and");
  expectOneSentence(run({"experiment", "ablation-selection", "--volume", path("head.nii"), "-o", out,
                         "--gaussians", "1000000000", "-q"}),
                    1, "memory");
  expectOneSentence(run({"experiment", "selection", "-o", out, "--instruction-set", "abacus", "-q"}), 1,
                    "abacus");
  write("file", "not a folder");
  expectOneSentence(run({"experiment", "selection", "-o", path("file"), "-q"}), 1, "--output");
  writeVolume(phantom({26, 30, 6}), path("flat.nii"));
  expectOneSentence(run({"experiment", "static", "--volume", path("flat.nii"), "-o", out, "-q"}), 1,
                    "8 slices");
}

} // namespace
} // namespace innergs::test
