#include "Core/Job/JobInput.h"
#include "Core/Alignment/SliceMotion.h"

#include "Core/Base/Error.h"
#include "Core/Base/Hash.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/StopToken.h"
#include "Core/Image/Region.h"
#include "Core/Image/Support.h"
#include "Core/Prediction/CandidateGrid.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <numeric>
#include <utility>

namespace innergs {
namespace {

constexpr double kLargerPixels = 1.5; // than another scan's, to average over their size

/// Whether some sample points of grid a lie inside grid b's box. With a gap: checks between the
/// outermost slices of a, and up to that many of b's slice distances before or after b.
bool reaches(const GridGeometry& a, const GridGeometry& b, double gap) {
  const Affine3 map = inverse(b.indexToWorld()) * a.indexToWorld();
  const double face = gap > 0 ? 0.5 : 0;
  const Vec3 margin{0.5, 0.5, 0.5 + gap};
  constexpr int n = 16;
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        const Vec3 at{i * (a.size[0] - 1.0) / n, j * (a.size[1] - 1.0) / n,
                      k * (a.size[2] - 1.0 + 2 * face) / n - face};
        const Vec3 x = map(at);
        bool inside = true;
        for (int c = 0; c < 3; ++c)
          inside = inside && x[c] >= -margin[c] && x[c] <= b.size[c] - 1 + margin[c];
        if (inside) return true;
      }
  return false;
}

bool overlap(const GridGeometry& a, const GridGeometry& b, double gap = 0) {
  return reaches(a, b, gap) || reaches(b, a, gap);
}

/// The first stack that no chain of overlapping or adjoining stacks, in any order, connects with the first;
/// 0: none. Two stacks adjoin if at most one slice fits between them. Stacks with poses may lie anywhere.
std::size_t apart(std::span<const Stack> stacks) {
  constexpr double gap = 1 + 1e-3;
  const auto together = [&](const Stack& a, const Stack& b) {
    return !a.poses.empty() || !b.poses.empty() || overlap(a.image.geometry, b.image.geometry, gap);
  };
  std::vector<std::size_t> toDo{0}, left(stacks.size() - 1);
  std::iota(left.begin(), left.end(), std::size_t{1});
  while (!toDo.empty() && !left.empty()) {
    const Stack& stack = stacks[toDo.back()];
    toDo.pop_back();
    const auto joined = std::stable_partition(
        left.begin(), left.end(), [&](std::size_t other) { return !together(stack, stacks[other]); });
    toDo.insert(toDo.end(), joined, left.end());
    left.erase(joined, left.end());
  }
  return left.empty() ? 0 : left.front();
}

/// Whether a stack's centre lies outside of the first one's box, as those of slabs and stations do.
bool liesBeside(const Stack& stack, const GridGeometry& first) {
  return stack.poses.empty() &&
         depthInside(first, inverse(first.indexToWorld())(stack.image.geometry.centre())) < 0;
}

/// `grid`, extended by whole voxels until it covers those of the stacks that `wanted` accepts. whole: it
/// keeps all of its own voxels; otherwise only its axes and spacing count.
GridGeometry grown(GridGeometry grid, std::span<const Stack> stacks,
                   const std::function<bool(const Stack&)>& wanted, bool whole = true) {
  const Affine3 worldToIndex = inverse(grid.indexToWorld());
  constexpr double kInfinity = std::numeric_limits<double>::infinity();
  Vec3 low{kInfinity, kInfinity, kInfinity}, high = -1.0 * low;
  for (int a = 0; a < 3 && whole; ++a) {
    low[a] = -0.5;
    high[a] = static_cast<double>(grid.size[a]) - 0.5;
  }
  for (const Stack& stack : stacks) {
    if (!wanted(stack)) continue;
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
    first[a] = whole ? std::floor(low[a] + 0.5 + 1e-4) : low[a] + 0.5;
    grid.size[a] = static_cast<std::int64_t>(std::ceil(high[a] + 0.5 - 1e-4) - first[a]);
  }
  grid.origin = grid.indexToWorld()(first);
  return grid;
}

/// The mask at the stack's voxels, where the poses put them.
std::vector<std::uint8_t> maskOn(const Stack& stack, const Mask& mask, const std::stop_token& stop) {
  if (stack.poses.empty()) return resampleMask(mask, stack.image.geometry, stop);
  std::vector<std::uint8_t> inside;
  inside.reserve(stack.image.voxels.size());
  for (std::size_t k = 0; k < stack.poses.size(); ++k) {
    GridGeometry slice = stack.image.geometry;
    slice.size[2] = 1;
    slice.origin = stack.poses[k](slice.indexToWorld()({0, 0, static_cast<double>(k)}));
    slice.direction = stack.poses[k].linear * slice.direction;
    const std::vector<std::uint8_t> part = resampleMask(mask, slice, stop);
    inside.insert(inside.end(), part.begin(), part.end());
  }
  return inside;
}

void applyMask(Stack& stack, const Mask& mask, const std::stop_token& stop) {
  const std::vector<std::uint8_t> inside = maskOn(stack, mask, stop);
  if (stack.observed.empty())
    stack.observed = inside;
  else
    for (std::size_t v = 0; v < inside.size(); ++v)
      stack.observed[v] = stack.observed[v] && inside[v];
}

std::vector<std::int64_t> holdOut(Stack& stack, double fraction) {
  std::vector<std::int64_t> heldOut;
  const std::int64_t slices = stack.image.geometry.size[2];
  const std::int64_t every = std::max<std::int64_t>(2, std::llround(std::min(1 / fraction, 1e9)));
  for (std::int64_t k = every / 2; k + 1 < slices; k += every)
    if (k > 0) heldOut.push_back(k);
  if (heldOut.empty() && slices > 2) heldOut.push_back(slices / 2);
  if (stack.observed.empty()) stack.observed.assign(stack.image.voxels.size(), 1);
  const std::int64_t plane = stack.image.geometry.size[0] * stack.image.geometry.size[1];
  for (std::int64_t k : heldOut)
    std::fill_n(stack.observed.begin() + k * plane, plane, std::uint8_t{0});
  return heldOut;
}

std::int64_t usable(const Stack& stack) {
  std::int64_t n = 0;
  for (std::size_t v = 0; v < stack.image.voxels.size(); ++v)
    n += isKnown(stack, v);
  return n;
}

/// The value of all usable voxels if they share one.
std::optional<float> onlyValue(const Stack& stack) {
  std::optional<float> value;
  for (std::size_t v = 0; v < stack.image.voxels.size(); ++v) {
    const float voxel = stack.image.voxels[v];
    if (!isKnown(stack, v)) continue;
    if (value && *value != voxel) return {};
    value = voxel;
  }
  return value;
}

/// Refuses a scan without content where another shows some: their values would be averaged.
void checkContent(std::span<const Stack> stacks) {
  std::vector<std::optional<float>> only;
  for (const Stack& stack : stacks)
    only.push_back(onlyValue(stack));
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    if (!only[s]) continue;
    for (std::size_t other = 0; other < stacks.size(); ++other)
      if (!only[other] && usable(stacks[other]) > 0 &&
          overlap(stacks[s].image.geometry, stacks[other].image.geometry))
        throw Error(ErrorCode::NoData,
                    formatted("%s shows nothing: all its %svoxels are %g. Leave it out.",
                              nameOf(stacks[s], s).c_str(), stacks[s].observed.empty() ? "" : "observed ",
                              static_cast<double>(*only[s])));
  }
}

/// How many slices repeat the one before, apart from slices of a single value.
std::int64_t repeatedSlices(const Volume& image) {
  const std::int64_t plane = image.geometry.size[0] * image.geometry.size[1];
  std::int64_t repeated = 0;
  for (std::int64_t k = 1; k < image.geometry.size[2]; ++k) {
    const auto slice = image.voxels.begin() + k * plane;
    repeated += std::equal(slice, slice + plane, slice - plane) &&
                std::any_of(slice, slice + plane, [&](float v) { return v != *slice; });
  }
  return repeated;
}

/// Tells that a scan has fewer slices than its header claims.
std::string repetitionSentence(const Stack& stack, const std::string& name) {
  const std::int64_t repeated = repeatedSlices(stack.image), slices = stack.image.geometry.size[2];
  if (repeated == 0) return {};
  return formatted(
      "%lld of the %lld slices of %s repeat%s the slice before, voxel by voxel: the volume has steps "
      "there. Leave the copies out and correct the slice distance.",
      static_cast<long long>(repeated), static_cast<long long>(slices), name.c_str(),
      repeated == 1 ? "s" : "");
}

/// The masks of stacks that alignment has moved, moved with them.
std::vector<Mask> movedMasks(const ReconstructionInput& input, std::span<const Stack> stacks) {
  std::vector<Mask> masks = input.masks;
  for (std::size_t s = 0; s < masks.size(); ++s) {
    GridGeometry& g = masks[s].geometry;
    const Affine3 move =
        stacks[s].image.geometry.indexToWorld() * inverse(input.stacks[s].image.geometry.indexToWorld());
    g.origin = move(g.origin);
    g.direction = move.linear * g.direction;
  }
  return masks;
}

/// The share of the volume (mm³) in blocks of `reach` mm that contain a voxel of the mask.
double maskedShare(const Mask& mask, double volume, double reach) {
  if (mask.voxels.empty()) return 1;
  const GridGeometry& g = mask.geometry;
  std::array<std::int64_t, 3> edge, blocks;
  for (int a = 0; a < 3; ++a) {
    edge[a] = std::clamp<std::int64_t>(std::llround(reach / g.spacing[a]), 1, g.size[a]);
    blocks[a] = (g.size[a] + edge[a] - 1) / edge[a];
  }
  std::vector<std::uint8_t> held(static_cast<std::size_t>(blocks[0] * blocks[1] * blocks[2]), 0);
  std::size_t v = 0;
  for (std::int64_t k = 0; k < g.size[2]; ++k)
    for (std::int64_t j = 0; j < g.size[1]; ++j) {
      std::uint8_t* row = held.data() + blocks[0] * (j / edge[1] + blocks[1] * (k / edge[2]));
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        row[i / edge[0]] |= mask.voxels[v++] != 0;
    }
  const double block =
      g.spacing[0] * g.spacing[1] * g.spacing[2] * static_cast<double>(edge[0] * edge[1] * edge[2]);
  const auto count = static_cast<double>(std::count(held.begin(), held.end(), 1));
  return std::clamp(count * block / volume, 1e-3, 1.0);
}

/// Several scans without poses, of slices clearly farther apart than their pixels.
bool severalThick(std::span<const Stack> stacks) {
  return stacks.size() > 1 && std::all_of(stacks.begin(), stacks.end(), [](const Stack& stack) {
           return stack.poses.empty() && hasThickSlices(stack);
         });
}

constexpr double kSliceBySlice = 3; // mm: scans this coarse are hardly acquired as one volume

} // namespace

double maskedShare(const ReconstructionInput& input, double volume, double reach) {
  if (input.masks.empty()) return 1;
  double share = 0;
  for (const Mask& mask : input.masks)
    share = std::max(share, maskedShare(mask, volume, reach));
  return share;
}

bool correctsSlices(const Settings& settings, std::span<const Stack> stacks) {
  return settings.sliceMotion != SliceMotionKind::Off && stacks.size() > 1 &&
         std::all_of(stacks.begin(), stacks.end(), [&](const Stack& stack) {
           return stack.poses.empty() &&
                  (settings.sliceMotion == SliceMotionKind::On || hasThickSlices(stack) ||
                   stack.image.geometry.spacing[2] >= kSliceBySlice);
         });
}

bool predictsEach(const Settings& settings, const DataTraits& traits, std::span<const Stack> stacks,
                  bool masked) {
  return settings.prediction != PredictionKind::None && settings.consistency && !masked && !traits.posed &&
         traits.thickness > 0 && (settings.preset == Preset::Balanced || settings.preset == Preset::Best) &&
         chosenBlending(settings) == Blending::Normalised && severalThick(stacks) &&
         !predicts(settings, traits);
}

double pixelWidth(const Stack& scan, std::span<const Stack> scans, const Settings& settings) {
  if (scans.size() < 2) return scan.pixelWidth;
  if (settings.pixelWidth) return *settings.pixelWidth;
  if (scan.pixelWidth > 0) return scan.pixelWidth;
  const auto pixel = [](const Stack& s) {
    return std::min(s.image.geometry.spacing[0], s.image.geometry.spacing[1]);
  };
  double finest = pixel(scan);
  for (const Stack& other : scans)
    finest = std::min(finest, pixel(other));
  return pixel(scan) >= kLargerPixels * finest ? pixel(scan) : 0;
}

double voxelsOf(std::span<const Stack> stacks) {
  double count = 0;
  for (const Stack& stack : stacks)
    count += static_cast<double>(stack.image.geometry.voxelCount());
  return count;
}

std::string nameOf(const Stack& stack, std::size_t index) {
  return stack.name.empty() ? "Stack " + std::to_string(index + 1) : stack.name;
}

std::span<const Stack> startStacks(const PreparedInput& prepared, std::vector<Stack>& bridged) {
  if (std::all_of(prepared.heldOut.begin(), prepared.heldOut.end(),
                  [](const auto& heldOut) { return heldOut.empty(); }))
    return prepared.stacks;
  bridged = prepared.stacks;
  for (std::size_t s = 0; s < bridged.size(); ++s) {
    Stack& stack = bridged[s];
    const auto& heldOut = prepared.heldOut[s];
    if (heldOut.empty()) continue;
    const auto& size = stack.image.geometry.size;
    const std::int64_t plane = size[0] * size[1];
    const auto fitted = [&](std::int64_t k) {
      return std::find(heldOut.begin(), heldOut.end(), k) == heldOut.end();
    };
    for (const std::int64_t k : heldOut) {
      std::int64_t below = k - 1, above = k + 1;
      while (below >= 0 && !fitted(below))
        --below;
      while (above < size[2] && !fitted(above))
        ++above;
      if (below < 0 || above >= size[2]) continue;
      const auto share = static_cast<float>(k - below) / static_cast<float>(above - below);
      for (std::int64_t p = 0; p < plane; ++p) {
        const std::size_t v = k * plane + p;
        const float low = stack.image.voxels[below * plane + p], high = stack.image.voxels[above * plane + p];
        stack.image.voxels[v] = low + share * (high - low);
        stack.observed[v] = prepared.scored[s].empty() || prepared.scored[s][v];
      }
    }
  }
  return bridged;
}

namespace {

/// Spacing along K says nothing finer than the pixels where slices with poses overlap.
double finestSpacing(std::span<const Stack> stacks) {
  double spacing = 1e300;
  for (const Stack& stack : stacks) {
    const Vec3& s = stack.image.geometry.spacing;
    spacing = std::min({spacing, s[0], s[1]});
    if (stack.poses.empty() || stack.thickness <= s[2]) spacing = std::min(spacing, s[2]);
  }
  return spacing;
}

/// The finest isotropic grid along the first stack's axes, over the box of all slices where their poses put
/// them. whole: also over the first stack as its geometry says.
GridGeometry coveringGrid(std::span<const Stack> stacks, bool whole) {
  const double s = finestSpacing(stacks);
  return grown(
      withSpacing(stacks.front().image.geometry, {s, s, s}), stacks, [](const Stack&) { return true; },
      whole);
}

} // namespace

GridGeometry acquisitionGrid(std::span<const Stack> stacks) {
  const Stack& first = stacks.front();
  const GridGeometry& grid = first.image.geometry;
  if (!first.poses.empty()) return coveringGrid(stacks, false);
  const auto beside = [&](const Stack& stack) { return liesBeside(stack, grid); };
  if (std::none_of(stacks.begin(), stacks.end(), beside)) return grid;
  return grown(grid, stacks, beside);
}

GridGeometry defaultOutputGrid(std::span<const Stack> stacks) {
  if (!stacks.front().poses.empty()) return coveringGrid(stacks, false);
  const double spacing = finestSpacing(stacks);
  return withSpacing(acquisitionGrid(stacks), {spacing, spacing, spacing});
}

GridGeometry dataDomain(std::span<const Stack> stacks) {
  const GridGeometry domain = defaultOutputGrid(stacks);
  const Stack& first = stacks.front();
  if (stacks.size() == 1 || !first.poses.empty()) return domain;
  return grown(domain, stacks, [](const Stack&) { return true; });
}

GridGeometry predictedGrid(std::span<const Stack> stacks, const GridGeometry& output) {
  const auto order = [](const Stack& stack) { // of two with the same pixels, the larger comes first
    const GridGeometry& g = stack.image.geometry;
    const Vec3 extent = g.extent();
    return std::pair(std::min(g.spacing[0], g.spacing[1]), -extent[0] * extent[1] * extent[2]);
  };
  const auto finest = std::min_element(stacks.begin(), stacks.end(),
                                       [&](const Stack& a, const Stack& b) { return order(a) < order(b); });
  GridGeometry grid = finest->image.geometry;
  if (stacks.size() > 1) grid = grown(grid, stacks, [](const Stack&) { return true; });
  return candidateGrid(grid, output);
}

Affine3 modelFrame(const GridGeometry& geometry) {
  Affine3 frame{geometry.direction, geometry.centre()};
  if (determinant(frame.linear) < 0)
    for (int i = 0; i < 3; ++i)
      frame.linear[i][0] = -frame.linear[i][0];
  return frame;
}

double heldOutFraction(const ReconstructionInput& input) {
  return input.uncertainty && input.heldOutFraction == 0 ? kUsualFraction : input.heldOutFraction;
}

void checkHeldOutFraction(double fraction) {
  if (!(fraction >= 0 && fraction <= 0.5))
    throw Error(ErrorCode::InvalidArgument, "The held-out fraction must be between 0 and 0.5.");
}

PreparedInput prepareInput(const ReconstructionInput& input, const std::stop_token& stop, bool heldOut,
                           const CorrectStacks& correct) {
  if (input.stacks.empty())
    throw Error(ErrorCode::InvalidArgument, "There is no image to reconstruct from: give at least one.");
  if (input.masks.size() > 1 && input.masks.size() != input.stacks.size())
    throw Error(
        ErrorCode::InvalidArgument,
        formatted("There are %zu masks for %zu scan%s: give one mask for all, or one per scan in their "
                  "order.",
                  input.masks.size(), input.stacks.size(), input.stacks.size() == 1 ? "" : "s"));
  checkHeldOutFraction(input.heldOutFraction);
  const double fraction = heldOut ? heldOutFraction(input) : 0;
  PreparedInput prepared;
  prepared.stacks = input.stacks;
  auto& stacks = prepared.stacks;
  std::uint64_t h = kHashStart;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    Stack& stack = stacks[s];
    throwIfStopped(stop);
    checkStack(stack);
    const auto& size = stack.image.geometry.size;
    if (size[0] > 65536 || size[1] > 65536 || size[2] > 65536)
      throw Error(ErrorCode::Geometry,
                  nameOf(stack, s) + " has an axis of more than 65536 voxels: crop it to a region first.");
    if (size[2] < 2)
      throw Error(ErrorCode::UnsupportedImage,
                  nameOf(stack, s) + " has a single slice; at least two are needed.");
    for (float v : stack.image.voxels)
      prepared.nonFinite += !std::isfinite(v);
    throwIfStopped(stop);
    if (input.masks.empty()) continue;
    applyMask(stack, input.masks[input.masks.size() == 1 ? 0 : s], stop);
    if (input.masks.size() > 1 && usable(stack) == 0)
      throw Error(ErrorCode::NoData, "The mask of " + nameOf(stack, s) +
                                         " holds no centre of its finite voxels: check that the mask belongs "
                                         "to it and that the masks are in the order of the scans.");
  }
  if (const std::size_t s = apart(stacks); s > 0)
    throw Error(ErrorCode::Geometry,
                nameOf(stacks[s], s) + " does not overlap " + nameOf(stacks[0], 0) +
                    " in patient space, and more than a slice would fit between them: check that they are "
                    "scans of the same patient.");
  std::int64_t samples = 0;
  for (const Stack& stack : stacks)
    samples += usable(stack);
  if (samples == 0)
    throw Error(ErrorCode::NoData,
                !input.masks.empty()
                    ? "The mask holds no centre of a finite voxel of the images: check that it "
                      "belongs to them and is not smaller than their voxels."
                    : "The images have no finite observed voxel: there is nothing to fit.");
  checkContent(stacks);
  for (const Stack& stack : stacks)
    prepared.scored.push_back(fraction > 0 ? stack.observed : std::vector<std::uint8_t>{});
  for (Stack& stack : stacks)
    prepared.heldOut.push_back(fraction > 0 ? holdOut(stack, fraction) : std::vector<std::int64_t>{});
  if (correct) prepared.warnings = correct(stacks);
  // The usual output grid does not follow slices that move.
  const bool moved =
      std::any_of(stacks.begin(), stacks.end(), [](const Stack& s) { return !s.poses.empty(); });
  const GridGeometry usual = defaultOutputGrid(moved ? input.stacks : stacks);
  const bool firstMoved = input.stacks.front().poses.empty() && !stacks.front().poses.empty();
  prepared.domain = firstMoved ? coveringGrid(stacks, true) : dataDomain(stacks);
  if (!input.masks.empty())
    prepared.support = supportOf(input.masks.size() == 1 ? input.masks : movedMasks(input, stacks), stacks,
                                 prepared.domain, supportMargin(stacks), stop);
  prepared.range = observedRange(stacks);
  for (const Stack& stack : stacks) {
    throwIfStopped(stop);
    hash(h, &stack.image.geometry, sizeof(GridGeometry));
    hash(h, &stack.thickness, sizeof(double));
    hash(h, &stack.pixelWidth, sizeof(double));
    hash(h, &stack.profile, sizeof(stack.profile));
    hash(h, stack.image.voxels.data(), stack.image.voxels.size() * sizeof(float));
    hash(h, stack.observed.data(), stack.observed.size());
    hash(h, stack.poses.data(), stack.poses.size() * sizeof(Affine3));
  }
  prepared.fingerprint = formatted("%016llx", static_cast<unsigned long long>(h));
  const bool posed =
      std::any_of(input.stacks.begin(), input.stacks.end(), [](const Stack& s) { return !s.poses.empty(); });
  prepared.outputGrid = input.outputGrid ? *input.outputGrid : posed ? prepared.domain : usual;
  checkGeometry(prepared.outputGrid, "The output grid");
  if (!input.masks.empty() && (!input.outputGrid || input.cropToMask))
    if (const auto block = blockOver(prepared.outputGrid, boxOf(prepared.support.geometry)))
      prepared.outputGrid = cropped(prepared.outputGrid, block->first, block->size);
  if (!posed && std::none_of(stacks.begin(), stacks.end(), [&](const Stack& stack) {
        return overlap(stack.image.geometry, prepared.outputGrid);
      }))
    throw Error(
        ErrorCode::Geometry,
        "The output grid does not overlap the images in patient space: choose another reference or region.");
  for (std::size_t s = 0; s < stacks.size(); ++s)
    if (std::string said = repetitionSentence(input.stacks[s], nameOf(stacks[s], s)); !said.empty())
      prepared.warnings.push_back(std::move(said));
  for (const Stack& stack : input.stacks)
    prepared.warnings.insert(prepared.warnings.end(), stack.remarks.begin(), stack.remarks.end());
  if (prepared.nonFinite > 0)
    prepared.warnings.push_back(std::to_string(prepared.nonFinite) +
                                " voxels are not finite (NaN or infinite); they were left out of the fit.");
  return prepared;
}

} // namespace innergs
