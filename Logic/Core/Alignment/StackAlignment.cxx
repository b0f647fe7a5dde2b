#include "Core/Alignment/StackAlignment.h"

#include "Core/Alignment/PairedSums.h"
#include "Core/Alignment/Rigid.h"
#include "Core/Alignment/SamplePlaces.h"
#include "Core/Alignment/StackAgreement.h"
#include "Core/Base/Cholesky.h"
#include "Core/Base/NumberText.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace innergs {
namespace {

constexpr int kParameters = 7; // translation, rotation, gain
constexpr std::int64_t kBlock = 4096;
constexpr int kSteps = 25;           // at each resolution
constexpr int kRounds = 3;           // over the scans, once there are more than two
constexpr double kConverged = 0.005; // mm
constexpr double kArm = 50;          // mm: scale of the angles in the equations
constexpr double kStill = 0.1;       // mm: scans without motion seem displaced by less
constexpr double kSameGain = 0.005;  // and to differ by less
constexpr double kAlikeScale = 2;    // ratio of means within which gains start at 1
constexpr double kWorthwhile = 0.5;  // dB: minimum gain
// A larger turn must gain more, up to a limit: where slices moved, round anatomy gains a little by chance
// when it is turned far, but a scan that really was turned that far gains much.
constexpr double kSmallAngle = 4, kPerDegree = 0.25, kMostNeeded = 4; // degrees, dB per degree, dB
constexpr int kPoseParameters = 6;
constexpr double kPlaceDistance = 0.7; // of the compared places, in σ of the common resolution
constexpr double kTukey = 4.685 * 1.4826;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

/// One scan at one resolution, as it lies now.
struct Placed {
  const BlurredStack* image;
  Affine3 place; // from the scan's own space to the first scan's
  Affine3 inverse;
  double gain;

  std::optional<double> at(const Vec3& x) const {
    const auto value = image->at(inverse(x));
    if (!value) return {};
    return gain * *value;
  }
};

Placed placed(const BlurredStack& image, const StackAlignment& a) {
  return {&image, a.toOthers, inverse(a.toOthers), a.gain};
}

/// The mean of the scans that cover the point.
std::optional<double> meanAt(std::span<const Placed> scans, const Vec3& x) {
  double sum = 0;
  int count = 0;
  for (const Placed& scan : scans)
    if (const auto value = scan.at(x)) {
      sum += *value;
      ++count;
    }
  if (count == 0) return {};
  return sum / count;
}

/// What both scans show at a point in the body.
struct Pair {
  Vec3 x;
  double other, own;
  Vec3 gradient; // of own, per mm
};

/// Pairs at the points in the body, in order. step: mm of the central differences; 0: no gradient.
std::vector<Pair> pairsAt(std::span<const Vec3> points, const Placed& scan, std::span<const Placed> others,
                          double threshold, double step, ThreadPool& pool) {
  const auto blocks = (static_cast<std::int64_t>(points.size()) + kBlock - 1) / kBlock;
  std::vector<std::vector<Pair>> parts(static_cast<std::size_t>(blocks));
  pool.run(blocks, [&](std::int64_t b) {
    const auto end = std::min<std::int64_t>(static_cast<std::int64_t>(points.size()), (b + 1) * kBlock);
    for (std::int64_t n = b * kBlock; n < end; ++n) {
      const Vec3& x = points[n];
      const auto other = meanAt(others, x), own = other ? scan.at(x) : std::nullopt;
      if (!own || std::max(*other, *own) < threshold) continue;
      Pair pair{x, *other, *own, {}};
      bool whole = true;
      for (int a = 0; step > 0 && whole && a < 3; ++a) {
        Vec3 low = x, high = x;
        low[a] -= step;
        high[a] += step;
        const auto below = scan.at(low), above = scan.at(high);
        whole = below && above;
        if (whole) pair.gradient[a] = (*above - *below) / (2 * step);
      }
      if (whole) parts[b].push_back(pair);
    }
  });
  std::vector<Pair> all;
  for (const auto& part : parts)
    all.insert(all.end(), part.begin(), part.end());
  return all;
}

/// Scans on scales far apart start with the ratio of their means.
void startGain(StackAlignment& alignment, std::span<const Pair> pairs) {
  double own = 0, other = 0;
  for (const Pair& p : pairs) {
    own += p.own;
    other += p.other;
  }
  if (!(own > 0) || !(other > 0)) return;
  const double ratio = other / own;
  if (ratio < 1 / kAlikeScale || ratio > kAlikeScale) alignment.gain *= ratio;
}

/// Compares where both show the body: its edges would agree in any contrast.
PairedSums compare(std::span<const Pair> pairs, double threshold) {
  PairedSums sums;
  for (const Pair& p : pairs)
    if (std::min(p.own, p.other) >= threshold) sums.add(p.other, p.own);
  return sums;
}

/// Weights of the differences by Tukey's biweight.
std::vector<double> weightsOf(const std::vector<Pair>& pairs) {
  std::vector<double> size;
  for (const Pair& p : pairs)
    size.push_back(std::abs(p.own - p.other));
  const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
  std::vector<double> sorted = size;
  std::nth_element(sorted.begin(), sorted.begin() + (middle - size.begin()), sorted.end());
  const double width = kTukey * sorted[static_cast<std::size_t>(middle - size.begin())];
  for (double& s : size) {
    const double t = width > 0 ? s / width : 0;
    s = t < 1 ? (1 - t * t) * (1 - t * t) : 0;
  }
  return size;
}

/// Takes one Gauss-Newton step; returns how far it moved the scan, mm.
double improve(StackAlignment& alignment, const std::vector<Pair>& pairs, const Vec3& centre, bool moves,
               bool scales) {
  const std::vector<double> weights = weightsOf(pairs);
  std::vector<double> square(kParameters * kParameters), right(kParameters);
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const Pair& p = pairs[n];
    const Vec3 turn = cross(p.x - centre, p.gradient);
    const double r = p.own - p.other;
    double j[kParameters];
    for (int a = 0; a < 3; ++a) {
      j[a] = moves ? -p.gradient[a] : 0;
      j[3 + a] = moves ? -turn[a] / kArm : 0;
    }
    j[6] = scales ? p.own : 0;
    for (int a = 0; a < kParameters; ++a) {
      for (int b = 0; b < kParameters; ++b)
        square[a * kParameters + b] += weights[n] * j[a] * j[b];
      right[a] -= weights[n] * j[a] * r;
    }
  }
  for (int a = 0; a < kParameters; ++a) { // fixed parameters stay
    double& d = square[a * kParameters + a];
    d = d > 0 ? d * (1 + 1e-9) : 1;
  }
  solveCholesky(square, right, kParameters, 1);
  const Vec3 shift{right[0], right[1], right[2]}, turn{right[3] / kArm, right[4] / kArm, right[5] / kArm};
  alignment.toOthers = rigidAbout(centre, turn, shift) * alignment.toOthers;
  alignment.gain *= 1 + std::clamp(right[6], -0.3, 0.3);
  return norm(shift) + kArm * norm(turn) + kArm * std::abs(right[6]);
}

/// The minimum gain of a pose that turns by `angle` and was found at this many places, dB: at least twice
/// what fitting a pose gains by chance, where residuals within a correlation volume of (2√π σ)³ count as one.
double leastPoseGain(double angle, std::size_t places) {
  const double spacing = kPlaceDistance / (2 * std::sqrt(std::numbers::pi)),
               independent = static_cast<double>(places) * spacing * spacing * spacing;
  if (independent <= kPoseParameters) return std::numeric_limits<double>::infinity();
  const double chance = -10 * std::log10(1 - kPoseParameters / independent);
  const double turn =
      angle > kSmallAngle ? std::min(kWorthwhile + kPerDegree * (angle - kSmallAngle), kMostNeeded) : 0;
  return std::max(2 * chance, turn);
}

/// Aligns the participating scans to the first of them; the others' alignment is unknown.
std::vector<StackAlignment> alignToFirst(std::span<const Stack> stacks, std::span<const std::size_t> part,
                                         ThreadPool& pool) {
  std::vector<StackAlignment> result(stacks.size());
  for (StackAlignment& a : result)
    a.correlation = a.psnrBefore = a.psnrAfter = kNaN;
  if (part.size() < 2) return result;
  const std::size_t first = part.front();
  const double sigma = commonResolution(stacks, part);
  const Vec3 centre = stacks[first].image.geometry.centre();
  for (const double level : {4.0, 2.0, 1.0}) {
    std::vector<BlurredStack> images;
    for (const std::size_t s : part)
      images.emplace_back(stacks[s], level * sigma, pool);
    const std::vector<Vec3> points =
        spreadPlaces(observedBox(images.front()), kPlaceDistance * level * sigma);
    const ValueRange values = valuesOf(images.front());
    const double threshold = bodyThreshold(images.front());
    const auto against = [&](std::size_t n) {
      std::vector<Placed> others;
      for (std::size_t m = 0; m < part.size(); ++m)
        if (m != n && result[part[m]].fits) others.push_back(placed(images[m], result[part[m]]));
      return others;
    };
    const auto seen = [&](std::size_t n, const StackAlignment& alignment, double step) {
      return pairsAt(points, placed(images[n], alignment), against(n), threshold, step, pool);
    };
    for (int round = 0; round < (part.size() > 2 ? kRounds : 1); ++round)
      for (std::size_t n = 1; n < part.size(); ++n) {
        StackAlignment& mine = result[part[n]];
        const bool scales = !belowZero(valuesOf(images[n])) && !belowZero(values);
        if (scales && level == 4 && round == 0) startGain(mine, seen(n, mine, 0));
        for (int step = 0; step < kSteps; ++step) {
          const std::vector<Pair> pairs = seen(n, mine, 0.5 * level * sigma);
          if (static_cast<std::int64_t>(pairs.size()) < kFewestPoints) break;
          if (improve(mine, pairs, centre, true, scales) < kConverged) break;
        }
      }
    if (level > 1) continue;
    const double peak = static_cast<double>(values.high) - values.low;
    for (std::size_t n = 1; n < part.size(); ++n) {
      StackAlignment& mine = result[part[n]];
      const StackAlignment still;
      const std::vector<Pair> before = seen(n, still, 0);
      if (static_cast<std::int64_t>(before.size()) < kFewestPoints) { // slabs that adjoin
        mine = result[first];
        continue;
      }
      std::vector<Pair> moved = seen(n, mine, 0);
      if (static_cast<std::int64_t>(moved.size()) < kFewestPoints) { // moved away from the others
        mine = result[first];
        moved = before;
      }
      double squares = 0;
      const Affine3 back = inverse(mine.toOthers);
      for (const Pair& p : moved) {
        const Vec3 d = p.x - back(p.x);
        squares += dot(d, d);
      }
      mine.displacement = std::sqrt(squares / static_cast<double>(moved.size()));
      mine.angle = angleOf(mine.toOthers.linear);
      if (mine.displacement < kStill) {
        mine.toOthers = {};
        mine.displacement = mine.angle = 0;
      }
      if (std::abs(mine.gain - 1) < kSameGain) mine.gain = 1;
      const PairedSums was = compare(before, threshold);
      PairedSums is = compare(seen(n, mine, 0), threshold);
      // Where the best pose makes scans alike they show the same body, also if it is not used.
      const bool wasAlike = was.correlation() >= kSameTissue, isAlike = is.correlation() >= kSameTissue;
      if (mine.displacement > 0) { // what the pose gains, apart from the gain factor
        StackAlignment unmoved;
        unmoved.gain = mine.gain;
        const PairedSums without = compare(seen(n, unmoved, 0), threshold);
        if (is.psnr(peak) - without.psnr(peak) < leastPoseGain(mine.angle, moved.size())) {
          mine.toOthers = {};
          mine.displacement = mine.angle = 0;
          is = without;
        }
      }
      mine.psnrBefore = was.psnr(peak);
      mine.psnrAfter = is.psnr(peak);
      mine.correlation = is.correlation();
      if (isAlike && (!wasAlike || mine.psnrAfter >= mine.psnrBefore + kWorthwhile)) continue;
      mine.toOthers = {};
      mine.displacement = mine.angle = 0;
      mine.gain = 1;
      mine.psnrAfter = mine.psnrBefore;
      mine.correlation = was.correlation();
      mine.fits = wasAlike;
    }
  }
  return result;
}

} // namespace

std::vector<StackAlignment> alignStacks(std::span<const Stack> stacks, ThreadPool& pool) {
  std::vector<std::size_t> part;
  for (std::size_t s = 0; s < stacks.size(); ++s)
    if (stacks[s].poses.empty()) part.push_back(s);
  std::vector<StackAlignment> result = alignToFirst(stacks, part, pool);
  const auto anyFits = [](const std::vector<StackAlignment>& found, std::span<const std::size_t> scans) {
    return std::any_of(scans.begin(), scans.end(), [&](std::size_t s) { return found[s].fits; });
  };
  if (part.size() < 3 || anyFits(result, std::span(part).subspan(1))) return result;
  // None fits the first scan: perhaps it is the one that fits none.
  const std::span<const std::size_t> others = std::span(part).subspan(1);
  std::vector<StackAlignment> without = alignToFirst(stacks, others, pool);
  if (!anyFits(without, others.subspan(1))) return result;
  StackAlignment& stranger = without[part.front()];
  stranger = result[part.back()]; // was compared with it alone
  stranger.fits = false;
  return without;
}

void applyAlignment(std::span<const StackAlignment> alignment, std::span<Stack> stacks) {
  for (std::size_t s = 0; s < stacks.size(); ++s) {
    const StackAlignment& a = alignment[s];
    GridGeometry& g = stacks[s].image.geometry;
    if (a.displacement > 0) {
      g.origin = a.toOthers(g.origin);
      g.direction = a.toOthers.linear * g.direction;
    }
    if (a.gain != 1)
      for (float& v : stacks[s].image.voxels)
        v *= static_cast<float>(a.gain);
  }
}

std::string alignmentSentence(const StackAlignment& a, const std::string& name) {
  if (!a.fits) return misfitSentence(agreementsOf({&a, 1}).front(), name);
  std::string done;
  if (a.displacement > 0) done = formatted("moved by %.1f mm and turned by %.1f°", a.displacement, a.angle);
  if (a.gain != 1)
    done += (done.empty() ? "" : ", and ") +
            formatted(a.gain < 0.01 || a.gain > 100 ? "multiplied by %.3g" : "multiplied by %.3f", a.gain);
  if (done.empty()) return {};
  const std::string before =
      std::isnan(a.psnrBefore) ? "before too little in common" : formatted("before %.1f dB", a.psnrBefore);
  return name + " was " + done +
         formatted(" to fit the other scans (PSNR between them %.1f dB, %s).", a.psnrAfter, before.c_str());
}

} // namespace innergs
