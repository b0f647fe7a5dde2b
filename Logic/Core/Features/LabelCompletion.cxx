#include "Core/Features/LabelCompletion.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

// Chosen on an abdominal CT, see Docs/method.md.
constexpr double kReach = 0.5;      // σ in plane, slice distances per slice to the labelled one, in voxels
constexpr int kLargestWindow = 10;  // voxels, half
constexpr float kRankSigma = 0.07f; // of a patch's difference
constexpr float kStepSigma = 0.05f; // of a step's difference, random walker
constexpr float kLeastStep = 0.01f; // of any step
constexpr float kPrior = 0.3f;      // weight of the regression in the random walker
constexpr int kCompletionIterations = 30;
constexpr int kPriors = 6; // classes kept by a voxel's regression

struct Prior {
  std::array<std::uint16_t, kPriors> classes{};
  std::array<float, kPriors> shares{};

  float of(std::uint16_t c) const {
    for (int n = 0; n < kPriors && shares[n] > 0; ++n)
      if (classes[n] == c) return shares[n];
    return 0;
  }
};

/// exp(−x) for x ≥ 0 from a table.
class DecayTable {
public:
  DecayTable() {
    for (int n = 0; n < kSize; ++n)
      values_[n] = static_cast<float>(std::exp(-n / kSteps));
  }
  float operator()(float x) const {
    const float at = x * static_cast<float>(kSteps);
    return at < kSize - 1 ? values_[static_cast<int>(at)] : 0.f;
  }

private:
  static constexpr int kSize = 4096;
  static constexpr double kSteps = 256; // per unit
  float values_[kSize];
};

class Completion {
public:
  Completion(const Labelmap& labels, int classes, std::span<const float> ranks, ThreadPool& pool)
      : labels_(labels), classes_(classes), ranks_(ranks), pool_(pool), nx_(labels.geometry.size[0]),
        ny_(labels.geometry.size[1]), nz_(labels.geometry.size[2]) {}

  std::vector<SoftLabel> run(const std::function<void(double)>& progress) {
    const auto report = [&](double fraction) {
      pool_.throwIfStopped();
      if (progress) progress(fraction);
    };
    report(0);
    findLabelledSlices();
    priors_.resize(ranks_.size());
    pool_.run(nz_ * ny_, [&](std::int64_t row) { regressRow(row / ny_, row % ny_); });
    report(0.5);
    makeSteps();
    soft_.resize(ranks_.size());
    for (int c = 1; c < classes_; ++c) {
      walk(static_cast<std::uint16_t>(c));
      report(0.5 + 0.5 * c / classes_);
    }
    pool_.blocks(static_cast<std::int64_t>(soft_.size()), 65536, [&](std::int64_t first, std::int64_t last) {
      for (std::int64_t n = first; n < last; ++n)
        addBackground(soft_[n]);
    });
    return std::move(soft_);
  }

private:
  std::int64_t at(std::int64_t i, std::int64_t j, std::int64_t k) const { return i + nx_ * (j + ny_ * k); }

  void findLabelledSlices() {
    below_.assign(nz_, -1);
    above_.assign(nz_, -1);
    for (std::int64_t k = 0, last = -1; k < nz_; ++k)
      below_[k] = last = labels_.isLabelled(k) ? k : last;
    for (std::int64_t k = nz_ - 1, last = -1; k >= 0; --k)
      above_[k] = last = labels_.isLabelled(k) ? k : last;
    // How far each voxel's own label extends in all directions in a labelled slice.
    uniform_.assign(ranks_.size(), 0);
    pool_.run(nz_, [&](std::int64_t k) {
      if (labels_.isLabelled(k)) measureUniform(k);
    });
  }

  /// Chessboard distance to the next other label, at most 255, by two passes.
  void measureUniform(std::int64_t k) {
    const auto relax = [&](std::int64_t i, std::int64_t j, int step) {
      int least = 255;
      const std::int64_t own = at(i, j, k);
      for (const auto& [di, dj] : {std::pair{-step, 0}, {-step, -step}, {0, -step}, {step, -step}}) {
        const std::int64_t x = i + di, y = j + dj;
        if (x < 0 || y < 0 || x >= nx_ || y >= ny_) continue;
        const std::int64_t other = at(x, y, k);
        least = std::min(least, labels_.voxels[other] == labels_.voxels[own] ? uniform_[other] + 1 : 1);
      }
      uniform_[own] = static_cast<std::uint8_t>(step > 0 ? least : std::min<int>(least, uniform_[own]));
    };
    for (std::int64_t j = 0; j < ny_; ++j)
      for (std::int64_t i = 0; i < nx_; ++i)
        relax(i, j, 1);
    for (std::int64_t j = ny_ - 1; j >= 0; --j)
      for (std::int64_t i = nx_ - 1; i >= 0; --i)
        relax(i, j, -1);
  }

  /// Mean squared difference of 3×3 patches, with the centre counting four times.
  float patchDifference(std::int64_t i, std::int64_t j, std::int64_t k, std::int64_t x, std::int64_t y,
                        std::int64_t z) const {
    float sum = 0, count = 0;
    for (int b = -1; b <= 1; ++b)
      for (int a = -1; a <= 1; ++a) {
        if (i + a < 0 || x + a < 0 || i + a >= nx_ || x + a >= nx_ || j + b < 0 || y + b < 0 ||
            j + b >= ny_ || y + b >= ny_)
          continue;
        const float difference = ranks_[at(i + a, j + b, k)] - ranks_[at(x + a, y + b, z)];
        const float weight = a == 0 && b == 0 ? 4.f : 1.f;
        sum += weight * difference * difference;
        count += weight;
      }
    return sum / count;
  }

  void regressRow(std::int64_t k, std::int64_t j) {
    std::vector<float> score(static_cast<std::size_t>(classes_), 0.f);
    std::vector<std::uint16_t> seen;
    for (std::int64_t i = 0; i < nx_; ++i) {
      const std::int64_t own = at(i, j, k);
      if (labels_.isLabelled(k)) {
        priors_[own].classes[0] = labels_.voxels[own];
        priors_[own].shares[0] = 1;
        continue;
      }
      seen.clear();
      if (!copyUniform(i, j, k)) {
        for (const std::int64_t z : {below_[k], above_[k]})
          if (z >= 0) regressFrom(i, j, k, z, score, seen);
        keepBest(score, seen, priors_[own]);
        for (const std::uint16_t c : seen)
          score[c] = 0;
      }
    }
  }

  int windowOf(double sigma) const { return std::min(kLargestWindow, static_cast<int>(2.5 * sigma + 1)); }

  /// If both slices hold the same single label in the whole window, no regression is needed.
  bool copyUniform(std::int64_t i, std::int64_t j, std::int64_t k) {
    std::int64_t source = -1;
    for (const std::int64_t z : {below_[k], above_[k]}) {
      if (z < 0) continue;
      const std::int64_t voxel = at(i, j, z);
      if (uniform_[voxel] <= windowOf(kReach * static_cast<double>(std::abs(z - k)))) return false;
      if (source >= 0 && labels_.voxels[source] != labels_.voxels[voxel]) return false;
      source = voxel;
    }
    if (source < 0) return false;
    Prior& prior = priors_[at(i, j, k)];
    prior.classes[0] = labels_.voxels[source];
    prior.shares[0] = 1;
    return true;
  }

  void regressFrom(std::int64_t i, std::int64_t j, std::int64_t k, std::int64_t z, std::vector<float>& score,
                   std::vector<std::uint16_t>& seen) const {
    const auto distance = static_cast<double>(std::abs(z - k));
    const double sigma = kReach * distance;
    const auto slice = static_cast<float>(1 / (distance * distance * distance));
    const auto inPlane = static_cast<float>(0.5 / (sigma * sigma));
    constexpr float inRank = 0.5f / (kRankSigma * kRankSigma);
    const int r = windowOf(sigma);
    for (std::int64_t y = std::max<std::int64_t>(0, j - r); y <= std::min(ny_ - 1, j + r); ++y)
      for (std::int64_t x = std::max<std::int64_t>(0, i - r); x <= std::min(nx_ - 1, i + r); ++x) {
        const auto d = static_cast<float>((x - i) * (x - i) + (y - j) * (y - j));
        const float weight = slice * decay_(inPlane * d + inRank * patchDifference(i, j, k, x, y, z));
        if (!(weight > 0)) continue;
        const std::uint16_t c = labels_.voxels[at(x, y, z)];
        if (score[c] == 0) seen.push_back(c);
        score[c] += weight;
      }
    // Nothing similar: takes the label straight across.
    const std::uint16_t across = labels_.voxels[at(i, j, z)];
    if (score[across] == 0) seen.push_back(across);
    score[across] += 1e-7f * slice;
  }

  static void keepBest(const std::vector<float>& score, std::vector<std::uint16_t>& seen, Prior& prior) {
    std::sort(seen.begin(), seen.end(), [&](std::uint16_t a, std::uint16_t b) {
      return score[a] != score[b] ? score[a] > score[b] : a < b;
    });
    float sum = 0;
    for (const std::uint16_t c : seen)
      sum += score[c];
    for (std::size_t n = 0; n < std::min<std::size_t>(kPriors, seen.size()); ++n) {
      prior.classes[n] = seen[n];
      prior.shares[n] = score[seen[n]] / sum;
    }
  }

  /// Weights of the steps to the next voxel along i, j and k.
  void makeSteps() {
    for (auto& steps : steps_)
      steps.assign(ranks_.size(), 0.f);
    pool_.run(nz_, [&](std::int64_t k) {
      for (std::int64_t j = 0; j < ny_; ++j)
        for (std::int64_t i = 0; i < nx_; ++i) {
          const std::int64_t own = at(i, j, k);
          const auto step = [&](std::int64_t other) {
            const float d = ranks_[own] - ranks_[other];
            return decay_(0.5f / (kStepSigma * kStepSigma) * d * d) + kLeastStep;
          };
          if (i + 1 < nx_) steps_[0][own] = step(own + 1);
          if (j + 1 < ny_) steps_[1][own] = step(own + nx_);
          if (k + 1 < nz_) steps_[2][own] = step(own + nx_ * ny_);
        }
    });
  }

  struct Box {
    std::int64_t low[3], high[3]; // first voxel, end
    bool empty() const { return low[0] >= high[0]; }
  };

  Box boxOf(std::uint16_t c) const {
    std::vector<Box> boxes(static_cast<std::size_t>(nz_));
    pool_.run(nz_, [&](std::int64_t k) {
      Box box{{nx_, ny_, nz_}, {0, 0, 0}};
      for (std::int64_t j = 0; j < ny_; ++j)
        for (std::int64_t i = 0; i < nx_; ++i)
          if (priors_[at(i, j, k)].of(c) > 1e-3f) {
            const std::int64_t index[3] = {i, j, k};
            for (int a = 0; a < 3; ++a) {
              box.low[a] = std::min(box.low[a], index[a]);
              box.high[a] = std::max(box.high[a], index[a] + 1);
            }
          }
      boxes[k] = box;
    });
    Box all{{nx_, ny_, nz_}, {0, 0, 0}};
    const std::int64_t size[3] = {nx_, ny_, nz_};
    for (const Box& box : boxes)
      for (int a = 0; a < 3; ++a) {
        all.low[a] = std::min(all.low[a], box.low[a]);
        all.high[a] = std::max(all.high[a], box.high[a]);
      }
    if (all.empty()) return all;
    constexpr std::int64_t margin = 3;
    for (int a = 0; a < 3; ++a) {
      all.low[a] = std::max<std::int64_t>(0, all.low[a] - margin);
      all.high[a] = std::min(size[a], all.high[a] + margin);
    }
    return all;
  }

  /// The random walker's probability of one class: red-black Gauss–Seidel inside the class's box, 0 outside
  /// it. The voxels of one colour depend only on the other's, so the order of threads does not matter.
  void walk(std::uint16_t c) {
    const Box box = boxOf(c);
    if (box.empty()) return;
    const std::int64_t bx = box.high[0] - box.low[0], by = box.high[1] - box.low[1],
                       bz = box.high[2] - box.low[2];
    share_.assign(static_cast<std::size_t>(bx * by * bz), 0.f);
    prior_.assign(share_.size(), 0.f);
    pool_.run(bz, [&](std::int64_t z) {
      for (std::int64_t y = 0; y < by; ++y)
        for (std::int64_t x = 0; x < bx; ++x) {
          const std::int64_t n = x + bx * (y + by * z);
          prior_[n] = share_[n] = priors_[at(box.low[0] + x, box.low[1] + y, box.low[2] + z)].of(c);
        }
    });
    for (int half = 0; half < 2 * kCompletionIterations; ++half)
      pool_.run(bz, [&](std::int64_t z) {
        const std::int64_t k = box.low[2] + z;
        if (labels_.isLabelled(k)) return;
        for (std::int64_t y = 0; y < by; ++y)
          for (std::int64_t x = (y + z + half) % 2; x < bx; x += 2) {
            const std::int64_t n = x + bx * (y + by * z), own = at(box.low[0] + x, box.low[1] + y, k);
            float sum = kPrior * prior_[n], total = kPrior;
            const auto add = [&](float step, bool inside, std::int64_t other) {
              total += step;
              if (inside) sum += step * share_[other];
            };
            if (box.low[0] + x > 0) add(steps_[0][own - 1], x > 0, n - 1);
            if (box.low[1] + y > 0) add(steps_[1][own - nx_], y > 0, n - bx);
            if (k > 0) add(steps_[2][own - nx_ * ny_], z > 0, n - bx * by);
            add(steps_[0][own], x + 1 < bx, n + 1);
            add(steps_[1][own], y + 1 < by, n + bx);
            add(steps_[2][own], z + 1 < bz, n + bx * by);
            share_[n] = sum / total;
          }
      });
    pool_.run(bz, [&](std::int64_t z) {
      for (std::int64_t y = 0; y < by; ++y)
        for (std::int64_t x = 0; x < bx; ++x)
          insert(soft_[at(box.low[0] + x, box.low[1] + y, box.low[2] + z)], c, share_[x + bx * (y + by * z)]);
    });
  }

  static void insert(SoftLabel& soft, std::uint16_t c, float share) {
    if (!(share > 1e-3f)) return;
    for (int n = 0; n < SoftLabel::kClasses; ++n)
      if (share > soft.shares[n]) {
        std::swap(share, soft.shares[n]);
        std::swap(c, soft.classes[n]);
      }
  }

  static void addBackground(SoftLabel& soft) {
    float rest = 1;
    for (const float share : soft.shares)
      rest -= share;
    insert(soft, 0, rest);
  }

  const Labelmap& labels_;
  int classes_;
  std::span<const float> ranks_;
  ThreadPool& pool_;
  std::int64_t nx_, ny_, nz_;
  DecayTable decay_;
  std::vector<std::int64_t> below_, above_; // per slice the next labelled one, −1: none
  std::vector<std::uint8_t> uniform_;
  std::vector<Prior> priors_;
  std::vector<float> steps_[3], share_, prior_;
  std::vector<SoftLabel> soft_;
};

} // namespace

std::vector<SoftLabel> completeLabels(const Labelmap& labels, int classes, std::span<const float> ranks,
                                      ThreadPool& pool, const std::function<void(double)>& progress) {
  if (std::all_of(labels.labelled.begin(), labels.labelled.end(), [](auto l) { return l != 0; })) {
    std::vector<SoftLabel> soft(labels.voxels.size());
    for (std::size_t n = 0; n < soft.size(); ++n) {
      soft[n].classes[0] = labels.voxels[n];
      soft[n].shares[0] = 1;
    }
    return soft;
  }
  return Completion(labels, classes, ranks, pool).run(progress);
}

} // namespace innergs
