#include "Fixtures.h"

#include "Core/Features/FeatureModel.h"
#include "Core/Render/Disagreement.h"
#include "vtkInnerGSPlaneQuery.h"
#include "vtkInnerGSToPolyData.h"

#include <vtkDataArray.h>
#include <vtkMath.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkWeakPointer.h>

#include <sstream>

using namespace innergs;
using namespace innergs::testing;

TEST(Model, KnowsItsPlaceInRAS) {
  GaussianField field = randomSmallField();
  field.domain = grid(10, 8, 6, {1, 2, 3}, {5, -7, 11}, obliqueDirection(0, true));
  auto model = modelOf(field);
  EXPECT_FALSE(model->IsEmpty());
  EXPECT_EQ(model->GetNumberOfGaussians(), field.size());
  double bounds[6];
  model->GetBounds(bounds);
  // LPS x from 4.5 to 14.5, y from −8 to 8; K runs down from 11 + 1.5 to −5.5.
  const double expected[6] = {-14.5, -4.5, -8, 8, -5.5, 12.5};
  for (int i = 0; i < 6; ++i)
    EXPECT_NEAR(bounds[i], expected[i], 1e-9) << i;
  vtkNew<vtkMatrix4x4> matrix;
  int size[3];
  ASSERT_TRUE(model->GetDomain(matrix, size));
  EXPECT_EQ(size[1], 8);
  EXPECT_TRUE(closeTo(matrix, rasMatrix(field.domain)));
  EXPECT_TRUE(model->IsInside(-14.4, 7.9, -5.4));
  EXPECT_FALSE(model->IsInside(-14.6, 7.9, -5.4));
  EXPECT_NE(model->GetDescription().find("normalised blending, 10.0 x 16.0 x 18.0 mm along R, A, S"),
            std::string::npos)
      << model->GetDescription();
}

TEST(Model, EmptyAnswersEverything) {
  vtkNew<vtkInnerGSModel> model;
  EXPECT_TRUE(model->IsEmpty());
  EXPECT_EQ(model->GetNumberOfGaussians(), 0);
  EXPECT_EQ(model->GetBlendingName(), "");
  EXPECT_EQ(model->GetDescription(), "Empty model");
  double bounds[6];
  model->GetBounds(bounds);
  EXPECT_FALSE(vtkMath::AreBoundsInitialized(bounds));
  int size[3] = {1, 2, 3};
  EXPECT_FALSE(model->GetDomain(nullptr, size));
  EXPECT_EQ(size[2], 3);
  EXPECT_FALSE(model->IsInside(0, 0, 0));
  std::ostringstream text;
  model->Print(text);
  EXPECT_NE(text.str().find("Empty model"), std::string::npos);
}

TEST(Model, CopiesShareWhatNeverChanges) {
  auto model = modelOf(randomSmallField());
  vtkNew<vtkInnerGSModel> shallow, deep;
  shallow->ShallowCopy(model);
  deep->DeepCopy(model);
  const std::weak_ptr<const Model> watched = model->GetCoreModel();
  EXPECT_EQ(shallow->GetCoreModel(), model->GetCoreModel());
  EXPECT_EQ(deep->GetNumberOfGaussians(), model->GetNumberOfGaussians());
  EXPECT_GE(model->GetActualMemorySize() * 1024, 200 * sizeof(Gaussian));
  const auto before = model->GetMTime();
  model->SetCoreModel(model->GetCoreModel());
  EXPECT_EQ(model->GetMTime(), before);
  model->Initialize();
  shallow->Initialize();
  EXPECT_FALSE(deep->IsEmpty());
  EXPECT_FALSE(watched.expired());
  deep->SetCoreModel(nullptr);
  EXPECT_TRUE(watched.expired());
  EXPECT_TRUE(deep->IsEmpty());
}

TEST(Model, CopiesShareFeatures) {
  auto model = modelOf(randomSmallField());
  const auto features = std::make_shared<FeatureModel>();
  features->names = {"background", "liver"};
  features->labels = {0, 5};
  features->latents.resize(200 * 16);
  const unsigned long before = model->GetActualMemorySize();
  EXPECT_EQ(model->GetNumberOfSegments(), 0);
  model->SetCoreModel(model->GetCoreModel(), features);
  EXPECT_EQ(model->GetNumberOfSegments(), 1);
  EXPECT_EQ(model->GetSegmentName(0), "liver");
  EXPECT_EQ(model->GetSegmentName(1), "");
  EXPECT_GE(model->GetActualMemorySize(), before + 12);
  vtkNew<vtkInnerGSModel> shallow, deep;
  shallow->ShallowCopy(model);
  deep->DeepCopy(model);
  EXPECT_TRUE(shallow->HasContentOf(model));
  EXPECT_EQ(deep->GetFeatures(), features);
  deep->SetCoreModel(deep->GetCoreModel());
  EXPECT_EQ(deep->GetNumberOfSegments(), 0);
  EXPECT_FALSE(deep->HasContentOf(model));
  shallow->Initialize();
  EXPECT_EQ(shallow->GetFeatures(), nullptr);
}

TEST(Model, AndFiltersGoWithTheirLastReference) {
  vtkWeakPointer<vtkInnerGSModel> model;
  vtkWeakPointer<vtkImageData> image, input;
  vtkWeakPointer<vtkInnerGSReconstruct> filter;
  vtkWeakPointer<vtkInnerGSPlaneQuery> query;
  std::weak_ptr<const Model> core;
  {
    auto reconstruct = quickFilter(isotropicInput(), 2);
    vtkNew<vtkInnerGSPlaneQuery> plane;
    plane->SetInputConnection(reconstruct->GetOutputPort(0));
    plane->Update();
    reconstruct->SetResumeModel(reconstruct->GetOutputModel());
    filter = reconstruct;
    query = plane;
    model = reconstruct->GetOutputModel();
    image = reconstruct->GetOutputImage();
    input = vtkImageData::SafeDownCast(reconstruct->GetInputDataObject(0, 0));
    core = reconstruct->GetOutputModel()->GetCoreModel();
    ASSERT_FALSE(core.expired());
    EXPECT_GT(plane->GetOutput()->GetNumberOfPoints(), 0);
  }
  EXPECT_FALSE(model);
  EXPECT_FALSE(image);
  EXPECT_FALSE(input);
  EXPECT_FALSE(filter);
  EXPECT_FALSE(query);
  EXPECT_TRUE(core.expired());
}

TEST(PolyData, HoldsCentresEllipsoidsAndValues) {
  GaussianField field = randomSmallField();
  field.modelToWorld = {obliqueDirection(0.7), {12, -30, 8}};
  field.intensityScale = 50;
  field.intensityOffset = -7;
  vtkNew<vtkInnerGSToPolyData> filter;
  filter->SetModel(modelOf(field));
  filter->SetEllipsoidRadius(2);
  filter->Update();
  ASSERT_EQ(filter->GetErrorMessage(), "");
  vtkPolyData* data = filter->GetOutput();
  ASSERT_EQ(data->GetNumberOfPoints(), field.size());
  EXPECT_EQ(data->GetNumberOfVerts(), field.size());
  vtkPointData* arrays = data->GetPointData();
  EXPECT_STREQ(arrays->GetScalars()->GetName(), "Intensity");
  EXPECT_STREQ(arrays->GetTensors()->GetName(), "Ellipsoid");
  const auto uneven = disagreement(field);
  for (vtkIdType i = 0; i < field.size(); ++i) {
    const Gaussian& g = field.gaussians[i];
    const Vec3 centre = field.modelToWorld({g.mean[0], g.mean[1], g.mean[2]});
    EXPECT_NEAR(data->GetPoint(i)[0], -centre[0], 1e-4);
    EXPECT_NEAR(data->GetPoint(i)[1], -centre[1], 1e-4);
    EXPECT_NEAR(data->GetPoint(i)[2], centre[2], 1e-4);
    EXPECT_NEAR(arrays->GetScalars()->GetTuple1(i), 50 * g.intensity - 7, 1e-4);
    EXPECT_NEAR(arrays->GetArray("Weight")->GetTuple1(i), std::exp(g.logWeight), 1e-4);
    EXPECT_EQ(arrays->GetArray("Disagreement")->GetTuple1(i), uneven[i]);
    // Its square is the covariance times the squared radius: F·A·R·diag(s²)·Rᵀ·Aᵀ·F.
    double q[4], length = 0;
    for (int a = 0; a < 4; ++a)
      length += static_cast<double>(g.quaternion[a]) * g.quaternion[a];
    for (int a = 0; a < 4; ++a)
      q[a] = g.quaternion[a] / std::sqrt(length);
    double rotation[3][3];
    vtkMath::QuaternionToMatrix3x3(q, rotation);
    Mat3 axes;
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c)
        axes[r][c] = rotation[r][c];
    axes = diagonal({-1, -1, 1}) * field.modelToWorld.linear * axes;
    Mat3 variances;
    for (int a = 0; a < 3; ++a)
      variances[a] = {0, 0, 0}, variances[a][a] = std::exp(2.0 * g.logScale[a]);
    const Mat3 covariance = axes * variances * transpose(axes);
    Mat3 tensor;
    for (int a = 0; a < 9; ++a)
      tensor[a / 3][a % 3] = arrays->GetTensors()->GetComponent(i, a);
    const Mat3 squared = tensor * transpose(tensor);
    for (int a = 0; a < 9; ++a)
      EXPECT_NEAR(squared[a / 3][a % 3], 4 * covariance[a / 3][a % 3],
                  1e-3 * (1 + std::abs(covariance[a / 3][a % 3])));
    double orientation[4];
    arrays->GetArray("Orientation")->GetTuple(i, orientation);
    vtkMath::QuaternionToMatrix3x3(orientation, rotation);
    for (int a = 0; a < 9; ++a)
      EXPECT_NEAR(rotation[a / 3][a % 3], axes[a / 3][a % 3], 1e-5);
    for (int a = 0; a < 3; ++a)
      EXPECT_NEAR(arrays->GetArray("Scales")->GetComponent(i, a), std::exp(g.logScale[a]), 1e-4);
  }
}

TEST(PolyData, LimitsItsCountEvenly) {
  GaussianField field = randomSmallField();
  for (std::size_t i = 0; i < field.gaussians.size(); ++i)
    field.gaussians[i].mean[0] = static_cast<float>(i);
  vtkNew<vtkInnerGSToPolyData> filter;
  filter->SetModel(modelOf(field));
  filter->SetMaximumNumberOfGaussians(20);
  filter->ComputeDisagreementOff();
  filter->Update();
  vtkPolyData* data = filter->GetOutput();
  ASSERT_EQ(data->GetNumberOfPoints(), 20);
  EXPECT_FALSE(data->GetPointData()->GetArray("Disagreement"));
  for (int i = 0; i < 20; ++i)
    EXPECT_NEAR(data->GetPoint(i)[0], -10.0 * i, 1e-3);
  filter->SetMaximumNumberOfGaussians(100000);
  filter->Update();
  EXPECT_EQ(filter->GetOutput()->GetNumberOfPoints(), 200);
}

TEST(PolyData, OpacityIsAlphasOwn) {
  GaussianField field = randomField(200, {}, 5, Blending::Alpha, false);
  field.gaussians[3].logWeight = 0;
  vtkNew<vtkInnerGSToPolyData> filter;
  filter->SetModel(modelOf(field));
  filter->Update();
  ASSERT_EQ(filter->GetErrorMessage(), "");
  EXPECT_FLOAT_EQ(filter->GetOutput()->GetPointData()->GetArray("Weight")->GetTuple1(3), 0.5);
  EXPECT_FALSE(filter->GetOutput()->GetPointData()->GetArray("Disagreement"));
}
