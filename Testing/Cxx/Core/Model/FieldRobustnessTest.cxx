#include "Core/Base/Error.h"
#include "Core/Render/Render.h"
#include "Core/Render/RenderPoints.h"
#include "RandomFields.h"
#include "TestVolumes.h"

#include <cstring>
#include <gtest/gtest.h>

using namespace innergs;
using namespace innergs::testing;

namespace {

GaussianField goodField(std::uint64_t seed) {
  Cloud cloud;
  GaussianField field =
      randomField(40, cloud, seed, seed % 2 ? Blending::Normalised : Blending::Additive, seed % 2);
  field.modelToWorld = {obliqueDirection(0.3), {10, 20, 30}};
  field.domain = grid(9, 8, 7, {1.5, 1.5, 1.5}, {4, 14, 25});
  return field;
}

bool accepted(const GaussianField& field) {
  try {
    checkField(field);
    return true;
  } catch (const Error& error) {
    EXPECT_TRUE(error.code() == ErrorCode::FileFormat || error.code() == ErrorCode::Geometry);
    EXPECT_GT(std::strlen(error.what()), 10u);
    return false;
  }
}

/// A float with an extreme or random bit pattern.
float nasty(Numbers& random) {
  static const float values[] = {0.f,     -0.f,     1e-30f, -1e-30f, 1e30f, -1e30f,   20.f,     -20.f,
                                 40.f,    -40.f,    19.9f,  -19.9f,  1e6f,  -1e6f,    1e12f,    -1e12f,
                                 3.4e38f, -3.4e38f, 1e-45f, 1e9f,    NAN,   INFINITY, -INFINITY};
  if (random(0, 1) < 0.7) return values[random.bits() % std::size(values)];
  const std::uint32_t bits = static_cast<std::uint32_t>(random.bits());
  float f;
  std::memcpy(&f, &bits, sizeof f);
  return f;
}

} // namespace

TEST(FieldCheck, AcceptsAGoodFieldAndRefusesBrokenOnes) {
  ASSERT_TRUE(accepted(goodField(1)));
  const auto refused = [](auto&& change) {
    GaussianField field = goodField(1);
    change(field);
    return !accepted(field);
  };
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(refused([](auto& f) { f.gaussians.clear(); }));
  for (double x : {nan, inf, 0.0, 1e-300, -1e-9, 1.0, -1.0})
    EXPECT_TRUE(refused([&](auto& f) { f.epsilon = x; })) << x;
  for (double x : {nan, inf, 0.0, -3.0, 1e9})
    EXPECT_TRUE(refused([&](auto& f) { f.cutoff = x; })) << x;
  for (double x : {nan, inf, 0.0, -inf})
    EXPECT_TRUE(refused([&](auto& f) { f.intensityScale = x; })) << x;
  for (double x : {nan, inf})
    EXPECT_TRUE(refused([&](auto& f) { f.intensityOffset = x; })) << x;
  for (double x : {nan, inf})
    EXPECT_TRUE(refused([&](auto& f) { f.modelToWorld.offset[1] = x; })) << x;
  for (double x : {nan, inf, 2.0, 0.0})
    EXPECT_TRUE(refused([&](auto& f) { f.modelToWorld.linear[2][2] = x; })) << x;
  EXPECT_TRUE(refused([](auto& f) { f.modelToWorld.linear = obliqueDirection(0.3, true); }))
      << "a reflection";
  EXPECT_TRUE(refused([](auto& f) { f.domain.size[0] = 0; }));
  EXPECT_TRUE(refused([&](auto& f) { f.domain.spacing[0] = nan; }));
  for (int p = 0; p < 15; ++p)
    for (float x : {static_cast<float>(nan), static_cast<float>(inf), -3e38f})
      EXPECT_TRUE(refused([&](auto& f) { reinterpret_cast<float*>(&f.gaussians[7])[p] = x; }))
          << "parameter " << p;
  EXPECT_TRUE(refused([](auto& f) { std::fill_n(f.gaussians[7].quaternion, 4, 0.f); }));
}

TEST(FieldCheck, WhatItAcceptsRendersWithoutHarm) {
  Numbers random(77);
  int passed = 0, failed = 0;
  const std::vector<std::string> sets = instructionSets();
  for (int round = 0; round < 1000; ++round) {
    GaussianField field = goodField(1 + round % 4);
    const int changes = 1 + static_cast<int>(random.bits() % 4);
    for (int c = 0; c < changes; ++c)
      switch (random.bits() % 8) {
      case 0:
        field.epsilon = std::abs(nasty(random));
        break;
      case 1:
        field.cutoff = random(0.2, 11);
        break;
      case 2:
        field.intensityScale = nasty(random);
        break;
      case 3:
        field.modelToWorld.offset[random.bits() % 3] = nasty(random);
        break;
      default:
        reinterpret_cast<float*>(field.gaussians.data())[random.bits() % (16 * field.gaussians.size())] =
            nasty(random);
      }
    if (!accepted(field)) {
      ++failed;
      continue;
    }
    ++passed;
    RenderOptions options;
    options.threads = 1;
    options.instructionSet = sets[round % sets.size()];
    const Volume volume = render(field, field.domain, options);
    const Affine3 map = field.domain.indexToWorld();
    const std::vector<Vec3> points{map({1, 2, 3}), map({8, 7, 6}), map({0, 0, 0})};
    const auto values = renderPoints(field, points, options);
    ASSERT_EQ(volume.voxels.size(), 504u);
    ASSERT_EQ(values.size(), 3u);
    Stack stack;
    stack.image = volume;
    stack.profile = round % 2 ? SliceProfile::Gaussian : SliceProfile::Box;
    stack.thickness = 4;
    ASSERT_EQ(renderStack(field, stack, options).voxels.size(), 504u);
  }
  EXPECT_GT(passed, 150);
  EXPECT_GT(failed, 300);
}

TEST(FieldCheck, AnExtremeGaussianDoesNotSpoilTheOthers) {
  // Allowed but extreme parameters: tiny weights with a wide cut-off, needles, sheets, giants far away.
  struct Case {
    const char* name;
    void (*change)(Gaussian&);
  };
  const Case cases[] = {
      {"faint", [](Gaussian& g) { g.logWeight = -40; }},
      {"needle", [](Gaussian& g) { g.logScale[0] = g.logScale[1] = -20; }},
      {"sheet", [](Gaussian& g) { g.logScale[2] = -20; }},
      {"point", [](Gaussian& g) { g.logScale[0] = g.logScale[1] = g.logScale[2] = -20; }},
      {"long needle",
       [](Gaussian& g) { g.logScale[0] = 20, g.logScale[1] = g.logScale[2] = -20, g.logWeight = -40; }},
      {"giant, faint",
       [](Gaussian& g) { g.logScale[0] = g.logScale[1] = g.logScale[2] = 20, g.logWeight = -40; }},
      {"far away", [](Gaussian& g) { g.mean[0] = 1e6f, g.logScale[0] = 3; }}};
  for (const double cutoff : {3.0, 9.99})
    for (const std::uint64_t seed : {1, 2}) // normalised, additive
      for (const Case& c : cases) {
        SCOPED_TRACE(std::string(c.name) + ", cut-off " + std::to_string(cutoff));
        GaussianField field = goodField(seed), without = field;
        field.cutoff = without.cutoff = cutoff;
        c.change(field.gaussians[20]);
        without.gaussians.erase(without.gaussians.begin() + 20);
        ASSERT_TRUE(accepted(field));
        for (const std::string& set : instructionSets()) {
          SCOPED_TRACE(set);
          RenderOptions options;
          options.instructionSet = set;
          const Volume with = render(field, field.domain, options),
                       others = render(without, field.domain, options);
          for (std::size_t v = 0; v < with.voxels.size(); ++v)
            ASSERT_NEAR(with.voxels[v], others.voxels[v], 1e-3);
          Stack stack;
          stack.image = others;
          stack.profile = SliceProfile::Gaussian;
          stack.thickness = 4;
          for (float v : renderStack(field, stack, options).voxels)
            ASSERT_TRUE(std::isfinite(v));
        }
      }
}

TEST(FieldCheck, AGiantCoversTheWholeGrid) {
  GaussianField field = goodField(1);
  field.gaussians.resize(1);
  Gaussian& g = field.gaussians[0];
  g.intensity = 0.5f;
  std::fill_n(g.slope, 3, 0.f);
  for (const float logScale : {8.f, 14.f, 19.9f}) {
    std::fill_n(g.logScale, 3, logScale);
    g.logWeight = 0;
    ASSERT_TRUE(accepted(field));
    field.domain.spacing = {0.01, 0.01, 0.01};
    for (const std::string& set : instructionSets()) {
      RenderOptions options;
      options.instructionSet = set;
      for (float v : render(field, field.domain, options).voxels)
        ASSERT_NEAR(v, 0.5, 1e-3) << set << " " << logScale;
    }
    EXPECT_NEAR(renderPoints(field, std::vector<Vec3>{field.domain.origin}).at(0), 0.5, 1e-3);
  }
}
