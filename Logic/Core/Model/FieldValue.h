#pragma once
#include "Core/Model/DomainBox.h"
#include "Core/Model/ResidualSampler.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs {

/// Turns the Gaussians' blended value at continuous indices of a grid into the field's value: adds the
/// residual, converts to scanner units, clamps to the fitted range, and gives outside() where the field has
/// no value.
class FieldValue {
public:
  struct Options {
    bool ownChannel = true;          // false: renders a per-Gaussian value other than the intensity
    bool scannerUnits = true;        // false: I itself
    bool bounded = true;             // false: as the fit sees it, ignoring the support and the range
    std::string instructionSet = {}; // of the residual grid along rows; empty: the best
  };

  FieldValue(const GaussianField& field, const Affine3& indexToWorld, const Options& options)
      : ownChannel_(options.ownChannel), residual_(field, indexToWorld, options.instructionSet),
        box_(options.bounded ? field.region() : field.domain, indexToWorld) {
    const bool units = options.scannerUnits && ownChannel_;
    if (units) {
      scale_ = field.intensityScale;
      offset_ = field.intensityOffset;
    }
    outside_ = static_cast<float>(offset_);
    if (!options.bounded) return;
    if (units && field.range) {
      low_ = field.range->low;
      high_ = field.range->high;
    }
    if (field.support.voxels.empty()) return;
    support_ = &field.support;
    toSupport_ = inverse(support_->geometry.indexToWorld()) * indexToWorld;
    outside_ = units ? field.fill : 0;
  }

  /// The value where the field has none.
  float outside() const { return outside_; }

  bool limited() const { return support_ != nullptr; }

  /// Whether the voxel that holds the index is inside the support; the domain is not checked.
  bool supported(const Vec3& index) const {
    if (!support_) return true;
    const Vec3 x = toSupport_(index);
    const auto& n = support_->geometry.size;
    std::int64_t at[3];
    for (int a = 0; a < 3; ++a) {
      // A point between two voxels always goes to the same one, however it was computed.
      constexpr double half = 0.5 + 1e-5;
      if (!(x[a] >= -half && x[a] <= static_cast<double>(n[a]) - 1 + half)) return false;
      at[a] = std::clamp<std::int64_t>(static_cast<std::int64_t>(std::floor(x[a] + half)), 0, n[a] - 1);
    }
    return support_->voxels[static_cast<std::size_t>(at[0] + n[0] * (at[1] + n[1] * at[2]))] != 0;
  }

  bool has(const Vec3& index) const { return box_.contains(index) && supported(index); }

  /// The value in the requested units, at an index where the field has one.
  float operator()(float blended, const Vec3& index) const {
    return final(ownChannel_ ? blended + residual_(index) : blended);
  }
  /// As operator(), for a value that already includes the residual.
  float final(float value) const {
    return std::clamp(static_cast<float>(scale_ * value + offset_), low_, high_);
  }

  /// A row of a grid; calls blended(x) only inside the domain.
  template <class Blended>
  void row(double y, double z, int width, float* out, Blended&& blended) const {
    int begin = 0, end = width;
    box_.clipRow(y, z, begin, end);
    std::fill(out, out + begin, outside_);
    std::fill(out + end, out + width, outside_);
    for (int x = begin; x < end; ++x)
      out[x] = blended(x);
    if (ownChannel_) residual_.add(y, z, begin, end, out);
    for (int x = begin; x < end; ++x)
      out[x] = final(out[x]);
    if (!support_) return;
    for (int x = begin; x < end; ++x)
      if (!supported({static_cast<double>(x), y, z})) out[x] = outside_;
  }

private:
  bool ownChannel_;
  ResidualSampler residual_;
  DomainBox box_;
  double scale_ = 1, offset_ = 0;
  float outside_ = 0, low_ = -std::numeric_limits<float>::infinity(),
        high_ = std::numeric_limits<float>::infinity();
  const Mask* support_ = nullptr; // null: unlimited within the box
  Affine3 toSupport_;
};

} // namespace innergs
