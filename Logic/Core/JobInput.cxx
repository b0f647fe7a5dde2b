#include "Core/JobInput.h"

#include "Core/Error.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>

namespace innergs {
namespace {

std::string nameOf(const Stack& stack, std::size_t index) {
  return stack.name.empty() ? "Stack " + std::to_string(index + 1) : stack.name;
}

/// Whether some sample points of lattice a lie inside lattice b's box.
bool reaches(const GridGeometry& a, const GridGeometry& b) {
  const Affine3 map = inverse(b.indexToWorld()) * a.indexToWorld();
  constexpr int n = 16;
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const Vec3 at{i * (a.size[0] - 1.0) / n, j * (a.size[1] - 1.0) / n, k * (a.size[2] - 1.0) / n};
        const Vec3 x = map(at);
        bool inside = true;
        for (int c = 0; c < 3; ++c)
          inside = inside && x[c] >= -0.5 && x[c] <= b.size[c] - 0.5;
        if (inside) return true;
      }
  return false;
}

bool overlap(const GridGeometry& a, const GridGeometry& b) {
  return reaches(a, b) || reaches(b, a);
}

void hash(std::uint64_t& h, const void* data, std::size_t bytes) { // FNV-1a over 8-byte words
  const char* p = static_cast<const char*>(data);
  for (; bytes > 0;) {
    std::uint64_t word = 0;
    const std::size_t n = std::min<std::size_t>(8, bytes);
    std::memcpy(&word, p, n);
    h = (h ^ word) * 0x100000001b3ull;
    h ^= h >> 29;
    p += n;
    bytes -= n;
  }
}

void applyMask(Stack& stack, const Mask& mask, const std::stop_token& stop) {
  const std::vector<std::uint8_t> inside = resampleMask(mask, stack.image.geometry, stop);
  if (stack.observed.empty())
    stack.observed = inside;
  else
    for (std::size_t v = 0; v < inside.size(); ++v)
      stack.observed[v] = stack.observed[v] && inside[v];
}

std::vector<std::int64_t> withhold(Stack& stack, double fraction) {
  std::vector<std::int64_t> withheld;
  const std::int64_t slices = stack.image.geometry.size[2];
  const std::int64_t every = std::max<std::int64_t>(2, std::llround(1 / fraction));
  for (std::int64_t k = every / 2; k + 1 < slices; k += every)
    if (k > 0) withheld.push_back(k);
  if (withheld.empty() && slices > 2) withheld.push_back(slices / 2);
  if (stack.observed.empty()) stack.observed.assign(stack.image.voxels.size(), 1);
  const std::int64_t plane = stack.image.geometry.size[0] * stack.image.geometry.size[1];
  for (std::int64_t k : withheld)
    std::fill_n(stack.observed.begin() + k * plane, plane, std::uint8_t{0});
  return withheld;
}

std::int64_t usable(const Stack& stack) {
  std::int64_t n = 0;
  for (std::size_t v = 0; v < stack.image.voxels.size(); ++v)
    n += std::isfinite(stack.image.voxels[v]) && (stack.observed.empty() || stack.observed[v]);
  return n;
}

} // namespace

GridGeometry defaultOutputGrid(std::span<const Stack> stacks) {
  double spacing = 1e300;
  for (const Stack& stack : stacks)
    for (double s : stack.image.geometry.spacing)
      spacing = std::min(spacing, s);
  return withSpacing(stacks.front().image.geometry, {spacing, spacing, spacing});
}

GridGeometry dataDomain(std::span<const Stack> stacks) {
  GridGeometry domain = defaultOutputGrid(stacks);
  if (stacks.size() == 1 && stacks.front().poses.empty()) return domain;
  const Affine3 worldToIndex = inverse(domain.indexToWorld());
  Vec3 low{-0.5, -0.5, -0.5}, high;
  for (int a = 0; a < 3; ++a)
    high[a] = static_cast<double>(domain.size[a]) - 0.5;
  for (const Stack& stack : stacks) {
    const auto& size = stack.image.geometry.size;
    for (std::int64_t k = 0; k < size[2]; ++k) {
      const Affine3 pose = stack.poses.empty() ? Affine3{} : stack.poses[k];
      for (int corner = 0; corner < 8; ++corner) {
        const Vec3 index{corner & 1 ? size[0] - 0.5 : -0.5, corner & 2 ? size[1] - 0.5 : -0.5,
                         static_cast<double>(k) + (corner & 4 ? 0.5 : -0.5)};
        const Vec3 x = worldToIndex(pose(stack.image.geometry.indexToWorld()(index)));
        for (int a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], x[a]);
          high[a] = std::max(high[a], x[a]);
        }
      }
    }
  }
  Vec3 first;
  for (int a = 0; a < 3; ++a) {
    first[a] = std::floor(low[a] + 0.5 + 1e-4);
    domain.size[a] = static_cast<std::int64_t>(std::ceil(high[a] + 0.5 - 1e-4) - first[a]);
  }
  domain.origin = domain.indexToWorld()(first);
  return domain;
}

Affine3 modelFrame(const GridGeometry& geometry) {
  Affine3 frame{geometry.direction, geometry.centre()};
  if (determinant(frame.linear) < 0)
    for (int i = 0; i < 3; ++i)
      frame.linear[i][0] = -frame.linear[i][0];
  return frame;
}

PreparedInput prepareInput(const ReconstructionInput& input, const std::stop_token& stop) {
  const auto throwIfStopped = [&] {
    if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "Stopped on request.");
  };
  if (input.stacks.empty())
    throw Error(ErrorCode::InvalidArgument, "There is no image to reconstruct from: give at least one.");
  if (!(input.heldOutFraction >= 0 && input.heldOutFraction <= 0.5))
    throw Error(ErrorCode::InvalidArgument, "The held-out fraction must be between 0 and 0.5.");
  PreparedInput prepared;
  prepared.stacks = input.stacks;
  auto& stacks = prepared.stacks;
  std::uint64_t h = 0xcbf29ce484222325ull;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    Stack& stack = stacks[s];
    throwIfStopped();
    checkStack(stack);
    const auto& size = stack.image.geometry.size;
    if (size[0] > 65536 || size[1] > 65536 || size[2] > 65536)
      throw Error(ErrorCode::Geometry,
                  nameOf(stack, s) + " has an axis of more than 65536 voxels: cut it to a region first.");
    if (size[2] < 2)
      throw Error(ErrorCode::UnsupportedImage,
                  nameOf(stack, s) + " has a single slice; at least two are needed.");
    for (float v : stack.image.voxels)
      prepared.nonFinite += !std::isfinite(v);
    throwIfStopped();
    if (input.mask) applyMask(stack, *input.mask, stop);
    if (s > 0 && stack.poses.empty() && stacks[0].poses.empty() &&
        std::none_of(stacks.begin(), stacks.begin() + s,
                     [&](const Stack& other) { return overlap(other.image.geometry, stack.image.geometry); }))
      throw Error(ErrorCode::Geometry,
                  nameOf(stack, s) + " does not overlap " + nameOf(stacks[0], 0) +
                      " in patient space: check that they are scans of the same patient.");
  }
  std::int64_t samples = 0;
  for (const Stack& stack : stacks)
    samples += usable(stack);
  if (samples == 0)
    throw Error(ErrorCode::NoData,
                input.mask
                    ? "The mask does not cover any finite voxel of the images: check that it belongs to them."
                    : "The images have no finite observed voxel: there is nothing to fit.");
  for (const Stack& stack : stacks)
    prepared.scored.push_back(input.heldOutFraction > 0 ? stack.observed : std::vector<std::uint8_t>{});
  for (Stack& stack : stacks)
    prepared.heldOut.push_back(input.heldOutFraction > 0 ? withhold(stack, input.heldOutFraction)
                                                         : std::vector<std::int64_t>{});
  for (const Stack& stack : stacks) {
    throwIfStopped();
    hash(h, &stack.image.geometry, sizeof(GridGeometry));
    hash(h, &stack.thickness, sizeof(double));
    hash(h, &stack.profile, sizeof(stack.profile));
    hash(h, stack.image.voxels.data(), stack.image.voxels.size() * sizeof(float));
    hash(h, stack.observed.data(), stack.observed.size());
    hash(h, stack.poses.data(), stack.poses.size() * sizeof(Affine3));
  }
  char text[32];
  std::snprintf(text, sizeof(text), "%016llx", static_cast<unsigned long long>(h));
  prepared.fingerprint = text;
  const bool posed =
      std::any_of(stacks.begin(), stacks.end(), [](const Stack& s) { return !s.poses.empty(); });
  prepared.outputGrid = input.outputGrid ? *input.outputGrid
                        : posed          ? dataDomain(stacks)
                                         : defaultOutputGrid(stacks);
  checkGeometry(prepared.outputGrid, "The output grid");
  if (!posed && std::none_of(stacks.begin(), stacks.end(), [&](const Stack& stack) {
        return overlap(stack.image.geometry, prepared.outputGrid);
      }))
    throw Error(
        ErrorCode::Geometry,
        "The output grid does not overlap the images in patient space: choose another reference or region.");
  if (prepared.nonFinite > 0)
    prepared.warnings.push_back(std::to_string(prepared.nonFinite) +
                                " voxels are not finite (NaN or infinite); they were left out of the fit.");
  return prepared;
}

} // namespace innergs
