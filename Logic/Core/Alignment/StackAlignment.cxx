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
// Scans of which parts moved differently are alike in part only; a pose that makes them so much more alike is
// right all the same.
constexpr double kSimilarTissue = 0.65, kClearly = 3; // correlation, dB
// At the coarsest resolution, below this correlation the search starts again from other poses.
constexpr double kConvincing = 0.9, kStartAngle = 25;    // degrees
constexpr double kMoreAlike = 0.05, kLeastOverlap = 0.7; // correlation, share of the places
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
double improve(StackAlignment& alignment, const std::vector<Pair>& pairs, const Vec3& centre, bool scales) {
  const std::vector<double> weights = weightsOf(pairs);
  std::vector<double> square(kParameters * kParameters), right(kParameters);
  for (std::size_t n = 0; n < pairs.size(); ++n) {
    const Pair& p = pairs[n];
    const Vec3 turn = cross(p.x - centre, p.gradient);
    const double r = p.own - p.other;
    double j[kParameters];
    for (int a = 0; a < 3; ++a) {
      j[a] = -p.gradient[a];
      j[3 + a] = -turn[a] / kArm;
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

/// The participating scans at one resolution.
struct Level {
  std::vector<BlurredStack> images;
  std::vector<Vec3> points;
  ValueRange values; // of the first scan
  double threshold;  // likewise, between air and body
  double step;       // mm, of differences
};

/// Aligns the participating scans to the first of them; the others' alignment is unknown.
class AlignmentToFirst {
public:
  AlignmentToFirst(std::span<const Stack> stacks, std::span<const std::size_t> part, ThreadPool& pool)
      : part_(part), pool_(pool), result_(stacks.size()), convincing_(part.size(), true) {
    for (StackAlignment& a : result_)
      a.correlation = a.psnrBefore = a.psnrAfter = kNaN;
    if (part.size() < 2) return;
    centre_ = stacks[part.front()].image.geometry.centre();
    const double sigma = commonResolution(stacks, part);
    for (const double level : {4.0, 2.0, 1.0}) {
      Level& l = levels_.emplace_back();
      for (const std::size_t s : part)
        l.images.emplace_back(stacks[s], level * sigma, pool);
      l.points = spreadPlaces(observedBox(l.images.front()), kPlaceDistance * level * sigma);
      l.values = valuesOf(l.images.front());
      l.threshold = bodyThreshold(l.images.front());
      l.step = 0.5 * level * sigma;
    }
  }

  /// Scans fit that the search makes alike.
  std::vector<StackAlignment> run() {
    if (part_.size() < 2) return result_;
    for (const Level& level : levels_)
      for (int round = 0; round < (part_.size() > 2 ? kRounds : 1); ++round)
        for (std::size_t n = 1; n < part_.size(); ++n)
          if (&level != &levels_.front() || (round > 0 && convincing_[n]))
            search(n, level);
          else if (round == 0)
            start(n);
    searched_ = result_;
    judgeAll(false);
    if (part_.size() > 2) judgeByThoseThatFit();
    return result_;
  }

  /// After run(): those fit, too, that it makes clearly more alike than they were.
  std::vector<StackAlignment> runLeniently() {
    if (part_.size() < 2) return result_;
    result_ = searched_;
    judgeAll(true);
    if (part_.size() > 2) judgeByThoseThatFit();
    return result_;
  }

private:
  StackAlignment& mine(std::size_t n) { return result_[part_[n]]; }

  void judgeAll(bool leniently) {
    for (std::size_t n = 1; n < part_.size(); ++n)
      judge(n, leniently);
  }

  /// Where some fit and others do not: the latter may have led all astray.
  void judgeByThoseThatFit() {
    const auto fit = [&](std::size_t s) { return result_[s].fits; };
    const auto others = part_.subspan(1);
    if (std::all_of(others.begin(), others.end(), fit) || std::none_of(others.begin(), others.end(), fit))
      return;
    for (std::size_t n = 1; n < part_.size(); ++n) {
      if (!mine(n).fits) continue;
      search(n, levels_.back());
      judge(n, true);
    }
    for (std::size_t n = 1; n < part_.size(); ++n) {
      if (mine(n).fits) continue;
      mine(n) = {};
      start(n);
      for (const Level& level : std::span(levels_).subspan(1))
        search(n, level);
      judge(n, true);
    }
  }

  /// What the others and this scan, as aligned, show. step: see pairsAt().
  std::vector<Pair> seen(std::size_t n, const StackAlignment& alignment, const Level& level,
                         double step = 0) const {
    std::vector<Placed> others;
    for (std::size_t m = 0; m < part_.size(); ++m)
      if (m != n && result_[part_[m]].fits) others.push_back(placed(level.images[m], result_[part_[m]]));
    return pairsAt(level.points, placed(level.images[n], alignment), others, level.threshold, step, pool_);
  }

  /// The middle of the body that a scan shows, in its own space.
  Vec3 middleOf(std::size_t n) const {
    const BlurredStack& image = levels_.front().images[n];
    const double threshold = bodyThreshold(image);
    const Affine3 map = image.geometry().indexToWorld();
    const auto& size = image.geometry().size;
    Vec3 sum{0, 0, 0};
    double count = 0;
    for (std::int64_t k = 0, v = 0; k < size[2]; ++k)
      for (std::int64_t j = 0; j < size[1]; ++j)
        for (std::int64_t i = 0; i < size[0]; ++i, ++v)
          if (image.values()[static_cast<std::size_t>(v)] >= threshold) {
            sum = sum + map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
            ++count;
          }
    return count > 0 ? (1 / count) * sum : centre_;
  }

  bool scales(std::size_t n, const Level& level) const {
    return !belowZero(valuesOf(level.images[n])) && !belowZero(level.values);
  }

  void search(std::size_t n, const Level& level) {
    for (int step = 0; step < kSteps; ++step) {
      const std::vector<Pair> pairs = seen(n, mine(n), level, level.step);
      if (static_cast<std::int64_t>(pairs.size()) < kFewestPoints) break;
      if (improve(mine(n), pairs, centre_, scales(n, level)) < kConverged) break;
    }
  }

  /// The search at the coarsest level. Where that leads to nothing convincing, it starts from other poses,
  /// too (scans of little overlap may drift apart there, so these are also tried without it), and goes on
  /// with the one that the next level finds best.
  void start(std::size_t n) {
    const Level &coarse = levels_[0], &finer = levels_[1];
    if (scales(n, coarse)) startGain(mine(n), seen(n, mine(n), coarse));
    const StackAlignment begun = mine(n);
    search(n, coarse);
    const PairedSums first = compare(seen(n, mine(n), coarse), coarse.threshold);
    convincing_[n] = !first.enough() || first.correlation() >= kConvincing;
    if (convincing_[n]) return;
    std::vector<Affine3> turns;
    for (int axis = 0; axis < 3; ++axis)
      for (const double angle : {-kStartAngle, kStartAngle}) {
        Vec3 turn{0, 0, 0};
        turn[axis] = angle * std::numbers::pi / 180;
        turns.push_back(rigidAbout(centre_, turn, {0, 0, 0}));
      }
    std::vector<Affine3> poses = turns;
    for (std::size_t m = 1; m < part_.size(); ++m) // which scans after a movement have in common
      if (m != n && mine(m).toOthers != Affine3{}) poses.push_back(mine(m).toOthers);
    std::vector<StackAlignment> ends{mine(n), begun};
    if (const Affine3 shift{{}, middleOf(0) - middleOf(n)}; norm(shift.offset) > coarse.step) {
      ends.push_back(begun);
      ends.back().toOthers = shift;
      poses.push_back(shift);
      for (const Affine3& turn : turns)
        poses.push_back(turn * shift);
    }
    for (const Affine3& pose : poses) {
      mine(n) = begun;
      mine(n).toOthers = pose;
      search(n, coarse);
      if (std::none_of(ends.begin(), ends.end(), [&](const StackAlignment& end) {
            const Affine3 between = inverse(end.toOthers) * mine(n).toOthers;
            return norm(between(centre_) - centre_) < coarse.step && angleOf(between.linear) < kSmallAngle;
          }))
        ends.push_back(mine(n));
    }
    StackAlignment best = ends.front();
    double correlation = -1, least = 0;
    for (const StackAlignment& end : ends) {
      mine(n) = end;
      search(n, finer);
      const PairedSums found = compare(seen(n, mine(n), finer), finer.threshold);
      if (found.n < least || !(found.correlation() > correlation + kMoreAlike)) continue;
      least = std::max(least, kLeastOverlap * found.n);
      correlation = found.correlation();
      best = mine(n);
    }
    mine(n) = best;
  }

  /// Decides whether the scan stays where the search has put it.
  void judge(std::size_t n, bool leniently) {
    const Level& level = levels_.back();
    StackAlignment& own = mine(n);
    const StackAlignment unknown = result_[part_.front()];
    const double peak = static_cast<double>(level.values.high) - level.values.low;
    const std::vector<Pair> before = seen(n, {}, level);
    if (static_cast<std::int64_t>(before.size()) < kFewestPoints) { // slabs that adjoin
      own = unknown;
      return;
    }
    std::vector<Pair> moved = seen(n, own, level);
    if (static_cast<std::int64_t>(moved.size()) < kFewestPoints) { // moved away from the others
      own = unknown;
      moved = before;
    }
    double squares = 0;
    const Affine3 back = inverse(own.toOthers);
    for (const Pair& p : moved) {
      const Vec3 d = p.x - back(p.x);
      squares += dot(d, d);
    }
    own.displacement = std::sqrt(squares / static_cast<double>(moved.size()));
    own.angle = angleOf(own.toOthers.linear);
    const auto stay = [&own] {
      own.toOthers = {};
      own.displacement = own.angle = 0;
    };
    if (own.displacement < kStill) stay();
    if (std::abs(own.gain - 1) < kSameGain) own.gain = 1;
    const PairedSums was = compare(before, level.threshold);
    PairedSums is = compare(seen(n, own, level), level.threshold);
    // Where the best pose makes scans alike they show the same body, also if it is not used.
    const bool wasAlike = was.correlation() >= kSameTissue;
    bool isAlike = is.correlation() >= kSameTissue;
    if (own.displacement > 0) { // what the pose gains, apart from the gain factor
      StackAlignment unmoved;
      unmoved.gain = own.gain;
      const PairedSums without = compare(seen(n, unmoved, level), level.threshold);
      const double gained = is.psnr(peak) - without.psnr(peak),
                   needed = leastPoseGain(own.angle, moved.size());
      isAlike = isAlike ||
                (leniently && is.correlation() >= kSimilarTissue && gained >= std::max(needed, kClearly));
      if (gained < needed) {
        stay();
        is = without;
      }
    }
    own.psnrBefore = was.psnr(peak);
    own.psnrAfter = is.psnr(peak);
    own.correlation = is.correlation();
    if (isAlike && (!wasAlike || own.psnrAfter >= own.psnrBefore + kWorthwhile)) return;
    stay();
    own.gain = 1;
    own.psnrAfter = own.psnrBefore;
    own.correlation = was.correlation();
    own.fits = wasAlike;
  }

  std::span<const std::size_t> part_;
  ThreadPool& pool_;
  std::vector<StackAlignment> result_, searched_;
  std::vector<Level> levels_;    // coarse to fine
  std::vector<bool> convincing_; // of each participating scan: what the coarsest level shows
  Vec3 centre_{};
};

} // namespace

std::vector<StackAlignment> alignStacks(std::span<const Stack> stacks, ThreadPool& pool) {
  std::vector<std::size_t> part;
  for (std::size_t s = 0; s < stacks.size(); ++s)
    if (stacks[s].poses.empty()) part.push_back(s);
  AlignmentToFirst toFirst(stacks, part, pool);
  std::vector<StackAlignment> result = toFirst.run();
  const auto anyFits = [](const std::vector<StackAlignment>& found, std::span<const std::size_t> scans) {
    return std::any_of(scans.begin(), scans.end(), [&](std::size_t s) { return found[s].fits; });
  };
  if (part.size() < 2 || anyFits(result, std::span(part).subspan(1))) return result;
  if (part.size() > 2) { // none fits the first scan: perhaps it is the one that fits none
    const std::span<const std::size_t> others = std::span(part).subspan(1);
    std::vector<StackAlignment> without = AlignmentToFirst(stacks, others, pool).run();
    if (anyFits(without, others.subspan(1))) {
      StackAlignment& stranger = without[part.front()];
      stranger = result[part.back()]; // was compared with it alone
      stranger.fits = false;
      return without;
    }
  }
  return toFirst.runLeniently();
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
