#include "Fixtures.h"

#include "vtkInnerGSPlaneQuery.h"
#include "vtkInnerGSPointQuery.h"
#include "vtkInnerGSResample.h"

#include <vtkFloatArray.h>
#include <vtkPoints.h>

#include <cstdlib>

using namespace innergs;
using namespace innergs::testing;

namespace {

/// With the plugin whose device is the host executor.
class DeviceQuery : public ::testing::Test {
protected:
  static void SetUpTestSuite() {
#ifdef _WIN32
    _putenv_s("INNERGS_PLUGIN_PATH", INNERGS_HOST_PLUGIN);
#else
    setenv("INNERGS_PLUGIN_PATH", INNERGS_HOST_PLUGIN, 1);
#endif
  }
  static void expectNear(const std::vector<float>& found, const std::vector<float>& expected,
                         double tolerance) {
    ASSERT_EQ(found.size(), expected.size());
    double largest = 0;
    for (std::size_t i = 0; i < found.size(); ++i) {
      ASSERT_NEAR(found[i], expected[i], tolerance) << i;
      largest = std::max(largest, std::abs(static_cast<double>(expected[i])));
    }
    EXPECT_GT(largest, 100 * tolerance) << "there is something to see";
  }
  DeviceQuery() { field.domain = grid(14, 12, 10, {1, 1, 1.2}, {-6.5, -5.5, -5.4}); }

  GaussianField field = randomSmallField();
  const double tolerance = 1e-4 * std::max(1.0, std::abs(field.intensityScale));
};

} // namespace

TEST_F(DeviceQuery, APlaneFollowsTheDeviceThatIsAskedFor) {
  vtkNew<vtkInnerGSPlaneQuery> query;
  EXPECT_EQ(query->GetDevice(), "cpu");
  query->SetModel(modelOf(field));
  query->SetDimensions(30, 25);
  query->SetSpacing(0.5, 0.5);
  query->Update();
  const auto cpu = valuesOf(query->GetOutput());
  query->SetDevice("cuda:0");
  query->Update();
  expectNear(valuesOf(query->GetOutput()), cpu, tolerance);
  query->SetDevice("cpu");
  query->Update();
  EXPECT_EQ(valuesOf(query->GetOutput()), cpu);
  Errors errors(query);
  query->SetDevice("cuda:7");
  query->Update();
  ASSERT_EQ(errors.texts.size(), 1u);
  EXPECT_NE(errors.texts[0].find("There is no device 'cuda:7'"), std::string::npos) << errors.texts[0];
}

TEST_F(DeviceQuery, GridsAndPointsFollowItToo) {
  vtkNew<vtkInnerGSResample> resample;
  EXPECT_EQ(resample->GetDevice(), "auto");
  resample->SetModel(modelOf(field));
  resample->SetOutputSpacing(1.3, 1.2, 1.1);
  resample->SetDevice("cpu");
  resample->Update();
  const auto cpu = valuesOf(resample->GetOutput());
  resample->SetDevice("cuda:0");
  resample->Update();
  expectNear(valuesOf(resample->GetOutput()), cpu, tolerance);

  vtkNew<vtkInnerGSPointQuery> query;
  EXPECT_EQ(query->GetDevice(), "auto");
  query->SetModel(modelOf(field));
  vtkNew<vtkPoints> points;
  for (int i = 0; i < 100; ++i)
    points->InsertNextPoint(0.05 * i - 2, 0.03 * i - 1, 0.02 * i);
  vtkNew<vtkFloatArray> values;
  const auto at = [&](const char* device) {
    query->SetDevice(device);
    EXPECT_TRUE(query->Evaluate(points, values));
    return std::vector<float>(values->GetPointer(0), values->GetPointer(0) + values->GetNumberOfTuples());
  };
  const auto onCpu = at("cpu");
  expectNear(at("cuda:0"), onCpu, tolerance);
}
