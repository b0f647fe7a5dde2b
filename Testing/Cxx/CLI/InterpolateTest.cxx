#include "CommandRunner.h"
#include "SyntheticImages.h"

#include "IO/TimeSeriesIO.h"
#include "IO/TimeSeriesWriting.h"
#include "IO/VolumeIO.h"

#include <itkImage.h>
#include <itkImageFileReader.h>
#include <itkNiftiImageIO.h>
#include <itkNrrdImageIO.h>
#include <itkWarpImageFilter.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace innergs::test {
namespace {

using InterpolateTest = CommandTest;

TEST_F(InterpolateTest, FramesAtAnyTimeAndAModelThatGivesMore) {
  writeTimeSeries(movingBlob(6), path("in.nii.gz"));
  expectSuccess(
      run({"interpolate", path("in.nii.gz"), "--rate", "4", "-o", path("out.seq.nrrd"), "--save-model",
           path("m.innergs"), "--report", path("r.json"), "--kind", "motion", "-q"}));
  const TimeSeries out = readTimeSeries(path("out.seq.nrrd"));
  ASSERT_EQ(out.size(), 11);
  EXPECT_NEAR(out.times[3], 0.75, 1e-9);
  const auto report = nlohmann::json::parse(contents("r.json"));
  EXPECT_EQ(report.at("kind"), "motion");
  EXPECT_EQ(report.at("output_times_s").size(), 11u);
  EXPECT_EQ(report.at("settings").at("kind"), "motion");
  EXPECT_TRUE(report.at("settings").at("knots").is_null());
  EXPECT_FALSE(report.at("settings").contains("preset"));

  expectSuccess(run({"interpolate", path("m.innergs"), "--at", "0.75", "-o", path("one.nrrd"), "-q"}));
  const Volume one = readVolume(path("one.nrrd"));
  ASSERT_EQ(one.voxels.size(), out.frames[3].size());
  for (std::size_t v = 0; v < one.voxels.size(); ++v)
    ASSERT_NEAR(one.voxels[v], out.frames[3][v], 1e-3);
  const auto info = nlohmann::json::parse(run({"info", path("m.innergs"), "--json"}).out);
  EXPECT_EQ(info.at("changes_by"), "motion");
  EXPECT_EQ(info.at("frames"), 6);
  expectOneSentence(run({"resample", path("m.innergs"), "-o", path("a.nii")}), 1, "dynamic scan");
}

/// ITK's own warping of one frame by a displacement field brings it onto the other.
TEST_F(InterpolateTest, MotionIsADisplacementFieldOfItk) {
  using Image = itk::Image<float, 3>;
  using Field = itk::Image<itk::Vector<float, 3>, 3>;
  const TimeSeries series = movingBlob(6);
  writeTimeSeries(series, path("in.nii.gz"));
  expectSuccess(run({"interpolate", path("in.nii.gz"), "--kind", "motion", "--save-model", path("m.innergs"),
                     "--motion", path("d.nrrd"), "--motion-from", "1", "-q"}));
  for (int f = 0; f < 6; ++f)
    EXPECT_TRUE(exists("d-00" + std::to_string(f) + ".nrrd"));
  expectSuccess(run({"interpolate", path("m.innergs"), "--motion", path("d.nii.gz"), "--motion-from", "1",
                     "--at", "2.5", "-q"}));
  for (const auto& [file, io] :
       {std::pair<std::string, itk::ImageIOBase::Pointer>{"d-005.nrrd", itk::NrrdImageIO::New().GetPointer()},
        {"d.nii.gz", itk::NiftiImageIO::New().GetPointer()}}) {
    auto reader = itk::ImageFileReader<Field>::New();
    reader->SetImageIO(io);
    reader->SetFileName(path(file));
    reader->Update();
    auto moved = Image::New();
    moved->CopyInformation(reader->GetOutput());
    moved->SetRegions(reader->GetOutput()->GetLargestPossibleRegion());
    moved->Allocate();
    std::copy(series.frames[5].begin(), series.frames[5].end(), moved->GetBufferPointer());
    auto warp = itk::WarpImageFilter<Image, Image, Field>::New();
    warp->SetInput(moved);
    warp->SetDisplacementField(reader->GetOutput());
    warp->SetOutputParametersFromImage(reader->GetOutput());
    warp->Update();
    double before = 0, after = 0;
    for (std::size_t v = 0; v < series.frames[2].size(); ++v) {
      const auto onto = static_cast<double>(series.frames[2][v]);
      before += std::pow(static_cast<double>(series.frames[5][v]) - onto, 2);
      after += std::pow(static_cast<double>(warp->GetOutput()->GetBufferPointer()[v]) - onto, 2);
    }
    EXPECT_LT(after, 0.05 * before) << file; // the other way round it would grow
    const Field::PixelType at = reader->GetOutput()->GetPixel({7, 6, 2});
    EXPECT_NEAR(at[0], 2.4, 0.6) << file; // mm: 0.8 voxels of 1 mm a frame, of a smooth blob
    EXPECT_NEAR(at[1], 0, 0.2) << file;
  }
  expectSuccess(run({"interpolate", path("m.innergs"), "--motion", path("d.seq.nrrd"), "-q"}));
  EXPECT_NE(contents("d.seq.nrrd").find("axis 3 index values:=0 0.5 1 1.5 2 2.5"), std::string::npos);
  expectOneSentence(run({"interpolate", path("m.innergs"), "--motion", path("d.png")}), 1, ".seq.nrrd");
  expectOneSentence(run({"interpolate", path("m.innergs"), "--motion", path("d.nrrd"), "--motion-from", "9"}),
                    1, "outside");
  expectOneSentence(
      run({"interpolate", path("in.nii.gz"), "--motion", path("d.nrrd"), "--kind", "intensity"}), 2, "move");
}

/// A still blob that glows, each slice seen at its own time, even slices first.
TEST_F(InterpolateTest, SliceTimesOfAChosenFileShowMomentsBetter) {
  TimeSeries series, truth;
  series.geometry.size = truth.geometry.size = {16, 12, 6};
  const double order[] = {0, 3, 1, 4, 2, 5};
  const auto sliceAt = [&](int k, double time, std::vector<float>& frame) {
    const double glow = 100 * (1 + 0.3 * std::sin(2 * 3.14159265 * time / 14));
    for (int j = 0; j < 12; ++j)
      for (int i = 0; i < 16; ++i)
        frame.push_back(static_cast<float>(
            glow * std::exp(-0.02 * (std::pow(i - 8, 2) + std::pow(j - 6, 2) + 0.3 * std::pow(k - 3, 2)))));
  };
  for (int f = 0; f < 42; ++f) {
    series.times.push_back(2 * f);
    auto& frame = series.frames.emplace_back();
    for (int k = 0; k < 6; ++k)
      sliceAt(k, 2 * f + order[k] / 3, frame);
  }
  for (int k = 0; k < 6; ++k)
    sliceAt(k, 41, truth.frames.emplace_back());
  writeTimeSeries(series, path("in.nii.gz"));
  write("task.json", R"({"SliceTiming": [0, 1, 0.33333, 1.33333, 0.66667, 1.66667]})");
  write("task.txt", "0 1 0.33333\n1.33333 0.66667 1.66667\n");
  const auto error = [&](std::vector<std::string> more, bool used) {
    std::vector<std::string> words{"interpolate", path("in.nii.gz"), "--kind",   "intensity",    "--at", "41",
                                   "-o",          path("o.nii"),     "--report", path("r.json"), "-q"};
    words.insert(words.end(), more.begin(), more.end());
    expectSuccess(run(words));
    EXPECT_EQ(nlohmann::json::parse(contents("r.json")).at("slice_times_used"), used);
    const Volume found = readVolume(path("o.nii"));
    double sum = 0;
    for (std::size_t v = 0; v < found.voxels.size(); ++v)
      sum += std::pow(found.voxels[v] - truth.frames[v / (16 * 12)][v % (16 * 12)], 2);
    return sum;
  };
  const double ignored = error({}, false), json = error({"--slice-times", path("task.json")}, true);
  EXPECT_LT(json, 0.5 * ignored);
  EXPECT_EQ(error({"--slice-times", path("task.txt")}, true), json);
  EXPECT_EQ(error({"--slice-times", path("task.json"), "--no-slice-timing"}, false), ignored);
  write("short.json", R"({"SliceTiming": [0, 1]})");
  expectOneSentence(
      run({"interpolate", path("in.nii.gz"), "-o", path("p.nii"), "--slice-times", path("short.json")}), 1,
      "2 slice times for 6 slices");
  expectOneSentence(
      run({"interpolate", path("in.nii.gz"), "-o", path("p.nii"), "--slice-times", path("gone.json")}), 1,
      "gone.json");
}

TEST_F(InterpolateTest, WhatIsWrongIsOneSentence) {
  const TimeSeries series = movingBlob(3);
  writeTimeSeries(series, path("in.nii.gz"));
  writeVolume({series.geometry, series.frames[0]}, path("one.nii.gz"));
  expectOneSentence(run({"interpolate", path("one.nii.gz"), "-o", path("o.nii")}), 1, "single frame");
  expectOneSentence(run({"interpolate", path("none.nii.gz"), "-o", path("o.nii")}), 1);
  expectOneSentence(run({"interpolate", path("in.nii.gz")}), 2, "--output");
  expectOneSentence(run({"interpolate", path("in.nii.gz"), "-o", path("o.mha")}), 1, ".seq.nrrd");
  expectOneSentence(run({"interpolate", path("in.nii.gz"), "-o", path("o.nii"), "--times", "0,9"}), 1, "9 s");
  expectOneSentence(run({"interpolate", path("in.nii.gz"), "-o", path("o.nii"), "--times", "0.5,0.2"}), 1,
                    "increase");
  expectOneSentence(
      run({"interpolate", path("in.nii.gz"), "-o", path("o.nii"), "--times", "0.5", "--rate", "2"}), 2,
      "one of");
  expectOneSentence(run({"interpolate", path("in.nii.gz"), "-o", path("o.nii"), "--frame-times", "0,1"}), 1,
                    "frames");
  expectOneSentence(run({"interpolate", path("in.nii.gz"), "-o", path("in.nii.gz")}), 1, "overwrite");
  expectOneSentence(run({"interpolate", path("in.nii.gz"), "-o", path("o.nii"), "--kind", "warp"}), 2,
                    "motion|intensity|network");
  expectOneSentence(run({"interpolate", path("in.nii.gz"), "-o", path("o.nii"), "--times", "0,0.1,1",
                         "--report", path("o.json")}),
                    1, "one file"); // uneven times go to the sidecar
  EXPECT_FALSE(exists("o.nii"));
}

} // namespace
} // namespace innergs::test
