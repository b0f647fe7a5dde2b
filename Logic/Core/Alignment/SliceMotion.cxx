#include "Core/Alignment/SliceMotion.h"

#include "Core/Alignment/PacketRegistration.h"
#include "Core/Alignment/Rigid.h"
#include "Core/Alignment/SamplePlaces.h"
#include "Core/Alignment/SliceVolume.h"
#include "Core/Base/Median.h"
#include "Core/Base/NumberText.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace innergs {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kMostVoxels = 6'000'000; // of the finest volume
constexpr double kMargin = 8;                   // mm around the stacks' boxes

struct Level {
  double factor; // of the finest spacing
  int rounds, steps;
  double smoothness;
  int iterations;
};
constexpr double kWorthwhile = 0.5; // dB that poses must gain
// dB by which one volume must explain all slices better at their poses than at rest. With two stacks, single
// slices are free enough to fit each other's gaps; packets are not, nor are slices as thin as their pixels.
constexpr double kConsistentOfTwo = 5, kConsistent = 2, kConsistentWithoutGaps = 0.8;
// Times the median displacement or angle, and mm or degrees beyond that: unusually far.
constexpr double kFar = 3, kFarAtLeast = 1, kTurnedAtLeast = 3;
constexpr double kLittle = 0.5; // weight of slices that are listed
constexpr std::size_t kMostListed = 10;
constexpr Level kLevels[] = {{4, 6, 4, 0.1, 8}, {2, 5, 3, 0.1, 8}, {1, 5, 2, 0.24, 8}};

/// The finest spacing of the stacks, or one at which a grid around these boxes of them is not too large.
double finestSpacing(std::span<const GridGeometry> boxes) {
  double finest = std::numeric_limits<double>::max();
  for (const GridGeometry& box : boxes)
    finest = std::min({finest, box.spacing[0], box.spacing[1]});
  while (gridAround(boxes, finest, kMargin).voxelCount() > kMostVoxels)
    finest *= 1.05;
  return finest;
}

/// Pixels of a stack that are averaged at a spacing, along each axis.
int pixelsAt(const Stack& stack, double spacing) {
  const Vec3& pixel = stack.image.geometry.spacing;
  return std::max(1, static_cast<int>(std::floor(spacing / std::min(pixel[0], pixel[1]) + 0.25)));
}

/// The profile of slices to be registered. Of a box, fewer sub-planes than one per `resolution` (mm): Gauss's
/// three-point rule, exact for polynomials of fifth degree, in each of its parts of up to six times that.
ProfileQuadrature registeredProfile(const Stack& stack, double resolution) {
  const double thickness = effectiveThickness(stack);
  ProfileQuadrature q = profileQuadrature(stack.profile, thickness, resolution);
  if (stack.profile != SliceProfile::Box || q.offset.size() <= 3) return q;
  constexpr std::size_t kMost = 6;
  const auto parts = static_cast<int>((q.offset.size() + kMost - 1) / kMost);
  const double part = thickness / parts, beside = 0.5 * part * std::sqrt(0.6);
  q = {};
  for (int n = 0; n < parts; ++n)
    for (int side = -1; side <= 1; ++side) {
      q.offset.push_back((n + 0.5) * part - 0.5 * thickness + side * beside);
      q.weight.push_back((side == 0 ? 8.0 : 5.0) / (18 * parts));
    }
  return q;
}

/// Twice the sub-planes, as far apart as before. spacing: mm, used if there is only one.
ProfileQuadrature twiceAsThick(const ProfileQuadrature& profile, double spacing) {
  const double step = profile.offset.size() > 1 ? profile.offset[1] - profile.offset[0] : spacing;
  ProfileQuadrature twice;
  for (std::size_t q = 0; q < profile.offset.size(); ++q)
    for (const double side : {-0.5, 0.5}) {
      twice.offset.push_back(2 * profile.offset[q] + side * step);
      twice.weight.push_back(0.5 * profile.weight[q]);
    }
  return twice;
}

/// The volume with NaN where no slice, even twice as thick, covers it: there it is made up.
std::vector<float> shownPart(const std::vector<float>& volume, const SliceOperator& op,
                             std::span<const PlacedSlice* const> slices, double distance, ThreadPool& pool) {
  std::vector<PlacedSlice> thick(slices.size());
  std::vector<const PlacedSlice*> views;
  std::vector<std::vector<float>> images(slices.size());
  pool.run(static_cast<std::int64_t>(slices.size()), [&](std::int64_t s) {
    thick[s] = *slices[s];
    thick[s].profile = twiceAsThick(slices[s]->profile, op.grid().spacing[0]);
    images[s] = op.project(volume, thick[s]);
    for (float& value : images[s])
      value = std::isnan(value) ? 0 : 1;
  });
  for (const PlacedSlice& slice : thick)
    views.push_back(&slice);
  std::vector<float> shown(volume.size(), 0.f);
  op.addTransposed(views, images, shown);
  const auto least = static_cast<float>(0.25 * op.grid().spacing[0] / distance);
  for (std::size_t v = 0; v < shown.size(); ++v)
    shown[v] = shown[v] >= least ? volume[v] : std::numeric_limits<float>::quiet_NaN();
  return shown;
}

/// The median of the finite values.
double medianOf(std::vector<double> values) {
  std::erase_if(values, [](double value) { return !std::isfinite(value); });
  return median(std::move(values));
}

struct Fit {
  double squared = 0; // sum over the pixels
  std::int64_t pixels = 0;
  double rms() const { return pixels > 0 ? std::sqrt(squared / static_cast<double>(pixels)) : kNaN; }
};

/// One slice's squared differences to a volume.
Fit fitOf(const PlacedSlice& slice, const SliceOperator& op, const std::vector<float>& volume) {
  const std::vector<float> seen = op.project(volume, slice);
  Fit fit;
  for (std::size_t p = 0; p < seen.size(); ++p) {
    if (std::isnan(seen[p])) continue;
    const double r = slice.gain * seen[p] - slice.values[p];
    fit.squared += r * r;
    ++fit.pixels;
  }
  return fit;
}

/// The correlation of slices with a volume where both show the body: values of at least `threshold`.
double correlationOf(std::span<const PlacedSlice> slices, const SliceOperator& op,
                     const std::vector<float>& volume, double threshold, ThreadPool& pool) {
  std::vector<std::array<double, 6>> sums(slices.size());
  pool.run(static_cast<std::int64_t>(slices.size()), [&](std::int64_t k) {
    const PlacedSlice& slice = slices[k];
    if (!(slice.observed > 0 && slice.weight > 0)) return;
    const std::vector<float> seen = op.project(volume, slice);
    for (std::size_t p = 0; p < seen.size(); ++p) {
      const double a = slice.gain * seen[p], b = slice.values[p];
      if (!(std::min(a, b) >= threshold)) continue;
      const double products[] = {1, a, b, a * a, b * b, a * b};
      for (std::size_t n = 0; n < sums[k].size(); ++n)
        sums[k][n] += products[n];
    }
  });
  std::array<double, 6> all{};
  for (const auto& sum : sums)
    for (std::size_t n = 0; n < all.size(); ++n)
      all[n] += sum[n];
  const auto [n, a, b, aa, bb, ab] = all;
  const double va = aa - a * a / n, vb = bb - b * b / n;
  return va > 0 && vb > 0 ? (ab - a * b / n) / std::sqrt(va * vb) : kNaN;
}

/// "slices 3 and 7 of cor and 2 of sag (counted from 0)"; `places`: scans and slices.
std::string listOf(std::span<const std::pair<std::size_t, std::size_t>> places,
                   std::span<const std::string> names) {
  const std::size_t shown = std::min(places.size(), kMostListed);
  std::string text = places.size() == 1 ? "slice" : "slices";
  for (std::size_t n = 0; n < shown; ++n) {
    const auto [scan, slice] = places[n];
    const bool ends = n + 1 == shown || places[n + 1].first != scan;
    text += formatted(" %zu", slice);
    if (ends) text += " of " + (scan < names.size() ? names[scan] : formatted("scan %zu", scan + 1));
    if (n + 1 < shown) text += n + 2 == shown && shown == places.size() ? " and" : ",";
  }
  if (places.size() > shown) text += formatted(" and %zu more", places.size() - shown);
  return text + " (counted from 0)";
}

struct Work {
  std::span<const Stack> stacks;
  std::vector<std::vector<PlacedSlice>> slices; // of one level
  double peak = 1;

  std::vector<const PlacedSlice*> others(std::size_t stack) const {
    std::vector<const PlacedSlice*> found;
    for (std::size_t s = 0; s < slices.size(); ++s)
      for (const PlacedSlice& slice : slices[s])
        if (s != stack && slice.observed > 0 && slice.weight > 0) found.push_back(&slice);
    return found;
  }
};

/// The sum of a slice's squared values.
double energyOf(const PlacedSlice& slice) {
  double sum = 0;
  for (const float value : slice.values)
    if (!std::isnan(value)) sum += static_cast<double>(value) * value;
  return sum;
}

/// Removes the mean motion and gain from all, so that the frame stays that of the input.
void fixFrame(std::vector<std::vector<PlacedSlice>>& slices, const Vec3& centre) {
  Vec3 shift{}, turn{};
  double weights = 0, gain = 0, energies = 0;
  for (const auto& stack : slices)
    for (const PlacedSlice& s : stack) {
      const double w = s.weight * static_cast<double>(s.observed);
      shift = shift + w * (s.pose(centre) - centre);
      turn = turn + w * rotationVector(s.pose.linear);
      weights += w;
      const double energy = s.weight * energyOf(s); // nearly empty slices say nothing about gains
      gain += energy * std::log(s.gain);
      energies += energy;
    }
  if (weights == 0) return;
  const Affine3 back = inverse(rigidAbout(centre, (1 / weights) * turn, (1 / weights) * shift));
  for (auto& stack : slices)
    for (PlacedSlice& s : stack) {
      s.pose = back * s.pose;
      if (energies > 0) s.gain *= std::exp(-gain / energies);
    }
}

/// Weighs each slice by the ratio of its residual to its stack's median: 1 below a ratio of 1.5, 0 above 3.
void weighSlices(std::vector<PlacedSlice>& slices, const std::vector<double>& residual) {
  const double usual = medianOf(residual);
  for (std::size_t s = 0; s < slices.size(); ++s) {
    const double excess = residual[s] / usual;
    slices[s].weight = !std::isfinite(excess) || excess < 1.5 ? 1
                       : excess > 3                           ? 0
                                                              : std::pow(1.5 / excess, 4);
  }
}

double leastJointGain(std::span<const Stack> stacks, int packets, bool gaps) {
  const bool shared = packets > 0 && std::all_of(stacks.begin(), stacks.end(), [&](const Stack& stack) {
                        return stack.image.geometry.size[2] >= 2 * std::int64_t{packets};
                      });
  if (shared || !gaps) return kConsistentWithoutGaps;
  return stacks.size() == 2 ? kConsistentOfTwo : kConsistent;
}

/// How much better, in dB, one volume explains all slices at their poses than at rest.
double jointGain(const std::vector<std::vector<PlacedSlice>>& slices, const SliceOperator& op,
                 const SliceVolumePlan& plan, ThreadPool& pool) {
  std::vector<PlacedSlice> moved;
  for (const auto& stack : slices)
    for (const PlacedSlice& slice : stack)
      if (slice.observed > 0 && slice.weight > 0) moved.push_back(slice);
  const auto residual = [&](const std::vector<PlacedSlice>& all) {
    std::vector<const PlacedSlice*> views;
    for (const PlacedSlice& slice : all)
      views.push_back(&slice);
    std::vector<float> volume;
    fitVolume(volume, op, views, plan, pool);
    std::vector<Fit> fits(all.size());
    pool.run(static_cast<std::int64_t>(all.size()),
             [&](std::int64_t k) { fits[k] = fitOf(all[k], op, volume); });
    double squared = 0, pixels = 0;
    for (const Fit& fit : fits) {
      squared += fit.squared;
      pixels += static_cast<double>(fit.pixels);
    }
    return squared / pixels;
  };
  const double after = residual(moved);
  for (PlacedSlice& slice : moved) {
    slice.pose = {};
    slice.gain = 1;
  }
  return 10 * std::log10(residual(moved) / after);
}

} // namespace

bool hasThickSlices(const Stack& stack) {
  const Vec3& spacing = stack.image.geometry.spacing;
  return spacing[2] > 1.4 * std::min(spacing[0], spacing[1]);
}

SliceMotion findSliceMotion(std::span<const Stack> stacks, const SliceMotionPlan& plan, ThreadPool& pool,
                            const std::function<void(double)>& progress) {
  SliceMotion result;
  result.psnrBefore = result.psnrAfter = kNaN;
  for (const Stack& stack : stacks) {
    result.slices.emplace_back(static_cast<std::size_t>(stack.image.geometry.size[2]));
    if (plan.packets < stack.image.geometry.size[2]) result.packets = plan.packets;
  }
  if (stacks.size() < 2) return result;
  double distance = 0;
  bool gaps = false;
  for (const Stack& stack : stacks) {
    if (!stack.poses.empty()) return result;
    distance = std::max(distance, stack.image.geometry.spacing[2]);
    gaps = gaps || hasThickSlices(stack);
  }
  const std::vector<GridGeometry> boxes = observedBoxes(stacks);
  const double finest = finestSpacing(boxes);
  const Vec3 centre = gridAround(boxes, finest, kMargin).centre();
  const ValueRange range = observedRange(stacks);
  const bool scales = !belowZero(range);
  Work work{stacks, {}, static_cast<double>(range.high) - range.low};
  result.scans.resize(stacks.size());
  std::vector<double> threshold;
  for (const Stack& stack : stacks)
    threshold.push_back(bodyThreshold(BlurredStack(stack, 0, pool)));
  std::vector<std::vector<PlacedSlice>> previous;
  bool consistent = true;
  double all = 0, done = 0;
  for (const Level& level : kLevels)
    all += level.rounds / (level.factor * level.factor);
  double squaredBefore = 0, squaredAfter = 0;
  std::int64_t pixelsBefore = 0, pixelsAfter = 0;
  const auto psnr = [&](double squared, std::int64_t pixels) {
    return pixels > 0 ? -10 * std::log10(squared / static_cast<double>(pixels) / (work.peak * work.peak))
                      : kNaN;
  };
  for (const Level& level : kLevels) {
    const double spacing = level.factor * finest;
    const GridGeometry grid = gridAround(boxes, spacing, kMargin);
    const SliceOperator op(grid, pool);
    work.slices.clear();
    for (std::size_t s = 0; s < stacks.size(); ++s) {
      work.slices.push_back(
          placedSlices(stacks[s], s, pixelsAt(stacks[s], spacing), registeredProfile(stacks[s], spacing)));
      for (std::size_t k = 0; !previous.empty() && k < previous[s].size(); ++k) {
        work.slices[s][k].pose = previous[s][k].pose;
        work.slices[s][k].gain = previous[s][k].gain;
        work.slices[s][k].weight = previous[s][k].weight;
      }
    }
    const SliceVolumePlan volumePlan{level.smoothness, level.iterations};
    std::vector<std::vector<float>> volumes(stacks.size());
    const bool last = level.factor == 1;
    const bool judged = last || (level.factor == 2 && !plan.always);
    squaredBefore = squaredAfter = 0;
    pixelsBefore = pixelsAfter = 0;
    if (judged) { // how well still slices would predict each other
      auto still = work.slices;
      std::swap(still, work.slices);
      for (auto& stack : work.slices)
        for (PlacedSlice& s : stack) {
          s.pose = {};
          s.weight = s.gain = 1;
        }
      for (std::size_t s = 0; s < stacks.size(); ++s) {
        std::vector<float> volume;
        const auto others = work.others(s);
        fitVolume(volume, op, others, {level.smoothness, 2 * level.iterations}, pool);
        const std::vector<float> shown = shownPart(volume, op, others, distance, pool);
        for (const PlacedSlice& slice : work.slices[s]) {
          const Fit fit = fitOf(slice, op, shown);
          squaredBefore += fit.squared;
          pixelsBefore += fit.pixels;
        }
      }
      std::swap(still, work.slices);
    }
    for (int round = 0; round < level.rounds + (judged ? 1 : 0); ++round) {
      const bool judging = round == level.rounds;
      for (std::size_t s = 0; s < stacks.size(); ++s) {
        const auto others = work.others(s);
        if (volumes[s].empty()) fitVolume(volumes[s], op, others, volumePlan, pool);
        fitVolume(volumes[s], op, others, volumePlan, pool);
        const std::vector<float> shown = shownPart(volumes[s], op, others, distance, pool);
        std::vector<PlacedSlice>& mine = work.slices[s];
        std::vector<double> residual(mine.size(), kNaN);
        pool.run(static_cast<std::int64_t>(mine.size()),
                 [&](std::int64_t k) { residual[k] = fitOf(mine[k], op, shown).rms(); });
        if (judging) {
          Fit whole;
          for (std::size_t k = 0; k < mine.size(); ++k) {
            const Fit fit = fitOf(mine[k], op, shown);
            result.slices[s][k].residual = fit.rms();
            whole.squared += fit.squared;
            whole.pixels += fit.pixels;
          }
          squaredAfter += whole.squared;
          pixelsAfter += whole.pixels;
          result.scans[s] = {correlationOf(mine, op, shown, threshold[s], pool),
                             psnr(whole.squared, whole.pixels)};
          continue;
        }
        const double sigma = std::max(medianOf(residual), 1e-6 * work.peak);
        registerPackets(packetsOf(mine, plan.packets), op, shown, level.steps, sigma, scales, pool);
        pool.run(static_cast<std::int64_t>(mine.size()),
                 [&](std::int64_t k) { residual[k] = fitOf(mine[k], op, shown).rms(); });
        weighSlices(mine, residual);
      }
      if (judging) continue;
      fixFrame(work.slices, centre);
      done += 1 / (level.factor * level.factor);
      if (progress) progress(done / all);
    }
    previous = work.slices;
    // Without gaps, how well scans predict each other depends more on their noise than on where slices lie.
    if (!judged || (last && gaps)) continue;
    // Slices that do not move at twice the finest spacing are not worth the finest level, which is most of
    // the work.
    consistent = jointGain(work.slices, op, {level.smoothness, 2 * level.iterations}, pool) >=
                 leastJointGain(stacks, plan.packets, gaps);
    if (!consistent ||
        (gaps && psnr(squaredAfter, pixelsAfter) < psnr(squaredBefore, pixelsBefore) + 0.5 * kWorthwhile))
      break;
  }
  result.psnrBefore = psnr(squaredBefore, pixelsBefore);
  result.psnrAfter = psnr(squaredAfter, pixelsAfter);
  std::vector<double> displacements, angles;
  for (std::size_t s = 0; s < stacks.size(); ++s)
    for (std::size_t k = 0; k < work.slices[s].size(); ++k) {
      const PlacedSlice& slice = work.slices[s][k];
      SlicePose& pose = result.slices[s][k];
      pose.pose = slice.pose;
      pose.angle = angleOf(slice.pose.linear);
      pose.gain = 1 / slice.gain;
      pose.weight = slice.weight;
      double seen = 0, all = 0; // sums of squares
      std::int64_t n = 0, count = 0;
      for (int j = 0; j < slice.ny; j += 4)
        for (int i = 0; i < slice.nx; i += 4) {
          const Vec3 x = slice.toWorld({static_cast<double>(i), static_cast<double>(j), 0});
          const Vec3 d = slice.pose(x) - x;
          all += dot(d, d);
          ++count;
          if (std::isnan(slice.values[static_cast<std::size_t>(j) * slice.nx + i])) continue;
          seen += dot(d, d);
          ++n;
        }
      pose.displacement = std::sqrt(n > 0 ? seen / static_cast<double>(n) : all / static_cast<double>(count));
      if (n == 0) continue;
      displacements.push_back(pose.displacement);
      angles.push_back(pose.angle);
      result.rejected += pose.weight == 0;
    }
  result.displacement = medianOf(displacements);
  result.angle = medianOf(angles);
  result.moved =
      plan.always || (consistent && (!gaps || result.psnrAfter >= result.psnrBefore + kWorthwhile));
  if (!result.moved) {
    for (auto& stack : result.slices)
      for (SlicePose& pose : stack)
        pose = {{}, 0, 0, 1, 1, pose.residual};
    result.rejected = 0;
    result.scans.clear();
    result.psnrAfter = result.psnrBefore;
  }
  return result;
}

std::vector<SlicePose> placeSlices(const std::function<Volume(const GridGeometry&)>& render,
                                   const Stack& stack, std::span<const std::int64_t> indices, bool scales,
                                   ThreadPool& pool) {
  std::vector<SlicePose> result(indices.size());
  const std::span<const GridGeometry> only(&stack.image.geometry, 1);
  const double finest = finestSpacing(only);
  for (const Level& level : kLevels) {
    const GridGeometry grid = gridAround(only, level.factor * finest, kMargin);
    const SliceOperator op(grid, pool);
    const std::vector<float> volume = render(grid).voxels;
    std::vector<PlacedSlice> slices =
        placedSlices(stack, 0, pixelsAt(stack, grid.spacing[0]), registeredProfile(stack, grid.spacing[0]));
    pool.run(static_cast<std::int64_t>(indices.size()), [&](std::int64_t n) {
      PlacedSlice& slice = slices[indices[n]];
      slice.pose = result[n].pose;
      slice.gain = 1 / result[n].gain;
      const double sigma = fitOf(slice, op, volume).rms();
      if (!(sigma > 0)) return;
      registerPacket({&slice}, op, volume, 8, sigma, scales);
      result[n].pose = slice.pose;
      result[n].gain = 1 / slice.gain;
    });
  }
  return result;
}

std::int64_t sliceMotionMemory(std::span<const Stack> stacks) {
  std::int64_t pixels = 0;
  std::vector<GridGeometry> boxes;
  for (const Stack& stack : stacks) {
    pixels += stack.image.geometry.voxelCount();
    boxes.push_back(stack.image.geometry);
  }
  const std::int64_t volumes =
      static_cast<std::int64_t>(stacks.size()) + 4; // and what conjugate gradients hold
  return 4 * (volumes * gridAround(boxes, finestSpacing(boxes), kMargin).voxelCount() + 4 * pixels);
}

void applySliceMotion(const SliceMotion& motion, std::span<Stack> stacks) {
  if (!motion.moved) return;
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    Stack& stack = stacks[s];
    const auto& slices = motion.slices[s];
    const std::size_t plane = stack.image.voxels.size() / slices.size();
    stack.poses.clear();
    for (std::size_t k = 0; k < slices.size(); ++k) {
      stack.poses.push_back(slices[k].pose);
      float* values = stack.image.voxels.data() + k * plane;
      for (std::size_t p = 0; p < plane; ++p)
        values[p] *= static_cast<float>(slices[k].gain);
      if (slices[k].weight > 0) continue;
      if (stack.observed.empty()) stack.observed.assign(stack.image.voxels.size(), 1);
      std::fill_n(stack.observed.begin() + static_cast<std::ptrdiff_t>(k * plane), plane, std::uint8_t{0});
    }
  }
}

std::string sliceMotionSentence(const SliceMotion& m, std::span<const std::string> names) {
  if (!m.moved) return {};
  const std::string how =
      m.packets == 0   ? "The slices were moved one by one"
      : m.packets == 1 ? "The slices of each scan were moved together"
                       : formatted("The slices of each scan were moved in %d interleaved packets", m.packets);
  std::string text =
      how + formatted(", half of them by more than %.1f mm or %.1f°: the scans then predict each other's "
                      "slices to %.1f dB (before: %.1f dB).",
                      m.displacement, m.angle, m.psnrAfter, m.psnrBefore);
  std::vector<std::pair<std::size_t, std::size_t>> out, little, far;
  for (std::size_t s = 0; s < m.slices.size(); ++s)
    for (std::size_t k = 0; k < m.slices[s].size(); ++k) {
      const SlicePose& pose = m.slices[s][k];
      if (pose.weight == 0)
        out.emplace_back(s, k);
      else if (pose.weight < kLittle)
        little.emplace_back(s, k);
      else if (std::isfinite(pose.residual) && (pose.displacement > kFar * m.displacement + kFarAtLeast ||
                                                pose.angle > kFar * m.angle + kTurnedAtLeast))
        far.emplace_back(s, k);
    }
  if (!out.empty()) text += " Left out, as they fit no other: " + listOf(out, names) + ".";
  if (!little.empty())
    text += " Counted for less than half, as they fit badly: " + listOf(little, names) + ".";
  if (!far.empty()) text += " Moved or turned much farther than the others: " + listOf(far, names) + ".";
  return text;
}

} // namespace innergs
