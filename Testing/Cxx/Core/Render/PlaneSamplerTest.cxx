#include "Core/Render/PlaneSampler.h"

#include "Core/Model/DomainBox.h"
#include "Core/Render/Render.h"
#include "RandomFields.h"
#include "TestVolumes.h"
#include "ThrownError.h"

#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

std::shared_ptr<const GaussianField> fieldOf(Blending blending) {
  Cloud cloud;
  cloud.low = {-20, -20, -20};
  cloud.high = {20, 20, 20};
  auto field = std::make_shared<GaussianField>(
      randomField(20000, cloud, 11, blending, blending == Blending::Normalised));
  field->modelToWorld = {obliqueDirection(0.4), {100, -50, 30}};
  field->intensityScale = 200;
  field->intensityOffset = 3;
  field->domain =
      grid(38, 38, 38, {1, 1, 1}, field->modelToWorld({-18.5, -18.5, -18.5}), obliqueDirection(0.4));
  field->residual = volumeOf(grid(10, 10, 10, {3, 3, 3}, field->modelToWorld({-13, -13, -13})),
                             [](auto i, auto j, auto k) { return 0.01 * double(i - j + k); });
  return field;
}

} // namespace

TEST(PlaneSampler, GivesTheVeryPixelsOfRender) {
  for (const Blending blending : {Blending::Normalised, Blending::Additive, Blending::Alpha}) {
    const auto field = fieldOf(blending);
    PlaneSampler sampler(field, 2);
    Numbers random(3);
    for (int n = 0; n < 12; ++n) {
      SCOPED_TRACE(::testing::Message() << blendingName(blending) << ", plane " << n);
      const int nx = 1 + static_cast<int>(random(0, 90)), ny = 1 + static_cast<int>(random(0, 90));
      const double spacing = random(0.05, 0.9); // from a magnified corner to everything
      GridGeometry plane =
          grid(nx, ny, 1, {spacing, 1.2 * spacing, 1}, {0, 0, 0}, obliqueDirection(random(0, 6), n % 3 == 0));
      plane.origin = field->modelToWorld({random(-19, 19), random(-19, 19), random(-19, 19)});
      std::vector<float> out(static_cast<std::size_t>(nx) * ny, -1.f);
      sampler.sample(plane.indexToWorld(), nx, ny, out);
      EXPECT_EQ(out, render(*field, plane).voxels);
    }
  }
}

TEST(PlaneSampler, FarFromEverythingIsBackground) {
  const auto field = fieldOf(Blending::Normalised);
  PlaneSampler sampler(field, 2);
  std::vector<float> out(12, -1.f);
  sampler.sample({Mat3{}, {5000, 0, 0}}, 4, 3, out);
  EXPECT_EQ(out, std::vector<float>(12, 3.f));
}

TEST(PlaneSampler, BesideTheDomainAlongItsAxesIsBackground) {
  auto field = std::make_shared<GaussianField>(*fieldOf(Blending::Normalised));
  field->modelToWorld = {};
  field->domain = grid(20, 20, 20, {1, 1, 1}, {0, 0, 0}, Mat3{});
  PlaneSampler sampler(field, 2);
  for (const double right :
       {-400.0, 400.0, 5.0}) // the row meets the domain far from its own pixels, or not at all
    for (const double up : {-30.0, 5.0, 60.0})
      for (const double along : {-30.0, 5.0, 60.0}) {
        if (right == 5 && up == 5 && along == 5) continue;
        std::vector<float> out(12, -1.f);
        sampler.sample({Mat3{}, {right, up, along}}, 4, 3, out);
        EXPECT_EQ(out, std::vector<float>(12, 3.f));
        const GridGeometry beside = grid(4, 3, 2, {1, 1, 1}, {right, up, along}, Mat3{});
        EXPECT_EQ(render(*field, beside).voxels, std::vector<float>(24, 3.f));
      }
}

TEST(DomainBox, NeverCutsARowLonger) {
  const DomainBox box(grid(20, 20, 20, {1, 1, 1}, {0, 0, 0}, Mat3{}), Affine3{Mat3{}, {-400, -30, 0}});
  int first = 0, last = 4;
  box.clipRow(0, 0, first, last);
  EXPECT_GE(first, 0);
  EXPECT_EQ(first, last);
  EXPECT_LE(last, 4);
}

TEST(PlaneSampler, RefusesWhatIsNoPlane) {
  PlaneSampler sampler(fieldOf(Blending::Normalised), 1);
  std::vector<float> out(12);
  Affine3 flat;
  flat.linear = diagonal({1, 0, 1});
  EXPECT_THROW(sampler.sample(flat, 4, 3, out), Error);
  EXPECT_THROW(sampler.sample({}, 0, 3, out), Error);
  EXPECT_THROW(sampler.sample({}, 4, 4, out), Error);
  std::stop_source stop;
  stop.request_stop();
  EXPECT_EQ(test::codeOf([&] { sampler.sample({}, 4, 3, out, stop.get_token()); }), ErrorCode::Cancelled);
  EXPECT_NO_THROW(sampler.sample({}, 4, 3, out)) << "the next one is not stopped";
}
