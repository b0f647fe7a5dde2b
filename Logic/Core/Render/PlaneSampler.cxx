#include "Core/Render/PlaneSampler.h"

#include "Core/Base/Error.h"
#include "Core/Model/FieldValue.h"
#include "Core/Render/FieldDevice.h"
#include "Core/Render/GridRenderer.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr std::int64_t kSearchedPerTask = 16384; // Gaussians
constexpr int kLargest = 32768;                  // pixels along one axis

/// The plane's map with a unit normal as its third column.
Affine3 completed(Affine3 map) {
  const Vec3 u = column(map.linear, 0), v = column(map.linear, 1), n = cross(u, v);
  const double area = norm(n), scale = norm(u) * norm(v);
  if (!std::isfinite(area) || !std::isfinite(norm(map.offset)) || !(area > 1e-9 * scale))
    throw Error(ErrorCode::Geometry,
                "The plane's two axes must be finite and point in different directions: correct its matrix.");
  const double along = dot(column(map.linear, 2), n) / area;
  if (std::abs(std::abs(along) - 1) < 1e-12 && norm(column(map.linear, 2)) - 1 < 1e-12) return map; // is one
  for (int i = 0; i < 3; ++i)
    map.linear[i][2] = n[i] / area;
  return map;
}

} // namespace

PlaneSampler::PlaneSampler(std::shared_ptr<const GaussianField> field, int threads,
                           const std::string& instructionSet, std::shared_ptr<FieldDevice> device)
    : field_(std::move(field)), instructionSet_(instructionSet), device_(std::move(device)), pool_(threads) {
  checkField(*field_);
  kernelSet(instructionSet_);
  near_.blending = field_->blending;
  near_.linearIntensity = field_->linearIntensity;
  near_.epsilon = field_->epsilon;
  near_.cutoff = field_->cutoff;
  near_.modelToWorld = field_->modelToWorld;
  if (!device_) measureReach();
}

PlaneSampler::~PlaneSampler() = default;

void PlaneSampler::measureReach() {
  const std::size_t n = field_->gaussians.size();
  for (auto* v : {&x_, &y_, &z_, &reach_})
    v->resize(n);
  pool_.blocks(static_cast<std::int64_t>(n), kSearchedPerTask, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const Gaussian& g = field_->gaussians[i];
      x_[i] = g.mean[0], y_[i] = g.mean[1], z_[i] = g.mean[2];
      const float widest = std::max({g.logScale[0], g.logScale[1], g.logScale[2]});
      // Slightly enlarged, to allow for the rounding of centres and distances.
      reach_[i] = static_cast<float>(field_->cutoff) * std::exp(widest) * 1.001f + 1e-3f +
                  1e-6f * (std::abs(x_[i]) + std::abs(y_[i]) + std::abs(z_[i]));
    }
  });
}

bool PlaneSampler::sampledOnDevice(const SampleGrid& grid, float* out, const std::stop_token& stop) {
  if (!device_) return false;
  try {
    device_->renderGrid(grid, {}, {}, out, stop);
    return true;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Cancelled) throw;
  } catch (const std::exception&) {
  }
  device_ = nullptr;
  measureReach();
  return false;
}

void PlaneSampler::selectNear(const Affine3& pixelToModel, int nx, int ny) {
  const Vec3 n = column(pixelToModel.linear, 2), centre = pixelToModel({0.5 * (nx - 1), 0.5 * (ny - 1), 0});
  double radius = 0; // of the rectangle
  for (const double corner : {0.0, nx - 1.0})
    radius = std::max(radius, norm(pixelToModel({corner, 0, 0}) - centre));
  const float c[3] = {float(centre[0]), float(centre[1]), float(centre[2])};
  const float m[3] = {float(n[0]), float(n[1]), float(n[2])}, r = static_cast<float>(radius * 1.0001 + 1e-3);
  const auto count = static_cast<std::int64_t>(x_.size());
  chosen_.resize((count + kSearchedPerTask - 1) / kSearchedPerTask);
  pool_.run(static_cast<std::int64_t>(chosen_.size()), [&](std::int64_t block) {
    auto& list = chosen_[block];
    list.clear();
    for (std::int64_t i = block * kSearchedPerTask; i < std::min(count, (block + 1) * kSearchedPerTask);
         ++i) {
      const float d[3] = {x_[i] - c[0], y_[i] - c[1], z_[i] - c[2]};
      const float off = std::abs(m[0] * d[0] + m[1] * d[1] + m[2] * d[2]), far = r + reach_[i];
      if (off <= reach_[i] && d[0] * d[0] + d[1] * d[1] + d[2] * d[2] <= far * far)
        list.push_back(static_cast<std::uint32_t>(i));
    }
  });
  near_.gaussians.clear();
  for (const auto& list : chosen_)
    for (const std::uint32_t i : list)
      near_.gaussians.push_back(field_->gaussians[i]);
}

void PlaneSampler::sample(const Affine3& pixelToWorld, int nx, int ny, std::span<float> out,
                          std::stop_token stop) {
  if (nx < 1 || ny < 1 || nx > kLargest || ny > kLargest)
    throw Error(ErrorCode::InvalidArgument, "A plane must have between 1 and " + std::to_string(kLargest) +
                                                " pixels along each of its axes.");
  if (out.size() != static_cast<std::size_t>(nx) * static_cast<std::size_t>(ny))
    throw Error(ErrorCode::InvalidArgument, "The buffer of a plane does not have its number of pixels.");
  pool_.setStop(std::move(stop));
  const Affine3 world = completed(pixelToWorld);
  SampleGrid grid;
  grid.indexToModel = inverse(field_->modelToWorld) * world;
  grid.nx = nx;
  grid.ny = ny;
  grid.z = {0.0};
  const bool ready = sampledOnDevice(grid, out.data(), pool_.stopToken());
  if (!ready) {
    selectNear(grid.indexToModel, nx, ny);
    weights_.resize(grid.bufferSize());
    numerators_.resize(grid.bufferSize());
    GridRenderer renderer(grid, kernelSet(instructionSet_), pool_);
    renderer.forward(near_, {}, weights_.data(), numerators_.data());
  }
  const FieldValue value(*field_, world, {.instructionSet = instructionSet_});
  const bool normalised = field_->blending == Blending::Normalised;
  const auto epsilon = static_cast<float>(field_->epsilon);
  pool_.blocks(ny, 16, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t y = first; y < last; ++y) {
      const float* w = weights_.data() + (ready ? 0 : y * grid.stride());
      const float* n = numerators_.data() + (ready ? 0 : y * grid.stride());
      float* row = out.data() + y * nx;
      value.row(static_cast<double>(y), 0, nx, row, [&](int x) {
        return ready ? row[x] : normalised ? n[x] / (w[x] + epsilon) : n[x];
      });
    }
  });
}

} // namespace innergs
