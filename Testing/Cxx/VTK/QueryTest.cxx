#include "Fixtures.h"

#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"
#include "vtkInnerGSPlaneQuery.h"
#include "vtkInnerGSPointQuery.h"
#include "vtkInnerGSResample.h"
#include "vtkInnerGSToPolyData.h"

#include <vtkFloatArray.h>
#include <vtkGeneralTransform.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkThinPlateSplineTransform.h>
#include <vtkTransform.h>
#include <vtkUnsignedCharArray.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// A field in an oblique frame, with its own region and a residual grid.
GaussianField framedField() {
  GaussianField field = randomSmallField();
  field.modelToWorld = {obliqueDirection(0.7), {12, -30, 8}};
  field.intensityScale = 50;
  field.intensityOffset = -7;
  field.domain = grid(14, 12, 10, {1, 1, 1.2}, field.modelToWorld({-6.5, -5.5, -5.4}), obliqueDirection(0.7));
  field.residual =
      volumeOf(grid(7, 6, 6, {2, 2, 2}, field.modelToWorld({-6, -5, -5}), obliqueDirection(0.7)),
               [](auto i, auto j, auto k) { return 0.05 * std::sin(double(i + 2 * j + 3 * k)); });
  return field;
}

struct Case {
  const char* name;
  double angle;
  bool leftHanded;
  Blending blending;
};

} // namespace

class Query : public ::testing::TestWithParam<Case> {
protected:
  Query() {
    field.blending = GetParam().blending;
    if (field.blending == Blending::Alpha) field.linearIntensity = false;
    if (field.blending == Blending::Alpha)
      for (Gaussian& g : field.gaussians)
        std::fill_n(g.slope, 3, 0.f);
    direction = obliqueDirection(GetParam().angle, GetParam().leftHanded);
    model = modelOf(field);
  }
  GaussianField field = framedField();
  Mat3 direction;
  vtkSmartPointer<vtkInnerGSModel> model;
};

TEST_P(Query, APlaneHasTheEnginesValues) {
  // The plane's pixels as a grid of one slice.
  const GridGeometry pixels = grid(41, 33, 1, {0.4, 0.5, 1}, field.modelToWorld({-5, -4, 0.3}), direction);
  const std::vector<float> expected = render(field, pixels).voxels;
  vtkNew<vtkInnerGSPlaneQuery> query;
  query->SetInputData(model);
  query->SetDimensions(41, 33);
  query->SetNumberOfThreads(2);

  // Like a slice node: mm, centred.
  GridGeometry centred = pixels;
  centred.spacing = {1, 1, 1};
  centred.origin = pixels.indexToWorld()({20, 16, 0});
  query->SetPlaneToRASMatrix(rasMatrix(centred));
  query->SetSpacing(0.4, 0.5);
  query->Update();
  ASSERT_EQ(query->GetErrorMessage(), "");
  const auto values = valuesOf(query->GetOutput());
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_NEAR(values[i], expected[i], 2e-3) << i; // for a range of 50
  EXPECT_TRUE(closeTo(query->GetOutputIJKToRASMatrix(), rasMatrix(pixels), 1e-9));
  EXPECT_TRUE(closeTo(query->GetOutput()->GetIndexToPhysicalMatrix(), rasMatrix(pixels), 1e-9));

  // Like XYToRAS: pixels, from the corner.
  query->SetPlaneToRASMatrix(rasMatrix(pixels));
  query->SetSpacing(1, 1);
  query->CentredOff();
  query->GeometryInImageOff();
  query->Update();
  const auto fromCorner = valuesOf(query->GetOutput());
  ASSERT_EQ(fromCorner.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(fromCorner[i], expected[i], 2e-3) << i;
  EXPECT_TRUE(closeTo(query->GetOutputIJKToRASMatrix(), rasMatrix(pixels), 1e-12));
  EXPECT_EQ(query->GetOutput()->GetSpacing()[0], 1);
}

TEST_P(Query, AGridHasTheEnginesValues) {
  const GridGeometry reference = grid(17, 15, 9, {0.9, 1, 1.3}, field.modelToWorld({-6, -5, -4}), direction);
  vtkNew<vtkInnerGSResample> resample;
  resample->SetModel(model);
  resample->SetReferenceGrid(rasMatrix(reference), 17, 15, 9);
  resample->Update();
  ASSERT_EQ(resample->GetErrorMessage(), "");
  const auto expected = render(field, reference).voxels;
  const auto values = valuesOf(resample->GetOutput());
  ASSERT_EQ(values.size(), expected.size());
  for (std::size_t i = 0; i < values.size(); ++i)
    ASSERT_NEAR(values[i], expected[i], 2e-3);
  EXPECT_TRUE(closeTo(resample->GetOutputIJKToRASMatrix(), rasMatrix(reference)));

  vtkNew<vtkImageData> like;
  like->SetDimensions(17, 15, 9);
  resample->SetReferenceImage(like, rasMatrix(reference));
  resample->SetReferenceGrid(nullptr, 0, 0, 0);
  resample->Update();
  EXPECT_EQ(valuesOf(resample->GetOutput()), render(field, field.domain).voxels);
  resample->SetOutputSpacing(2, 2, 2);
  resample->Update();
  EXPECT_EQ(valuesOf(resample->GetOutput()), render(field, withSpacing(field.domain, {2, 2, 2})).voxels);
}

TEST_P(Query, PointsHaveTheEnginesValues) {
  std::vector<Vec3> positions;
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  Numbers random(2);
  for (int n = 0; n < 120; ++n) { // in and around the region
    positions.push_back(field.modelToWorld({random(-9, 9), random(-9, 9), random(-9, 9)}));
    points->InsertNextPoint(-positions.back()[0], -positions.back()[1], positions.back()[2]);
  }
  vtkNew<vtkInnerGSPointQuery> query;
  query->SetModel(model);
  vtkNew<vtkFloatArray> values;
  ASSERT_TRUE(query->Evaluate(points, values));
  const auto expected = renderPoints(field, positions);
  ASSERT_EQ(values->GetNumberOfTuples(), 120);
  int inside = 0;
  for (int n = 0; n < 120; ++n) {
    EXPECT_EQ(values->GetValue(n), expected[n]);
    double p[3];
    points->GetPoint(n, p);
    const bool in = model->IsInside(p[0], p[1], p[2]);
    inside += in;
    if (!in) {
      EXPECT_FLOAT_EQ(values->GetValue(n), static_cast<float>(model->GetBackgroundValue()));
    }
  }
  EXPECT_GT(inside, 20);
  EXPECT_LT(inside, 80);
}

TEST_P(Query, AMaskCountsForAllFilters) {
  GaussianField masked = field;
  masked.support.geometry = cropped(field.domain, {3, 2, 2}, {8, 7, 6});
  masked.support.voxels.assign(8 * 7 * 6, 1);
  std::fill_n(masked.support.voxels.begin(), 8 * 7 * 2, std::uint8_t{0});
  masked.fill = 1234;
  masked.range = {0, 50};
  auto core = std::make_shared<Model>();
  core->field = masked;
  model->SetCoreModel(core);
  EXPECT_NE(model->GetDescription().find("inside a mask"), std::string::npos);
  double range[2];
  ASSERT_TRUE(model->GetValueRange(range));
  EXPECT_EQ(range[1], 50);
  vtkNew<vtkInnerGSResample> resample;
  resample->SetModel(model);
  resample->Update();
  EXPECT_EQ(valuesOf(resample->GetOutput()), render(masked, masked.support.geometry).voxels);
  vtkNew<vtkInnerGSPointQuery> points;
  points->SetModel(model);
  vtkNew<vtkInnerGSPlaneQuery> plane; // of one pixel
  plane->SetModel(model);
  plane->SetDimensions(1, 1);
  Numbers random(5);
  int inside = 0;
  for (int n = 0; n < 60; ++n) {
    const Vec3 lps = masked.support.geometry.indexToWorld()({random(-2, 9), random(-2, 8), random(-1, 7)});
    const Vec3 x{-lps[0], -lps[1], lps[2]};
    const double value = points->EvaluatePoint(x[0], x[1], x[2]);
    const bool in = model->IsInside(x[0], x[1], x[2]);
    EXPECT_EQ(value == 1234, !in);
    if (in) {
      EXPECT_TRUE(value >= 0 && value <= 50);
    }
    inside += in;
    vtkNew<vtkMatrix4x4> place;
    for (int a = 0; a < 3; ++a)
      place->SetElement(a, 3, x[a]);
    plane->SetPlaneToRASMatrix(place);
    plane->Update();
    const float onPlane = valuesOf(plane->GetOutput())[0];
    EXPECT_EQ(onPlane == 1234, !in);
    if (field.blending != Blending::Alpha) { // its value depends on the plane
      EXPECT_NEAR(onPlane, value, 2e-3);
    }
  }
  EXPECT_GT(inside, 5);
  EXPECT_LT(inside, 50);
  // Gaussians centred outside are not shown.
  vtkNew<vtkInnerGSToPolyData> shown;
  shown->SetModel(model);
  shown->Update();
  vtkPolyData* data = shown->GetOutput();
  vtkIdType expected = 0;
  for (const Gaussian& g : masked.gaussians) {
    const Vec3 x = masked.modelToWorld({g.mean[0], g.mean[1], g.mean[2]});
    expected += model->IsInside(-x[0], -x[1], x[2]);
  }
  ASSERT_GT(expected, 0);
  ASSERT_LT(expected, static_cast<vtkIdType>(masked.size()));
  EXPECT_EQ(data->GetNumberOfPoints(), expected);
  for (vtkIdType i = 0; i < expected; ++i) {
    double x[3];
    data->GetPoint(i, x);
    EXPECT_TRUE(model->IsInside(x[0], x[1], x[2]));
  }
}

INSTANTIATE_TEST_SUITE_P(Poses, Query,
                         ::testing::Values(Case{"Straight", 0, false, Blending::Normalised},
                                           Case{"Oblique", 0.9, false, Blending::Normalised},
                                           Case{"LeftHanded", 0.4, true, Blending::Normalised},
                                           Case{"Additive", 2, true, Blending::Additive},
                                           Case{"Alpha", 0.3, false, Blending::Alpha}),
                         [](const auto& info) { return info.param.name; });

TEST(PlaneQuery, FollowsItsModelPlaneAndSize) {
  const GaussianField field = framedField();
  auto model = modelOf(field);
  vtkNew<vtkInnerGSPlaneQuery> query;
  Observer runs(query, vtkCommand::StartEvent, [](void*) {});
  query->SetModel(model);
  vtkNew<vtkMatrix4x4> plane;
  const Vec3 c = field.modelToWorld.offset;
  plane->SetElement(0, 3, -c[0]);
  plane->SetElement(1, 3, -c[1]);
  plane->SetElement(2, 3, c[2]);
  query->SetPlaneToRASMatrix(plane);
  query->SetDimensions(20, 20);
  query->Update();
  query->SetPlaneToRASMatrix(plane);
  query->SetDimensions(20, 20);
  query->Update();
  EXPECT_EQ(runs.count, 1);
  const auto first = valuesOf(query->GetOutput());
  query->GetPlaneToRASMatrix()->SetElement(2, 3, c[2] + 1); // in place
  query->Update();
  EXPECT_EQ(runs.count, 2);
  EXPECT_NE(valuesOf(query->GetOutput()), first);
  query->SetPlaneToRASMatrix(plane);
  query->Update();
  EXPECT_EQ(valuesOf(query->GetOutput()), first);
  GaussianField brighter = field;
  brighter.intensityOffset += 100;
  model->SetCoreModel(modelOf(brighter)->GetCoreModel()); // the same object with new content
  query->Update();
  EXPECT_NEAR(valuesOf(query->GetOutput())[210], first[210] + 100, 1e-3);
  query->SetNumberOfThreads(1);
  query->SetInstructionSet("scalar");
  query->Update();
  EXPECT_NEAR(valuesOf(query->GetOutput())[210], first[210] + 100, 1e-2);
  EXPECT_GT(query->GetQueryMilliseconds(), 0);
}

TEST(PlaneQuery, ShowsTheStandardDeviationAndWhereNothingWasMeasured) {
  GaussianField field = framedField();
  vtkNew<vtkInnerGSPlaneQuery> query;
  query->SetModel(modelOf(field));
  query->SetDimensions(12, 10);
  query->SetSpacing(1, 1);
  query->CentredOff();
  const GridGeometry geometry = grid(9, 8, 7, {1.5, 1.5, 2}, {1, 2, 3}, obliqueDirection(0.4));
  const auto ramp = [](double i, double j, double k) { return 4 + i + 2 * j + 3 * k; };
  Volume values =
      volumeOf(geometry, [&](auto i, auto j, auto k) { return ramp(double(i), double(j), double(k)); });
  vtkNew<vtkUnsignedCharArray> measured;
  measured->SetName("Measured");
  for (std::int64_t v = 0; v < geometry.voxelCount(); ++v)
    measured->InsertNextValue(v / 72 != 3); // not the fourth slice
  // A plane across the grid's I and K, from beside its first row to beside its last.
  GridGeometry plane = grid(12, 10, 1, {1, 1, 1}, geometry.indexToWorld()({-1, 3.25, -0.4}));
  for (int r = 0; r < 3; ++r) {
    plane.direction[r][0] = geometry.direction[r][0];
    plane.direction[r][1] = geometry.direction[r][2];
    plane.direction[r][2] = geometry.direction[r][1];
  }
  query->SetPlaneToRASMatrix(rasMatrix(plane));
  query->Update();
  EXPECT_EQ(query->GetOutputStandardDeviation()->GetNumberOfPoints(), 0) << "none was given";
  const auto intensity = valuesOf(query->GetOutput());
  for (const int type : {VTK_FLOAT, VTK_SHORT}) {
    const auto image = plainImage(values, type);
    image->GetPointData()->AddArray(measured);
    query->SetStandardDeviationData(image);
    query->SetStandardDeviationIJKToRASMatrix(rasMatrix(geometry));
    query->Update(1);
    ASSERT_EQ(query->GetErrorMessage(), "");
    EXPECT_EQ(valuesOf(query->GetOutput()), intensity);
    vtkImageData* shown = query->GetOutputStandardDeviation();
    const auto deviation = valuesOf(shown);
    ASSERT_EQ(deviation.size(), intensity.size());
    vtkDataArray* marks = shown->GetPointData()->GetArray("Measured");
    ASSERT_NE(marks, nullptr);
    const Affine3 toIndex = inverse(geometry.indexToWorld()) * plane.indexToWorld();
    int outside = 0, unmeasured = 0;
    for (int y = 0; y < 10; ++y)
      for (int x = 0; x < 12; ++x) {
        const Vec3 at = toIndex({double(x), double(y), 0});
        const bool inside = at[0] > -0.5 && at[0] < 8.5 && at[2] > -0.5 && at[2] < 6.5;
        const double expected =
            inside ? ramp(std::clamp(at[0], 0., 8.), at[1], std::clamp(at[2], 0., 6.)) : ramp(8, 7, 6);
        const bool known = inside && std::lround(at[2]) != 3;
        EXPECT_NEAR(deviation[x + 12 * y], expected, 1e-3) << x << " " << y;
        EXPECT_EQ(marks->GetTuple1(x + 12 * y) != 0, known) << x << " " << y;
        outside += !inside;
        unmeasured += inside && !known;
      }
    EXPECT_GT(outside, 5);
    EXPECT_GT(unmeasured, 5);
  }
  query->SetStandardDeviationData(nullptr);
  query->Update(1);
  EXPECT_EQ(query->GetOutputStandardDeviation()->GetNumberOfPoints(), 0);
}

TEST(PlaneQuery, AShearedPlaneIsSampledWhereItsPixelsLie) {
  const GaussianField field = framedField();
  Affine3 map{obliqueDirection(0.3), field.modelToWorld({-3, -3, 0})};
  for (int r = 0; r < 3; ++r)
    map.linear[r][1] += 0.5 * map.linear[r][0];
  vtkNew<vtkInnerGSPlaneQuery> query;
  query->SetModel(modelOf(field));
  query->SetPlaneToRASMatrix(rasMatrix(map));
  query->SetDimensions(7, 6);
  query->CentredOff();
  query->Update();
  ASSERT_EQ(query->GetErrorMessage(), "");
  std::vector<Vec3> positions;
  for (int n = 0; n < 42; ++n)
    positions.push_back(map({double(n % 7), double(n / 7), 0}));
  const auto expected = renderPoints(field, positions), values = valuesOf(query->GetOutput());
  for (int n = 0; n < 42; ++n)
    EXPECT_NEAR(values[n], expected[n], 1e-2);
  EXPECT_TRUE(closeTo(query->GetOutputIJKToRASMatrix(), rasMatrix(map)));
}

TEST(PlaneQuery, FollowsAModelThatWasMoved) {
  const GaussianField field = framedField();
  const auto model = modelOf(field);
  vtkNew<vtkInnerGSPlaneQuery> query;
  query->SetModel(model);
  vtkNew<vtkMatrix4x4> plane;
  const Vec3 c = field.modelToWorld.offset;
  plane->DeepCopy(rasMatrix(Affine3{obliqueDirection(0.3), c}));
  query->SetPlaneToRASMatrix(plane);
  query->SetDimensions(15, 12);

  vtkNew<vtkTransform> sheared;
  const double shear[16] = {1.1, 0.3, 0, 2, 0, 0.9, 0.2, -1, 0, 0, -1.2, 15, 0, 0, 0, 1};
  sheared->SetMatrix(shear);
  vtkNew<vtkThinPlateSplineTransform> bent;
  vtkNew<vtkPoints> from, to;
  for (int n = 0; n < 8; ++n) {
    const double at[3] = {-c[0] + 9 * (n & 1), -c[1] + 9 * (n >> 1 & 1), c[2] + 9 * (n >> 2)};
    from->InsertNextPoint(at);
    to->InsertNextPoint(at[0] + (n == 3), at[1] - (n == 5), at[2] + 2 * (n == 0));
  }
  bent->SetBasisToR();
  bent->SetSourceLandmarks(from);
  bent->SetTargetLandmarks(to);
  vtkNew<vtkGeneralTransform> unbent;
  unbent->Concatenate(bent);
  unbent->Inverse();
  vtkNew<vtkInnerGSPointQuery> points;
  points->SetModel(model);
  for (vtkAbstractTransform* toModel :
       {static_cast<vtkAbstractTransform*>(sheared.Get()), static_cast<vtkAbstractTransform*>(bent.Get()),
        static_cast<vtkAbstractTransform*>(unbent.Get())}) {
    query->SetTransformToModel(toModel);
    query->Update();
    ASSERT_EQ(query->GetErrorMessage(), "");
    vtkNew<vtkPoints> there;
    there->SetDataTypeToDouble();
    for (int n = 0; n < 15 * 12; ++n) { // the pixels are at the requested positions
      double at[4] = {double(n % 15), double(n / 15), 0, 1};
      query->GetOutputIJKToRASMatrix()->MultiplyPoint(at, at);
      there->InsertNextPoint(toModel->TransformPoint(at));
    }
    vtkNew<vtkFloatArray> expected;
    ASSERT_TRUE(points->Evaluate(there, expected));
    const auto values = valuesOf(query->GetOutput());
    ASSERT_EQ(values.size(), 15u * 12u);
    for (int n = 0; n < 15 * 12; ++n)
      ASSERT_NEAR(values[n], expected->GetValue(n), 1e-2) << toModel->GetClassName() << " " << n;
    EXPECT_GT(expected->GetRange()[1] - expected->GetRange()[0], 5);
  }
  to->SetPoint(2, to->GetPoint(0)); // the transform changes
  to->Modified();
  const auto before = valuesOf(query->GetOutput());
  query->Update();
  EXPECT_NE(valuesOf(query->GetOutput()), before);
  query->Cancel();
  query->Modified();
  query->Update();
  EXPECT_TRUE(query->GetAborted());
}

TEST(ResampleFilter, StopsOnRequest) {
  vtkNew<vtkInnerGSResample> resample;
  resample->SetModel(modelOf(framedField()));
  Observer progress(resample, vtkCommand::ProgressEvent, [&](void*) { resample->AbortExecuteOn(); });
  resample->Update();
  EXPECT_TRUE(resample->GetAborted());
  EXPECT_EQ(resample->GetOutput()->GetNumberOfPoints(), 0);
}
