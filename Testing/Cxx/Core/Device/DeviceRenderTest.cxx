#include "Core/Device/Devices.h"
#include "Core/Render/FieldDevice.h"
#include "Core/Render/PlaneSampler.h"
#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"
#include "FakeDevice.h"

using namespace innergs;
using namespace innergs::testing;

namespace {

class DeviceRender : public FakeDevice {
protected:
  static double worst(std::span<const float> a, std::span<const float> b) {
    EXPECT_EQ(a.size(), b.size());
    double most = 0;
    for (std::size_t i = 0; i < a.size(); ++i)
      most = std::max(most, std::abs(static_cast<double>(a[i]) - b[i]));
    return most;
  }
  static GaussianField fitted(const ReconstructionInput& input, Blending blending) {
    Settings settings = reference();
    settings.blending = blending;
    settings.linearIntensity = false;
    return reconstruct(input, settings).model->field;
  }
};

} // namespace

TEST_F(DeviceRender, GivesTheCpusValuesWithDetailDomainUnitsAndChannels) {
  for (const Blending blending : {Blending::Normalised, Blending::Additive, Blending::Alpha}) {
    SCOPED_TRACE(blendingName(blending));
    const ReconstructionInput input = anisotropicInput();
    const GaussianField field = fitted(input, blending);
    EXPECT_FALSE(field.residual.voxels.empty());
    GridGeometry plane = grid(40, 36, 3, {0.9, 0.9, 2}, {-38, 5, 3}, obliqueDirection(0.7)); // partly outside
    std::vector<float> channel;
    for (std::int64_t i = 0; i < field.size(); ++i)
      channel.push_back(static_cast<float>(i % 7));
    std::vector<Vec3> points;
    for (int i = 0; i < 300; ++i)
      points.push_back({-36 + i * 0.1, 8 + i * 0.08, 2 + i * 0.07});
    for (const bool own : {true, false}) {
      RenderOptions cpu;
      if (!own) cpu.values = channel;
      RenderOptions device = cpu;
      device.device = DeviceChoice("cuda:0").makeField(field);
      ASSERT_TRUE(device.device);
      const auto check = [&](double limit, bool above) {
        const auto good = [&](double e) { return above ? e > limit : e <= limit; };
        EXPECT_PRED1(good, worst(render(field, plane, cpu).voxels, render(field, plane, device).voxels));
        EXPECT_PRED1(good, worst(renderStack(field, input.stacks[0], cpu).voxels,
                                 renderStack(field, input.stacks[0], device).voxels));
        EXPECT_PRED1(good, worst(renderPoints(field, points, cpu), renderPoints(field, points, device)));
      };
      const double unit = own ? field.intensityScale : 1;
      check(2e-4 * unit * (own ? 1 : 7), false);
      fails("mark"); // shows that the device renders
      check(0.9 * unit, true);
      fails("render"); // then the CPU takes over
      check(0, false);
      fails("");
    }
  }
}

TEST_F(DeviceRender, StopsWhenAsked) {
  const GaussianField field = fitted(isotropicInput(), Blending::Normalised);
  std::stop_source stop;
  stop.request_stop();
  RenderOptions options;
  options.device = DeviceChoice("auto").makeField(field);
  options.stop = stop.get_token();
  EXPECT_THROW(render(field, smallGrid(), options), Error);
  EXPECT_THROW(renderPoints(field, std::vector<Vec3>{{-20, 20, 10}}, options), Error);
}

TEST_F(DeviceRender, ShowsPlanesFromTheDevice) {
  const auto field = std::make_shared<GaussianField>(fitted(anisotropicInput(), Blending::Normalised));
  const Affine3 plane = grid(50, 44, 1, {0.8, 0.8, 1}, {-38, 5, 12}, obliqueDirection(0.4)).indexToWorld();
  std::vector<float> a(50 * 44), b(a.size());
  PlaneSampler cpu(field, 2), device(field, 2, "", DeviceChoice("auto").makeField(*field));
  cpu.sample(plane, 50, 44, a);
  device.sample(plane, 50, 44, b);
  EXPECT_LE(worst(a, b), 2e-4 * field->intensityScale);
  fails("mark");
  device.sample(plane, 50, 44, b);
  EXPECT_GT(worst(a, b), 0.9 * field->intensityScale);
  EXPECT_EQ(*std::min_element(b.begin(), b.end()), static_cast<float>(field->intensityOffset)) << "outside";
  fails("render");
  device.sample(plane, 50, 44, b);
  EXPECT_EQ(a, b);
  EXPECT_THROW(DeviceChoice("cuda:7"), Error);
  fails("none");
  PlaneSampler none(field, 2, "", DeviceChoice("auto").makeField(*field));
  none.sample(plane, 50, 44, b);
  EXPECT_EQ(a, b);
}
