#include "Core/Model/GaussianField.h"

#include "Core/Base/Error.h"

#include <array>
#include <cmath>

namespace innergs {
namespace {

bool isRotation(const Mat3& a) {
  const Mat3 gram = transpose(a) * a;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (!(std::abs(gram[i][j] - (i == j)) <= 1e-3)) return false;
  return determinant(a) > 0;
}

bool usable(const Gaussian& g) {
  const auto within = [](float x, float limit) { return std::fabs(x) <= limit; }; // false for NaN too
  for (int a = 0; a < 3; ++a)
    if (!within(g.mean[a], 1e6f) || !within(g.logScale[a], 20.f) || !within(g.slope[a], 1e9f)) return false;
  float length = 0;
  for (float q : g.quaternion)
    length += q * q;
  return length > 1e-12f && length < 1e12f && within(g.logWeight, 40.f) && within(g.intensity, 1e12f);
}

} // namespace

const char* blendingName(Blending blending) {
  constexpr std::array names{"normalised", "additive", "alpha"};
  return names.at(static_cast<std::size_t>(blending));
}

std::optional<Blending> blendingNamed(const std::string& name) {
  for (const Blending blending : {Blending::Normalised, Blending::Additive, Blending::Alpha})
    if (name == blendingName(blending)) return blending;
  return {};
}

void checkField(const GaussianField& field) {
  const auto fail = [](const std::string& what) {
    throw Error(ErrorCode::FileFormat, "The model cannot be used: " + what);
  };
  if (field.gaussians.empty()) fail("it has no Gaussians.");
  if (!(field.epsilon >= 1e-12 && field.epsilon < 1)) fail("its ε is out of range.");
  if (!(field.cutoff > 0.5 && field.cutoff < 10)) fail("its cut-off radius is out of range.");
  if (!isRotation(field.modelToWorld.linear)) fail("its frame is not a rotation.");
  if (!isFinite(field.modelToWorld.offset)) fail("its frame is not finite.");
  if (!std::isfinite(field.intensityScale) || field.intensityScale == 0 ||
      !std::isfinite(field.intensityOffset))
    fail("its intensity map is not finite.");
  if (field.blending == Blending::Alpha && field.linearIntensity)
    fail("alpha blending has no linear intensity.");
  if (field.domain != GridGeometry{}) checkGeometry(field.domain, "The model's domain");
  if (!field.residual.voxels.empty()) {
    checkGeometry(field.residual.geometry, "The model's residual grid");
    if (static_cast<std::int64_t>(field.residual.voxels.size()) != field.residual.geometry.voxelCount())
      fail("its residual grid differs in size from what it says.");
    for (float x : field.residual.voxels)
      if (!(std::fabs(x) <= 1e12f)) fail("its residual grid is not finite.");
  }
  if (!field.support.voxels.empty()) {
    checkGeometry(field.support.geometry, "The model's support");
    if (static_cast<std::int64_t>(field.support.voxels.size()) != field.support.geometry.voxelCount())
      fail("its support differs in size from what it says.");
  }
  if (!std::isfinite(field.fill)) fail("its fill value is not finite.");
  if (field.range && !(std::isfinite(field.range->low) && std::isfinite(field.range->high) &&
                       field.range->low <= field.range->high))
    fail("its value range is not a range of finite values.");
  for (std::size_t i = 0; i < field.gaussians.size(); ++i)
    if (!usable(field.gaussians[i])) fail("Gaussian " + std::to_string(i) + " has parameters out of range.");
}

} // namespace innergs
