#include "Fixtures.h"

#include "vtkInnerGSPlaneQuery.h"
#include "vtkInnerGSPointQuery.h"
#include "vtkInnerGSResample.h"
#include "vtkInnerGSToPolyData.h"

#include <vtkExecutive.h>
#include <vtkFloatArray.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>

#include <limits>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// Breaks a working filter, and gives what the message must contain.
struct Wrong {
  const char* name;
  void (*make)(vtkInnerGSReconstruct* filter);
  const char* sentence;
  unsigned long code;
};

void setElement(vtkInnerGSReconstruct* filter, int row, int column, double value) {
  vtkNew<vtkMatrix4x4> matrix;
  matrix->DeepCopy(filter->GetInputIJKToRASMatrix(0));
  matrix->SetElement(row, column, value);
  filter->SetInputIJKToRASMatrix(0, matrix);
}

vtkSmartPointer<vtkImageData> otherImage(int components, int nx = 24) {
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(nx, 22, 20);
  if (components > 0) image->AllocateScalars(VTK_UNSIGNED_CHAR, components);
  return image;
}

using R = vtkInnerGSReconstruct;
const Wrong kWrong[] = {
    {"NoInput", [](R* f) { f->ClearInputs(); }, "no image to reconstruct from", R::InvalidArgumentError},
    {"Colour", [](R* f) { f->SetInputData(otherImage(3)); }, "3 values per voxel", R::UnsupportedImageError},
    {"NoVoxels", [](R* f) { f->SetInputData(otherImage(0)); }, "has no voxels", R::NoDataError},
    {"Empty", [](R* f) { f->SetInputData(vtkSmartPointer<vtkImageData>::New()); }, "has no voxels",
     R::NoDataError},
    {"Sheared", [](R* f) { setElement(f, 0, 1, 0.4); }, "not perpendicular", R::GeometryError},
    {"Singular",
     [](R* f) {
       for (int r = 0; r < 3; ++r)
         setElement(f, r, 1, 0);
     },
     "cannot be inverted", R::GeometryError},
    {"Projective", [](R* f) { setElement(f, 3, 0, 0.5); }, "last row must be 0 0 0 1", R::GeometryError},
    {"NotFinite", [](R* f) { setElement(f, 1, 3, std::numeric_limits<double>::quiet_NaN()); }, "not finite",
     R::GeometryError},
    {"Thickness", [](R* f) { f->SetInputSliceThickness(0, -2); }, "negative", R::InvalidArgumentError},
    {"TooThick", [](R* f) { f->SetInputSliceThickness(0, 400); }, "400 mm", R::InvalidArgumentError},
    {"Axis", [](R* f) { f->SetInputSliceAxis(0, 3); }, "slice axis", R::InvalidArgumentError},
    {"Profile", [](R* f) { f->SetInputSliceProfile(0, 9); }, "slice profile", R::InvalidArgumentError},
    {"Gaussians", [](R* f) { f->SetNumberOfGaussians(-4); }, "(gaussians)", R::InvalidArgumentError},
    {"Iterations", [](R* f) { f->SetNumberOfIterations(0); }, "(iterations)", R::InvalidArgumentError},
    {"HeldOut", [](R* f) { f->SetHeldOutFraction(0.9); }, "held-out fraction", R::InvalidArgumentError},
    {"InstructionSet", [](R* f) { f->SetInstructionSet("abacus"); }, "abacus", R::InvalidArgumentError},
    {"Device", [](R* f) { f->SetDevice("abacus"); }, "abacus", R::InvalidArgumentError},
    {"Spacing", [](R* f) { f->SetOutputSpacing(1, -1, 1); }, "voxel spacing", R::InvalidArgumentError},
    {"TooFine", [](R* f) { f->SetOutputSpacing(1e-6, 1, 1); }, "too fine", R::InvalidArgumentError},
    {"Region", [](R* f) { f->SetRegion(5, 4, 0, 1, 0, 1), f->UseRegionOn(); }, "region",
     R::InvalidArgumentError},
    {"RegionElsewhere", [](R* f) { f->SetRegion(900, 940, 0, 9, 0, 9), f->UseRegionOn(); }, "region",
     R::GeometryError},
    {"RegionSheared",
     [](R* f) {
       vtkNew<vtkMatrix4x4> sheared;
       sheared->SetElement(0, 1, 0.7);
       f->SetRegion(-9, 9, -9, 9, -9, 9), f->SetRegionToRASMatrix(sheared), f->UseRegionOn();
     },
     "region", R::GeometryError},
    {"Reference",
     [](R* f) {
       vtkNew<vtkMatrix4x4> identity;
       f->SetReferenceGrid(identity, 0, 4, 4);
     },
     "no voxels along axis I", R::GeometryError},
    {"ReferenceElsewhere",
     [](R* f) {
       vtkNew<vtkMatrix4x4> far;
       far->SetElement(0, 3, 5000);
       f->SetReferenceGrid(far, 4, 4, 4);
     },
     "does not overlap", R::GeometryError},
    {"EmptyMask",
     [](R* f) {
       auto mask = otherImage(1);
       std::fill_n(static_cast<unsigned char*>(mask->GetScalarPointer()), mask->GetNumberOfPoints(), 0);
       f->SetMaskData(mask);
     },
     "mask holds no centre", R::NoDataError},
    {"ColourMask", [](R* f) { f->SetMaskData(otherImage(4)); }, "The mask has 4 values",
     R::UnsupportedImageError},
    {"EmptyModelToResume", [](R* f) { f->SetResumeModel(vtkSmartPointer<vtkInnerGSModel>::New()); },
     "no Gaussians", R::NoDataError},
    {"Apart",
     [](R* f) {
       f->AddInputData(otherImage(1));
       vtkNew<vtkMatrix4x4> far;
       far->SetElement(2, 3, 500);
       f->SetInputIJKToRASMatrix(1, far);
       f->SetInputName(1, "T2 of somebody else");
     },
     "T2 of somebody else does not overlap", R::GeometryError},
};

} // namespace

class ReconstructError : public ::testing::TestWithParam<Wrong> {};

TEST_P(ReconstructError, IsOneSentenceAndEmptyOutputs) {
  const ReconstructionInput input = isotropicInput();
  auto filter = quickFilter(input, 2);
  filter->Update();
  ASSERT_FALSE(filter->GetOutputModel()->IsEmpty());
  Errors errors(filter), pipeline(filter->GetExecutive());
  GetParam().make(filter);
  for (int attempt = 1; attempt <= 2; ++attempt) { // tries again and reports again
    filter->Update();
    ASSERT_EQ(errors.texts.size(), static_cast<std::size_t>(attempt));
    EXPECT_NE(errors.texts.back().find(GetParam().sentence), std::string::npos) << errors.texts.back();
    EXPECT_NE(filter->GetErrorMessage().find(GetParam().sentence), std::string::npos);
    EXPECT_EQ(filter->GetErrorMessage().find('\n'), std::string::npos);
    EXPECT_EQ(filter->GetErrorCode(), GetParam().code);
    EXPECT_FALSE(filter->GetAborted());
    EXPECT_TRUE(filter->GetOutputModel()->IsEmpty());
    EXPECT_EQ(filter->GetOutputImage()->GetNumberOfPoints(), 0);
  }
  EXPECT_TRUE(pipeline.texts.empty()) << pipeline.texts[0];
}

INSTANTIATE_TEST_SUITE_P(All, ReconstructError, ::testing::ValuesIn(kWrong),
                         [](const auto& info) { return info.param.name; });

TEST(FilterError, RecoversWhenTheSettingIsCorrected) {
  auto filter = quickFilter(isotropicInput(), 2);
  filter->SetNumberOfGaussians(0);
  Errors errors(filter);
  filter->Update();
  EXPECT_EQ(errors.texts.size(), 1u);
  filter->SetNumberOfGaussians(100);
  filter->Update();
  EXPECT_EQ(errors.texts.size(), 1u);
  EXPECT_EQ(filter->GetErrorCode(), 0u);
  EXPECT_EQ(filter->GetErrorMessage(), "");
  EXPECT_EQ(filter->GetOutputModel()->GetNumberOfGaussians(), 100);
}

TEST(FilterError, ASnapshotOfABrokenInputIsRefused) {
  auto filter = quickFilter({});
  filter->AddInputData(otherImage(3));
  Errors errors(filter);
  EXPECT_FALSE(filter->TakeSnapshot());
  EXPECT_FALSE(filter->HasSnapshot());
  EXPECT_EQ(errors.texts.size(), 1u);
  EXPECT_EQ(filter->GetNumberOfInputConnections(0), 1);
  EXPECT_EQ(filter->GetErrorCode(), static_cast<unsigned long>(R::UnsupportedImageError));
}

TEST(FilterError, AWrongIndexIsSaid) {
  vtkNew<vtkInnerGSReconstruct> filter;
  Errors errors(filter);
  filter->SetInputSliceThickness(-1, 2);
  filter->SetInputIJKToRASMatrix(-1, nullptr);
  EXPECT_EQ(errors.texts.size(), 2u);
  EXPECT_EQ(filter->GetInputSliceThickness(4), 0);
}

TEST(FilterError, QueriesWithoutAModelSaySo) {
  vtkNew<vtkInnerGSPlaneQuery> plane;
  vtkNew<vtkInnerGSResample> resample;
  vtkNew<vtkInnerGSToPolyData> gaussians;
  for (vtkInnerGSAlgorithm* filter :
       {static_cast<vtkInnerGSAlgorithm*>(plane), static_cast<vtkInnerGSAlgorithm*>(resample),
        static_cast<vtkInnerGSAlgorithm*>(gaussians)}) {
    for (const bool empty : {false, true}) {
      SCOPED_TRACE(filter->GetClassName());
      Errors errors(filter);
      if (empty) filter->SetInputData(vtkSmartPointer<vtkInnerGSModel>::New());
      filter->Update();
      ASSERT_EQ(errors.texts.size(), 1u);
      EXPECT_NE(errors.texts[0].find("There is no model"), std::string::npos);
      EXPECT_EQ(filter->GetErrorCode(), static_cast<unsigned long>(R::NoDataError));
    }
  }
  vtkNew<vtkInnerGSPointQuery> points;
  Errors errors(points);
  EXPECT_TRUE(std::isnan(points->EvaluatePoint(0, 0, 0)));
  EXPECT_EQ(errors.texts.size(), 1u);
  EXPECT_NE(points->GetErrorMessage().find("There is no model"), std::string::npos);
}

TEST(FilterError, BadQueriesSayWhatIsWrong) {
  auto model = modelOf(randomSmallField());
  vtkNew<vtkInnerGSPlaneQuery> plane;
  plane->SetModel(model);
  plane->Update();
  EXPECT_EQ(plane->GetErrorMessage(), "");
  Errors errors(plane);
  const auto expectError = [&](const char* sentence) {
    plane->Update();
    EXPECT_NE(plane->GetErrorMessage().find(sentence), std::string::npos) << plane->GetErrorMessage();
    EXPECT_EQ(plane->GetOutput()->GetNumberOfPoints(), 0);
  };
  plane->SetSpacing(0, 1);
  expectError("pixel spacing");
  plane->SetSpacing(1, 1);
  plane->SetDimensions(0, 10);
  expectError("pixel");
  plane->SetDimensions(100000, 2);
  expectError("pixels");
  plane->SetDimensions(10, 10);
  vtkNew<vtkMatrix4x4> flat;
  flat->SetElement(0, 0, 0);
  plane->SetPlaneToRASMatrix(flat);
  expectError("cannot be inverted");
  EXPECT_EQ(errors.texts.size(), 4u);
  plane->SetPlaneToRASMatrix(nullptr);
  EXPECT_EQ(errors.texts.size(), 5u);
  vtkNew<vtkMatrix4x4> identity;
  plane->SetPlaneToRASMatrix(identity);
  plane->Update();
  EXPECT_EQ(plane->GetErrorMessage(), "");
  EXPECT_EQ(plane->GetOutput()->GetNumberOfPoints(), 100);

  vtkNew<vtkInnerGSResample> resample; // a field without a known region
  resample->SetModel(model);
  Errors resampleErrors(resample);
  resample->Update();
  EXPECT_NE(resample->GetErrorMessage().find("reference grid"), std::string::npos);

  vtkNew<vtkInnerGSPointQuery> query;
  query->SetModel(model);
  Errors queryErrors(query);
  vtkNew<vtkFloatArray> values;
  vtkNew<vtkPoints> points;
  EXPECT_FALSE(query->Evaluate(nullptr, values));
  points->InsertNextPoint(std::numeric_limits<double>::infinity(), 0, 0);
  EXPECT_FALSE(query->Evaluate(points, values));
  EXPECT_EQ(values->GetNumberOfTuples(), 0);
  EXPECT_EQ(queryErrors.texts.size(), 2u);
}
