#include "ReconstructFixtures.h"
#include "SettingTexts.h"

#include "Core/Job/FoundSlices.h"
#include "IO/N4Correction.h"

#include <vtkDataArray.h>
#include <vtkDoubleArray.h>
#include <vtkImageShiftScale.h>
#include <vtkPointData.h>
#include <vtkTable.h>
#include <vtkVariant.h>

using namespace innergs;
using namespace innergs::testing;

class ReconstructPose : public ::testing::TestWithParam<Pose> {};

TEST_P(ReconstructPose, GivesTheEnginesResultInRAS) {
  for (const bool thick : {false, true}) {
    const ReconstructionInput input = posedInput(GetParam(), thick);
    auto filter = quickFilter(input);
    filter->Update();
    expectSame(filter, reconstruct(input, quickSettings()));
    // The image carries the same position as the matrix.
    EXPECT_TRUE(
        closeTo(filter->GetOutputImage()->GetIndexToPhysicalMatrix(), filter->GetOutputIJKToRASMatrix()));
  }
}

TEST_P(ReconstructPose, TakesTheImagesOwnGeometryWithoutAMatrix) {
  const ReconstructionInput input = posedInput(GetParam(), false);
  const GridGeometry& grid = input.stacks[0].image.geometry;
  auto image = plainImage(input.stacks[0].image);
  image->SetOrigin(-grid.origin[0], -grid.origin[1], grid.origin[2]);
  image->SetSpacing(grid.spacing.data());
  double direction[9];
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c)
      direction[3 * r + c] = (r < 2 ? -1 : 1) * grid.direction[r][c];
  image->SetDirectionMatrix(direction);
  auto filter = quickFilter({});
  filter->AddInputData(image);
  filter->SetInputSliceProfile(0, vtkInnerGSReconstruct::PointProfile);
  filter->SetGeometryInImage(false);
  filter->Update();
  ASSERT_FALSE(filter->GetOutputModel()->IsEmpty()) << filter->GetErrorMessage();
  EXPECT_TRUE(
      closeTo(filter->GetOutputIJKToRASMatrix(), rasMatrix(withSpacing(grid, {0.9, 0.9, 0.9})), 1e-6));
  EXPECT_EQ(filter->GetOutputImage()->GetOrigin()[0], 0);
  EXPECT_EQ(filter->GetOutputImage()->GetSpacing()[1], 1);
  expectSame(filter, reconstruct(input, quickSettings()));
}

INSTANTIATE_TEST_SUITE_P(Poses, ReconstructPose,
                         ::testing::Values(Pose{"Straight", 0, false}, Pose{"Oblique", 0.5, false},
                                           Pose{"LeftHanded", 0, true}, Pose{"ObliqueLeftHanded", 2.1, true}),
                         [](const auto& info) { return info.param.name; });

TEST(ReconstructFilter, PutsSlicesWhereTheirPosesSay) {
  ReconstructionInput input = posedInput({"", 0.5, false}, true);
  Stack& stack = input.stacks.front();
  vtkNew<vtkDoubleArray> poses;
  poses->SetNumberOfComponents(16);
  for (std::int64_t k = 0; k < stack.image.geometry.size[2]; ++k) {
    const double angle = 0.02 * static_cast<double>(k), c = std::cos(angle), s = std::sin(angle);
    const Vec3 shift{0.3 * static_cast<double>(k), -0.2, 0.1 * static_cast<double>(k)};
    stack.poses.push_back({{{{{1, 0, 0}, {0, c, -s}, {0, s, c}}}}, shift});
    const double ras[16] = {1, 0, 0, -shift[0], 0, c, s, -shift[1], 0, -s, c, shift[2], 0, 0, 0, 1};
    poses->InsertNextTuple(ras);
  }
  auto filter = quickFilter(input);
  filter->SetInputSlicePoses(0, poses);
  EXPECT_EQ(filter->GetInputSlicePoses(0), poses);
  EXPECT_GT(filter->EstimateMemory(), 0);
  filter->Update();
  expectSame(filter, reconstruct(input, quickSettings()));

  poses->RemoveLastTuple();
  filter->SetInputSlicePoses(0, nullptr);
  filter->SetInputSlicePoses(0, poses);
  filter->Update();
  EXPECT_NE(filter->GetErrorMessage().find("slice poses"), std::string::npos) << filter->GetErrorMessage();
}

TEST(ReconstructFilter, FusesSeveralInputs) {
  const ReconstructionInput input = orthogonalInput();
  auto filter = quickFilter(input);
  filter->Update();
  const ReconstructionResult expected = reconstruct(input, quickSettings());
  expectSame(filter, expected);
  EXPECT_EQ(filter->GetAgreementNote(), agreementSentence(expected.agreement));
  EXPECT_FALSE(filter->GetAgreementNote().empty());
}

TEST(ReconstructFilter, SaysWhatLiesBetweenSlicesAndHowThickTheyLook) {
  const ReconstructionInput input = inputOf({keepEvery(phantom(grid(40, 36, 41)), 2, 4)});
  auto filter = quickFilter(input);
  filter->Update();
  const ReconstructionResult expected = reconstruct(input, quickSettings());
  EXPECT_FALSE(expected.prediction.empty());
  EXPECT_EQ(filter->GetPredictionNote(), expected.prediction);
  EXPECT_EQ(filter->GetProfileNote(), expected.profiles.sentence);
  EXPECT_EQ(filter->GetAgreementNote(), "");
}

TEST(ReconstructFilter, HasN4) {
  ReconstructionInput input = orthogonalInput();
  auto filter = quickFilter(input);
  ASSERT_TRUE(filter->SetSetting("n4", "true"));
  filter->Update();
  Settings settings = quickSettings();
  settings.n4 = true;
  input.n4 = correctByN4;
  expectSame(filter, reconstruct(input, settings));
  ASSERT_GE(filter->GetNumberOfWarnings(), 2);
  for (int scan = 0; scan < 2; ++scan)
    EXPECT_EQ(filter->GetWarning(scan).find("N4 "), 0u) << filter->GetWarning(scan);
}

TEST(ReconstructFilter, ReadsEveryScalarType) {
  ReconstructionInput input = isotropicInput();
  for (float& v : input.stacks[0].image.voxels)
    v = std::min(120.f, std::round(v * 0.5f)); // fits a signed char
  auto reference = quickFilter(input, 2);
  reference->Update();
  expectSame(reference, reconstruct(input, quickSettings(2)));
  const auto expected = valuesOf(reference->GetOutputImage());
  for (const int type : {VTK_CHAR, VTK_SIGNED_CHAR, VTK_UNSIGNED_CHAR, VTK_SHORT, VTK_UNSIGNED_SHORT, VTK_INT,
                         VTK_UNSIGNED_INT, VTK_LONG, VTK_UNSIGNED_LONG, VTK_LONG_LONG, VTK_UNSIGNED_LONG_LONG,
                         VTK_FLOAT, VTK_DOUBLE}) {
    SCOPED_TRACE(type);
    auto filter = quickFilter({}, 2);
    addInput(filter, 0, input.stacks[0], type);
    filter->Update();
    EXPECT_EQ(valuesOf(filter->GetOutputImage()), expected);
  }
}

TEST(ReconstructFilter, KeepsVoxelsInPlaceWhenTheExtentBeginsElsewhere) {
  const ReconstructionInput input = isotropicInput();
  const Volume& volume = input.stacks[0].image;
  auto shifted = plainImage(volume);
  const auto& n = volume.geometry.size;
  shifted->SetExtent(5, 4 + int(n[0]), -3, -4 + int(n[1]), 2, 1 + int(n[2]));
  Affine3 map = volume.geometry.indexToWorld();
  map.offset = map({-5, 3, -2});
  auto filter = quickFilter({});
  filter->AddInputData(shifted);
  filter->SetInputIJKToRASMatrix(0, rasMatrix(map));
  filter->SetInputSliceProfile(0, vtkInnerGSReconstruct::PointProfile);
  filter->Update();
  EXPECT_EQ(filter->GetErrorMessage(), "");
  EXPECT_TRUE(closeTo(filter->GetOutputIJKToRASMatrix(), rasMatrix(volume.geometry), 1e-6));
}

TEST(ReconstructFilter, CountsSlicesAlongAnotherAxis) {
  ReconstructionInput input = anisotropicInput();
  const Stack& stack = input.stacks[0];
  // The same scan, stored with its slices along I.
  const GridGeometry& g = stack.image.geometry;
  Volume turned;
  turned.geometry.origin = g.origin;
  const int from[3] = {2, 0, 1};
  for (int a = 0; a < 3; ++a) {
    turned.geometry.size[a] = g.size[from[a]];
    turned.geometry.spacing[a] = g.spacing[from[a]];
    for (int r = 0; r < 3; ++r)
      turned.geometry.direction[r][a] = g.direction[r][from[a]];
  }
  for (std::int64_t j = 0; j < g.size[1]; ++j)
    for (std::int64_t i = 0; i < g.size[0]; ++i)
      for (std::int64_t k = 0; k < g.size[2]; ++k)
        turned.voxels.push_back(stack.image.voxels[i + g.size[0] * (j + g.size[1] * k)]);
  auto filter = quickFilter({});
  filter->AddInputData(plainImage(turned));
  filter->SetInputIJKToRASMatrix(0, rasMatrix(turned.geometry));
  filter->SetInputSliceThickness(0, stack.thickness);
  filter->SetInputSliceAxis(0, 0);
  filter->Update();
  const ReconstructionResult expected = reconstruct(input, quickSettings());
  ASSERT_EQ(filter->GetErrorMessage(), "");
  // The result keeps the image's own axes.
  const auto& n = expected.volume.geometry.size;
  const auto values = valuesOf(filter->GetOutputImage());
  ASSERT_EQ(values.size(), expected.volume.voxels.size());
  ASSERT_EQ(filter->GetOutputImage()->GetDimensions()[1], n[0]);
  for (std::int64_t k = 0; k < n[2]; ++k)
    for (std::int64_t j = 0; j < n[1]; ++j)
      for (std::int64_t i = 0; i < n[0]; ++i)
        ASSERT_NEAR(values[k + n[2] * (i + n[0] * j)], expected.volume.voxels[i + n[0] * (j + n[1] * k)],
                    0.1);
}

TEST(ReconstructFilter, MasksEachInputByItsOwn) {
  ReconstructionInput input = posedInput({"Straight", 0, false}, false); // exact: no rounding to follow
  input.stacks.push_back(input.stacks[0]);
  auto filter = quickFilter(input);
  for (int s = 0; s < 2; ++s) {
    const GridGeometry grid = withSpacing(input.stacks[0].image.geometry, {1.7, 1.7, 1.7});
    const double face = grid.centre()[0] + 0.37 + 4 * s;
    const Volume inside = volumeInSpace(grid, [&](const Vec3& x) { return x[0] < face ? 1 : 0; });
    input.masks.push_back({grid, {inside.voxels.begin(), inside.voxels.end()}});
    filter->AddMaskData(plainImage(inside, VTK_UNSIGNED_CHAR));
    filter->SetMaskIJKToRASMatrix(s, rasMatrix(grid));
  }
  filter->Update();
  expectSame(filter, reconstruct(input, quickSettings()));
  filter->AddMaskData(plainImage(input.stacks[0].image, VTK_UNSIGNED_CHAR));
  filter->Update();
  EXPECT_NE(filter->GetErrorMessage().find("3 masks for 2 scans"), std::string::npos)
      << filter->GetErrorMessage();
}

TEST(ReconstructFilter, MasksAndHoldsOutSlices) {
  ReconstructionInput input = posedInput({"Straight", 0, false}, false); // exact: no rounding to follow
  const GridGeometry& g = input.stacks[0].image.geometry;
  input.masks = {Mask{withSpacing(g, {1.7, 1.7, 1.7}), {}}};
  Volume inside = volumeInSpace(input.masks.front().geometry,
                                [&](const Vec3& x) { return x[0] < g.centre()[0] + 0.37 ? 3 : 0; });
  for (const float v : inside.voxels)
    input.masks.front().voxels.push_back(v != 0);
  input.heldOutFraction = 0.2;
  auto filter = quickFilter(input);
  filter->SetMaskData(plainImage(inside, VTK_UNSIGNED_CHAR));
  filter->SetMaskIJKToRASMatrix(rasMatrix(inside.geometry));
  filter->SetHeldOutFraction(0.2);
  filter->Update();
  const ReconstructionResult expected = reconstruct(input, quickSettings());
  expectSame(filter, expected);
  EXPECT_DOUBLE_EQ(filter->GetHeldOutPSNR(), expected.heldOutPsnr);
  EXPECT_GT(expected.heldOutSlices, 0);
  EXPECT_EQ(filter->GetNumberOfHeldOutSlices(), expected.heldOutSlices);
  EXPECT_EQ(filter->GetQualityState(), vtkInnerGSReconstruct::QualityMeasured);
  EXPECT_DOUBLE_EQ(filter->GetTrainingPSNR(), expected.trainingPsnr);
  EXPECT_NE(filter->GetUsedSettings().find("heldOutFraction=0.2"), std::string::npos);
  input.heldOutFraction = 0;
  filter->SetHeldOutFraction(0);
  filter->Update();
  expectSame(filter, reconstruct(input, quickSettings()));
  EXPECT_EQ(filter->GetOutputModel()->GetCoreModel()->settingsKey, expected.model->settingsKey)
      << "of all slices, whatever was held out to judge it";
  EXPECT_TRUE(std::isnan(filter->GetHeldOutPSNR()));
  EXPECT_EQ(filter->GetQualityState(), vtkInnerGSReconstruct::QualityNotAsked);
}

TEST(ReconstructFilter, TellsWhereSlicesLie) {
  ReconstructionInput input = headInput();
  ASSERT_GT(input.stacks.size(), 1u);
  auto filter = quickFilter(input, 2);
  filter->SetSetting("sliceMotion", "on");
  filter->Update();
  ASSERT_EQ(filter->GetErrorMessage(), "");
  EXPECT_TRUE(filter->GetSlicesMoved());
  Settings settings = quickSettings(2);
  settings.sliceMotion = SliceMotionKind::On;
  const ReconstructionResult expected = reconstruct(input, settings);
  const std::vector<FoundSlice> found = foundSlices(expected);
  vtkTable* table = filter->GetSliceTable();
  vtkIdType row = 0;
  for (std::size_t scan = 0; scan < input.stacks.size(); ++scan)
    for (std::int64_t slice = 0; slice < input.stacks[scan].image.geometry.size[2]; ++slice, ++row) {
      ASSERT_LT(row, table->GetNumberOfRows());
      EXPECT_EQ(table->GetValueByName(row, "Scan").ToInt(), static_cast<int>(scan) + 1);
      EXPECT_EQ(table->GetValueByName(row, "Slice").ToInt(), static_cast<int>(slice));
      const auto& pose = expected.sliceMotion.slices[scan][static_cast<std::size_t>(slice)];
      EXPECT_NEAR(table->GetValueByName(row, "Weight").ToDouble(), pose.weight, 0.02);
      EXPECT_NEAR(table->GetValueByName(row, "Displacement (mm)").ToDouble(), pose.displacement, 0.02);
      const Vec3 x{10, -20, 30}, lies = found[static_cast<std::size_t>(row)].place(x);
      const double ras[] = {-x[0], -x[1], x[2], 1}, expectedRAS[] = {-lies[0], -lies[1], lies[2]};
      for (int r = 0; r < 3; ++r) {
        double found = 0;
        for (int c = 0; c < 4; ++c)
          found +=
              table->GetValueByName(row, ("M" + std::to_string(r) + std::to_string(c)).c_str()).ToDouble() *
              ras[c];
        EXPECT_NEAR(found, expectedRAS[r], 0.02); // see expectSame
      }
    }
  EXPECT_EQ(row, table->GetNumberOfRows());
  filter->SetSetting("sliceMotion", "off");
  filter->Update();
  EXPECT_FALSE(filter->GetSlicesMoved());
  EXPECT_EQ(filter->GetSliceTable()->GetNumberOfRows(), 0);
}

TEST(ReconstructFilter, SaysHowFarItsImageMayBeOff) {
  ReconstructionInput input = headInput();
  auto filter = quickFilter(input, 4);
  filter->SetSetting("sliceMotion", "off");
  const vtkTypeInt64 before = filter->EstimateMemory();
  filter->EstimateUncertaintyOn();
  EXPECT_GT(filter->EstimateMemory(), before);
  filter->Update(2);
  ASSERT_EQ(filter->GetErrorMessage(), "");
  Settings settings = quickSettings(4);
  settings.sliceMotion = SliceMotionKind::Off;
  input.uncertainty = true;
  const ReconstructionResult expected = reconstruct(input, settings);
  ASSERT_TRUE(expected.uncertainty);
  vtkImageData* deviation = filter->GetOutputStandardDeviation();
  const auto values = valuesOf(deviation);
  ASSERT_EQ(values.size(), expected.uncertainty->deviation.voxels.size());
  EXPECT_GT(psnr({{}, values}, expected.uncertainty->deviation), 40);
  EXPECT_STREQ(deviation->GetPointData()->GetScalars()->GetName(), "StandardDeviation");
  vtkDataArray* measured = deviation->GetPointData()->GetArray("Measured");
  ASSERT_NE(measured, nullptr);
  std::size_t same = 0;
  for (std::size_t v = 0; v < values.size(); ++v)
    same += measured->GetTuple1(static_cast<vtkIdType>(v)) == expected.uncertainty->measured[v];
  EXPECT_GT(static_cast<double>(same), 0.99 * static_cast<double>(values.size()));
  EXPECT_NEAR(filter->GetUncertaintyCoverage(), expected.uncertainty->coverage, 0.01);
  EXPECT_NE(filter->GetUncertaintyNote().find("90 % intervals"), std::string::npos);
  EXPECT_EQ(filter->GetQualityState(), vtkInnerGSReconstruct::QualityMeasured);
  filter->EstimateUncertaintyOff();
  filter->Update(2);
  EXPECT_EQ(filter->GetOutputStandardDeviation()->GetNumberOfPoints(), 0);
  EXPECT_TRUE(std::isnan(filter->GetUncertaintyCoverage()));
  EXPECT_EQ(filter->GetUncertaintyNote(), "");
  EXPECT_GT(filter->GetOutputImage()->GetNumberOfPoints(), 0);
}

TEST(ReconstructFilter, CutsTheImageToTheMasksBox) {
  ReconstructionInput input = isotropicInput();
  const GridGeometry& g = input.stacks[0].image.geometry;
  const Volume inside = volumeInSpace(g, [&](const Vec3& x) { return norm(x - g.centre()) < 5; });
  for (const bool snapshot : {false, true}) {
    auto filter = quickFilter(input, 2);
    Observer runs(filter, vtkCommand::StartEvent, [](void*) {});
    filter->SetMaskData(plainImage(inside, VTK_UNSIGNED_CHAR));
    filter->SetMaskIJKToRASMatrix(rasMatrix(g));
    filter->SetFillValue(-9);
    if (snapshot) {
      ASSERT_TRUE(filter->TakeSnapshot());
    }
    filter->Update();
    ASSERT_EQ(filter->GetErrorMessage(), "");
    EXPECT_EQ(filter->GetOutputImage()->GetDimensions()[0], 12);
    const auto values = valuesOf(filter->GetOutputImage());
    EXPECT_EQ(values[0], -9) << "a corner of the box";
    filter->Update(1);
    if (!snapshot) {
      EXPECT_EQ(runs.count, 1) << "what was put out is what the pipeline expects";
    }
    vtkInnerGSModel* model = filter->GetOutputModel();
    EXPECT_TRUE(model->IsMasked());
    EXPECT_EQ(model->GetFillValue(), -9);
    vtkNew<vtkMatrix4x4> matrix;
    int size[3];
    ASSERT_TRUE(model->GetDomain(matrix, size));
    EXPECT_EQ(size[0], 12);
    EXPECT_TRUE(closeTo(matrix, filter->GetOutputIJKToRASMatrix()));
  }
  auto whole = quickFilter(input, 2);
  whole->SetMaskData(plainImage(inside, VTK_UNSIGNED_CHAR));
  whole->SetMaskIJKToRASMatrix(rasMatrix(g));
  whole->SetReferenceGrid(rasMatrix(g), int(g.size[0]), int(g.size[1]), int(g.size[2]));
  whole->Update();
  EXPECT_EQ(whole->GetOutputImage()->GetDimensions()[0], g.size[0]) << "a grid that was given";
}

TEST(ReconstructFilter, ExecutesAgainOnlyWhenSomethingChanged) {
  const ReconstructionInput input = isotropicInput();
  auto filter = quickFilter(input, 2);
  Observer runs(filter, vtkCommand::StartEvent, [](void*) {});
  filter->Update();
  filter->Update();
  filter->SetSeed(filter->GetSeed());
  filter->SetInputIJKToRASMatrix(0, rasMatrix(input.stacks[0].image.geometry));
  filter->SetInputSliceThickness(0, filter->GetInputSliceThickness(0));
  filter->SetInputName(0, "");
  filter->Update(1);
  EXPECT_EQ(runs.count, 1);
  const auto before = valuesOf(filter->GetOutputImage());
  filter->SetSeed(7);
  filter->Update();
  EXPECT_EQ(runs.count, 2);
  EXPECT_NE(valuesOf(filter->GetOutputImage()), before);
  filter->SetSeed(1);
  filter->SetNumberOfThreads(1);
  filter->Update();
  EXPECT_EQ(runs.count, 3);
  EXPECT_EQ(valuesOf(filter->GetOutputImage()), before);
  vtkNew<vtkMatrix4x4> moved;
  moved->DeepCopy(filter->GetInputIJKToRASMatrix(0));
  moved->SetElement(2, 3, moved->GetElement(2, 3) + 10);
  filter->SetInputIJKToRASMatrix(0, moved);
  filter->Update();
  EXPECT_EQ(runs.count, 4);
  EXPECT_NEAR(filter->GetOutputIJKToRASMatrix()->GetElement(2, 3), moved->GetElement(2, 3), 1e-9);
  vtkImageData::SafeDownCast(filter->GetInputDataObject(0, 0))->Modified();
  filter->Update();
  EXPECT_EQ(runs.count, 5);
}

TEST(ReconstructFilter, WorksInAPipeline) {
  const ReconstructionInput input = isotropicInput();
  vtkNew<vtkImageShiftScale> scale; // upstream
  scale->SetInputData(plainImage(input.stacks[0].image));
  scale->SetScale(2);
  auto filter = quickFilter({}, 3);
  filter->AddInputConnection(0, scale->GetOutputPort());
  vtkNew<vtkImageShiftScale> half; // downstream
  half->SetInputConnection(filter->GetOutputPort(1));
  half->SetScale(0.5);
  half->Update();
  EXPECT_EQ(filter->GetErrorMessage(), "");
  int size[3];
  half->GetOutput()->GetDimensions(size);
  for (int a = 0; a < 3; ++a)
    EXPECT_EQ(size[a], input.stacks[0].image.geometry.size[a]);
  EXPECT_NEAR(half->GetOutput()->GetScalarRange()[1], 200, 40);
}

TEST(ReconstructFilter, WorksOnASnapshotWithoutTouchingItsInputs) {
  const ReconstructionInput input = orthogonalInput();
  auto filter = quickFilter(input);
  auto image = vtkSmartPointer<vtkImageData>(vtkImageData::SafeDownCast(filter->GetInputDataObject(0, 0)));
  const vtkTypeInt64 estimate = filter->EstimateMemory();
  EXPECT_GT(estimate, 1000000);
  ASSERT_TRUE(filter->TakeSnapshot());
  EXPECT_EQ(filter->GetNumberOfInputConnections(0), 0);
  EXPECT_EQ(filter->EstimateMemory(), estimate);
  std::fill_n(static_cast<float*>(image->GetScalarPointer()), image->GetNumberOfPoints(), -1.f);
  filter->Update();
  expectSame(filter, reconstruct(input, quickSettings()));
  EXPECT_FALSE(filter->HasSnapshot());
  filter->Update(); // nothing has changed
  EXPECT_FALSE(filter->GetOutputModel()->IsEmpty());
}

TEST(ReconstructFilter, EstimatesItsTimeBeforeTheStart) {
  vtkNew<vtkInnerGSReconstruct> none;
  EXPECT_EQ(none->EstimateSeconds(), 0);
  auto filter = quickFilter(orthogonalInput());
  filter->SetDevice("cpu");
  const double seconds = filter->EstimateSeconds();
  EXPECT_GT(seconds, 0);
  filter->SetNumberOfIterations(10000);
  const double longer = filter->EstimateSeconds();
  EXPECT_GT(longer, seconds);
  EXPECT_TRUE(std::isfinite(longer));
  ASSERT_TRUE(filter->TakeSnapshot());
  EXPECT_EQ(filter->EstimateSeconds(), longer);
  Errors errors(filter);
  filter->SetNumberOfIterations(0);
  EXPECT_EQ(filter->EstimateSeconds(), 0);
  EXPECT_EQ(errors.texts.size(), 1u);
}

TEST(ReconstructFilter, SaysWhereItRunsAndWhy) {
  auto filter = quickFilter(isotropicInput());
  filter->SetDevice("cpu");
  const std::string onTheCpu = filter->DescribeDevice();
  EXPECT_NE(onTheCpu.find("CPU"), std::string::npos) << onTheCpu;
  EXPECT_EQ(filter->GetDeviceNote(), "");
  std::vector<std::string> notes;
  Observer progress(filter, vtkCommand::ProgressEvent, [&](void*) {
    if (filter->GetPhase() == "Fitting") notes.push_back(filter->GetDeviceNote());
  });
  filter->Update();
  ASSERT_GE(notes.size(), 10u);
  for (const std::string& note : notes)
    EXPECT_EQ(note, onTheCpu);
  EXPECT_EQ(filter->GetDeviceNote(), onTheCpu);
  filter->SetDevice("cuda:999");
  const std::string refusal = filter->DescribeDevice();
  Errors errors(filter);
  filter->Update();
  ASSERT_EQ(errors.texts.size(), 1u);
  EXPECT_EQ(refusal, filter->GetErrorMessage());
  EXPECT_EQ(filter->GetDeviceNote(), "");
}

TEST(ReconstructFilter, HandsOutPreviewsWhileItRuns) {
  const ReconstructionInput input = isotropicInput();
  auto filter = quickFilter(input, 1000000);
  vtkSmartPointer<vtkImageData> kept;
  Observer previews(filter, vtkInnerGSReconstruct::PreviewEvent, [&](void* data) {
    kept = static_cast<vtkImageData*>(data);
    filter->AbortExecuteOn();
  });
  filter->Update();
  EXPECT_EQ(previews.count, 1);
  EXPECT_TRUE(filter->GetAborted());
  ASSERT_TRUE(kept);
  EXPECT_EQ(kept->GetNumberOfPoints(), input.stacks[0].image.geometry.voxelCount());
  EXPECT_TRUE(closeTo(filter->GetPreviewIJKToRASMatrix(), rasMatrix(input.stacks[0].image.geometry)));
  EXPECT_NEAR(kept->GetScalarRange()[1], 200, 40);
}

/// By name, as listed in the table; rejected values change nothing.
TEST(Settings, AreReachedByName) {
  vtkNew<vtkInnerGSReconstruct> filter;
  Errors errors(filter);
  const Settings before = filter->GetSettings();
  EXPECT_TRUE(before == Settings());
  EXPECT_EQ(filter->GetNumberOfSettings(), static_cast<int>(settingsTable().size()));
  for (const Setting& row : settingsTable()) {
    SCOPED_TRACE(row.name);
    const auto time = filter->GetMTime();
    EXPECT_TRUE(filter->SetSetting(row.name, test::otherText(row)));
    EXPECT_GT(filter->GetMTime(), time);
    EXPECT_EQ(filter->GetSetting(row.name), row.textIn(filter->GetSettings()));
    EXPECT_FALSE(filter->GetSettings() == before);
    EXPECT_TRUE(filter->UnsetSetting(row.name));
    EXPECT_TRUE(filter->GetSettings() == before);
  }
  EXPECT_TRUE(errors.texts.empty());
  for (const auto& [name, text] : {std::pair{"plateauFactor", "2"}, {"device", "abacus"}, {"nothing", "5"}})
    EXPECT_FALSE(filter->SetSetting(name, text)) << name;
  filter->SetPreset(17);
  EXPECT_EQ(errors.texts.size(), 4u);
  EXPECT_TRUE(filter->GetSettings() == before);
  filter->SetPreset(vtkInnerGSReconstruct::Paper);
  EXPECT_EQ(filter->GetSetting("preset"), "paper");
  EXPECT_EQ(filter->GetBlending(), vtkInnerGSReconstruct::Automatic);
  filter->SetNumberOfThreads(3);
  EXPECT_EQ(filter->GetSetting("threads"), "3");
}
