#include "Core/Alignment/BiasCorrection.h"

#include "Core/Alignment/HistogramSharpening.h"
#include "Core/Alignment/PairedSums.h"
#include "Core/Alignment/SamplePlaces.h"
#include "Core/Base/Cholesky.h"
#include "Core/Base/Median.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/Bounds.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>

namespace innergs {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr int kDegree = 4, kSharedDegree = 2;
constexpr int kTerms = legendreCount(kDegree), kShared = legendreCount(kSharedDegree);
constexpr std::int64_t kBlock = 1024;     // points
constexpr std::int64_t kSamples = 60'000; // of the shared shading, from all scans
constexpr int kShadingIterations = 15;
constexpr int kRounds = 6;         // of alignment and shading, once there is a shading
constexpr double kConverged = 0.1; // dB
constexpr double kRidge = 1e-4;
constexpr double kTukey = 4.685 * 1.4826; // in median deviations
constexpr double kWorthwhile = 0.5;       // dB
constexpr double kClear = 6;              // dB: motion of slices looks like less
constexpr double kAir = 0.1;              // share below which Otsu's threshold lies between tissues
constexpr double kExcess = 1.5;           // of the shared shading relative to the scans' individual shading
// Of the values, what is left of a shared shading that was found: in brains, whose tissue is not flat either
// (Docs/benchmarks.md).
constexpr double kLeftShared = 0.025;
constexpr double kLeast = 0.01; // range of a scan's own shading that is reported

/// The values of the corrected scans at common places.
struct Common {
  BiasField frame; // without coefficients
  std::vector<std::size_t> scans;
  std::size_t points = 0;
  std::vector<double> terms;  // [points][kTerms]
  std::vector<double> logs;   // [points][scans]; NaN: air, or not seen
  std::vector<double> inside; // [scans]: logarithm that only the body's inside exceeds
  double peak = 1;

  double log(std::size_t p, std::size_t s) const { return logs[p * scans.size() + s]; }
};

Common look(std::span<const Stack> stacks, std::span<const std::size_t> part, ThreadPool& pool) {
  Common c;
  c.scans.assign(part.begin(), part.end());
  const double sigma = commonResolution(stacks, part);
  std::vector<BlurredStack> images;
  std::vector<double> threshold;
  for (const std::size_t s : part) {
    images.emplace_back(stacks[s], sigma, pool);
    threshold.push_back(std::max(bodyThreshold(images.back()), 1e-30));
    c.inside.push_back(std::log(2 * threshold.back()));
  }
  const ValueRange values = valuesOf(images.front());
  c.peak = static_cast<double>(values.high) - values.low;
  std::vector<GridGeometry> grids;
  for (const Stack& stack : stacks)
    grids.push_back(stack.image.geometry);
  const GridGeometry box = gridAround(grids, 0.7 * sigma, 0);
  const std::vector<Vec3> places = spreadPlaces(box, 0.7 * sigma);
  const std::size_t n = part.size();
  std::vector<double> logs(places.size() * n, kNaN);
  std::atomic<std::int64_t> seen = 0, body = 0;
  pool.blocks(static_cast<std::int64_t>(places.size()), kBlock, [&](std::int64_t from, std::int64_t to) {
    std::int64_t all = 0, within = 0;
    for (std::int64_t p = from; p < to; ++p)
      for (std::size_t s = 0; s < n; ++s)
        if (const auto value = images[s].at(places[p])) {
          ++all;
          if (!(*value > threshold[s])) continue;
          ++within;
          logs[p * n + s] = std::log(*value);
        }
    seen += all;
    body += within;
  });
  if (static_cast<double>(body) > (1 - kAir) * static_cast<double>(seen))
    for (std::size_t s = 0; s < n; ++s)
      c.inside[s] = std::log(threshold[s]);
  // Where scans can be compared; a polynomial would go anywhere beyond that.
  std::vector<Vec3> common;
  const Affine3 toIndex = inverse(box.indexToWorld());
  Bounds bounds; // voxels of the box
  for (std::size_t p = 0; p < places.size(); ++p) {
    const auto first = logs.begin() + static_cast<std::ptrdiff_t>(p * n);
    if (std::count_if(first, first + static_cast<std::ptrdiff_t>(n),
                      [](double l) { return std::isfinite(l); }) < 2)
      continue;
    c.logs.insert(c.logs.end(), first, first + static_cast<std::ptrdiff_t>(n));
    common.push_back(places[p]);
    bounds.include(toIndex(places[p]));
  }
  c.points = common.size();
  if (static_cast<std::int64_t>(c.points) < kFewestPoints) return c;
  c.frame = biasFieldOver(box, bounds.low, bounds.high, kDegree);
  c.terms.resize(c.points * kTerms);
  for (std::size_t p = 0; p < c.points; ++p)
    legendreProducts(c.frame.unit(common[p]), kDegree, {&c.terms[p * kTerms], kTerms});
  return c;
}

using Coefficients = std::vector<std::array<double, kTerms>>; // per scan

double valueAt(const double* terms, const std::array<double, kTerms>& coefficients) {
  double sum = 0;
  for (int t = 0; t < kTerms; ++t)
    sum += coefficients[t] * terms[t];
  return sum;
}

/// The logarithms of a scan's field where it is seen.
std::vector<double> logsOf(const Common& c, std::size_t scan, const std::array<double, kTerms>& field) {
  std::vector<double> logs;
  for (std::size_t p = 0; p < c.points; ++p)
    if (std::isfinite(c.log(p, scan))) logs.push_back(valueAt(&c.terms[p * kTerms], field));
  return logs;
}

/// The logarithms without the fields.
std::vector<double> corrected(const Common& c, const Coefficients& fields, ThreadPool& pool) {
  std::vector<double> logs(c.logs.size());
  const std::size_t n = c.scans.size();
  pool.blocks(static_cast<std::int64_t>(c.points), kBlock, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t p = from; p < to; ++p)
      for (std::size_t s = 0; s < n; ++s)
        logs[p * n + s] = c.logs[p * n + s] - valueAt(&c.terms[p * kTerms], fields[s]);
  });
  return logs;
}

/// The mean of the other scans at a point; NaN: none of them sees it.
double othersAt(const double* logs, std::size_t count, std::size_t own) {
  double sum = 0;
  int seen = 0;
  for (std::size_t s = 0; s < count; ++s)
    if (s != own && std::isfinite(logs[s])) {
      sum += logs[s];
      ++seen;
    }
  return seen > 0 ? sum / seen : kNaN;
}

/// The first `count` coefficients of each field, by iteratively reweighted least squares, scan after scan.
/// Their mean over the scans is removed, as the scans do not determine it.
Coefficients fitFields(const Common& c, int count, ThreadPool& pool) {
  const std::size_t n = c.scans.size();
  Coefficients fields(n);
  for (auto& f : fields)
    f.fill(0);
  const auto blocks = (static_cast<std::int64_t>(c.points) + kBlock - 1) / kBlock;
  const auto square = static_cast<std::size_t>(count) * count;
  for (int iteration = 0; iteration < kShadingIterations; ++iteration)
    for (std::size_t s = 0; s < n; ++s) {
      const std::vector<double> logs = corrected(c, fields, pool);
      std::vector<double> rest(c.points, kNaN), sizes;
      for (std::size_t p = 0; p < c.points; ++p) {
        rest[p] = logs[p * n + s] - othersAt(&logs[p * n], n, s);
        if (std::isfinite(rest[p])) sizes.push_back(std::abs(rest[p]));
      }
      if (static_cast<std::int64_t>(sizes.size()) < kFewestPoints) continue;
      // The first iteration sees the shading itself.
      const double width = iteration == 0 ? std::numeric_limits<double>::infinity() : kTukey * median(sizes);
      std::vector<std::vector<double>> parts(static_cast<std::size_t>(blocks));
      pool.run(blocks, [&](std::int64_t b) {
        std::vector<double>& sum = parts[b];
        sum.assign(square + count + 1, 0);
        const auto end = std::min<std::int64_t>(static_cast<std::int64_t>(c.points), (b + 1) * kBlock);
        for (std::int64_t p = b * kBlock; p < end; ++p) {
          if (!(std::abs(rest[p]) < width)) continue;
          const double t = rest[p] / width, weight = (1 - t * t) * (1 - t * t);
          const double* terms = &c.terms[p * kTerms];
          for (int i = 0; i < count; ++i) {
            for (int j = 0; j <= i; ++j)
              sum[i * count + j] += weight * terms[i] * terms[j];
            sum[square + i] += weight * terms[i] * rest[p];
          }
          sum.back() += weight;
        }
      });
      std::vector<double> total(square + count + 1);
      for (const auto& part : parts)
        for (std::size_t i = 0; i < total.size(); ++i)
          total[i] += part[i];
      if (!(total.back() > 0)) continue;
      std::vector<double> right(total.begin() + static_cast<std::ptrdiff_t>(square), total.end() - 1);
      for (int i = 0; i < count; ++i)
        total[i * (count + 1)] += kRidge * total.back();
      solveCholesky(total, right, count, 1);
      for (int i = 0; i < count; ++i)
        fields[s][i] += right[i];
    }
  for (int i = 0; i < count; ++i) {
    double mean = 0;
    for (const auto& f : fields)
      mean += f[i] / static_cast<double>(n);
    for (auto& f : fields)
      f[i] -= mean;
  }
  return fields;
}

struct Agreement {
  double psnr = kNaN;
  std::vector<double> correlation; // of each scan with the mean of the others
};

Agreement agreementOf(const Common& c, const Coefficients& fields, ThreadPool& pool) {
  const std::size_t n = c.scans.size();
  const std::vector<double> logs = corrected(c, fields, pool);
  Agreement agreement;
  PairedSums all;
  for (std::size_t s = 0; s < n; ++s) {
    PairedSums inside;
    for (std::size_t p = 0; p < c.points; ++p) {
      const double other = std::exp(othersAt(&logs[p * n], n, s)), own = std::exp(logs[p * n + s]);
      if (!std::isfinite(own + other)) continue;
      all.add(own, other);
      if (c.log(p, s) > c.inside[s]) inside.add(own, other); // edges agree in any contrast
    }
    agreement.correlation.push_back(inside.correlation());
  }
  agreement.psnr = all.psnr(c.peak);
  return agreement;
}

/// Samples of what the corrected scans show, each at its own resolution, and the shading in them that
/// sharpens their histogram; none: it could not be found.
std::vector<double> sharedShading(std::span<const Stack> stacks, const Common& c, const Coefficients& fields,
                                  ThreadPool& pool) {
  std::vector<double> logs, terms;
  for (std::size_t n = 0; n < c.scans.size(); ++n) {
    const Stack& stack = stacks[c.scans[n]];
    const GridGeometry& g = stack.image.geometry;
    const double threshold =
        2 * bodyThreshold(BlurredStack(stack, 0, pool)); // Otsu's: the edges of the body tell nothing
    const Affine3 map = g.indexToWorld();
    const auto share = static_cast<std::int64_t>(kSamples / static_cast<std::int64_t>(c.scans.size()));
    const auto every = std::max<std::int64_t>(1, g.voxelCount() / share) | 1;
    for (std::int64_t v = 0; v < g.voxelCount(); v += every) {
      const std::int64_t i = v % g.size[0], j = v / g.size[0] % g.size[1], k = v / (g.size[0] * g.size[1]);
      if (i == 0 || j == 0 || i + 1 == g.size[0] || j + 1 == g.size[1]) continue;
      double mean = 0;
      for (int dj = -1; dj <= 1; ++dj)
        for (int di = -1; di <= 1; ++di) {
          const auto at = static_cast<std::size_t>(v + di + dj * g.size[0]);
          const bool seen = stack.observed.empty() || stack.observed[at];
          mean += (seen ? stack.image.voxels[at] : kNaN) * (2 - std::abs(di)) * (2 - std::abs(dj)) / 16;
        }
      if (!(mean > threshold)) continue;
      const Vec3 at = map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
      const Vec3 unit = c.frame.toBox(at);
      if (std::any_of(unit.begin(), unit.end(), [](double u) { return std::abs(u) > 1; })) continue;
      std::array<double, kTerms> products;
      legendreProducts(unit, kDegree, products);
      logs.push_back(std::log(mean) - valueAt(products.data(), fields[n]));
      terms.insert(terms.end(), products.begin() + 1, products.begin() + kShared);
    }
  }
  return sharpestShading(logs, terms, kShared - 1, [&] { pool.throwIfStopped(); });
}

struct Search {
  double least = kWorthwhile; // dB that a correction must gain
  bool shared = true;         // also looks for what all scans share
};

/// The shading of stacks as they lie.
BiasCorrection findFields(std::span<const Stack> stacks, const Search& search, ThreadPool& pool) {
  BiasCorrection result;
  std::vector<std::size_t> part;
  for (std::size_t s = 0; s < stacks.size(); ++s)
    if (stacks[s].poses.empty()) part.push_back(s);
  if (part.size() < 2) return result;
  const double sigma = commonResolution(stacks, part);
  std::erase_if(part, [&](std::size_t s) { // noise apart
    return belowZero(valuesOf(BlurredStack(stacks[s], sigma, pool)));
  });
  Common c;
  Coefficients fields;
  for (;;) {
    if (part.size() < 2) return result;
    c = look(stacks, part, pool);
    if (static_cast<std::int64_t>(c.points) < kFewestPoints) return result;
    fields = fitFields(c, kTerms, pool);
    const Agreement after = agreementOf(c, fields, pool);
    std::vector<std::size_t> alike;
    for (std::size_t n = 0; n < part.size(); ++n)
      if (after.correlation[n] >= kSameTissue) alike.push_back(part[n]);
    if (alike.size() == part.size()) {
      result.psnrAfter = after.psnr;
      break;
    }
    if (alike.size() < 2) return result;
    part = alike;
  }
  result.psnrBefore = agreementOf(c, fitFields(c, 1, pool), pool).psnr;
  if (!(result.psnrAfter >= result.psnrBefore + search.least)) {
    result.psnrAfter = result.psnrBefore;
    return result;
  }
  result.scans.resize(stacks.size());
  double own = 0, count = 0;
  const std::size_t n = part.size();
  for (std::size_t s = 0; s < n; ++s) {
    const std::vector<double> logs = logsOf(c, s, fields[s]);
    double mean = 0;
    for (const double l : logs)
      mean += l / static_cast<double>(logs.size());
    for (const double l : logs)
      own += (l - mean) * (l - mean);
    count += static_cast<double>(logs.size());
    const auto [low, high] = std::minmax_element(logs.begin(), logs.end());
    result.scans[part[s]].lowest = std::exp(*low - mean);
    result.scans[part[s]].highest = std::exp(*high - mean);
  }
  // Shadings that are independent of each other leave a mean of this size; more is anatomy.
  const double expected = own / count / static_cast<double>(n - 1);
  result.sharedDeviation = std::sqrt(expected);
  std::vector<double> shared;
  if (search.shared) shared = sharedShading(stacks, c, fields, pool);
  if (!shared.empty()) {
    std::array<double, kTerms> all{};
    std::copy(shared.begin(), shared.end(), all.begin() + 1);
    double mean = 0, squared = 0;
    std::vector<double> logs(c.points);
    for (std::size_t p = 0; p < c.points; ++p)
      mean += (logs[p] = valueAt(&c.terms[p * kTerms], all)) / static_cast<double>(c.points);
    for (const double l : logs)
      squared += (l - mean) * (l - mean);
    if (squared / static_cast<double>(c.points) <= kExcess * kExcess * expected) {
      all[0] = -mean;
      for (auto& f : fields)
        for (int t = 0; t < kTerms; ++t)
          f[t] += all[t];
      const auto [low, high] = std::minmax_element(logs.begin(), logs.end());
      result.sharedLowest = std::exp(*low - mean);
      result.sharedHighest = std::exp(*high - mean);
      result.sharedDeviation = std::min(result.sharedDeviation, kLeftShared);
    }
  }
  for (std::size_t s = 0; s < n; ++s) {
    BiasField& field = result.scans[part[s]].field;
    field = c.frame;
    field.coefficients.assign(fields[s].begin(), fields[s].end());
    const std::vector<double> logs = logsOf(c, s, fields[s]);
    const auto [low, high] = std::minmax_element(logs.begin(), logs.end());
    field.lowestLog = *low;
    field.highestLog = *high;
  }
  return result;
}

/// Shading and alignment in turn, from the given alignment (empty: scans stay) on.
BiasCorrection alternate(std::span<const Stack> stacks, std::vector<StackAlignment>& alignment,
                         const Search& search, ThreadPool& pool) {
  std::vector<Stack> placed(stacks.begin(), stacks.end());
  if (!alignment.empty()) applyAlignment(alignment, placed);
  BiasCorrection found = findFields(placed, search, pool);
  for (int round = 0; round < kRounds && !found.scans.empty() && !alignment.empty(); ++round) {
    for (std::size_t s = 0; s < placed.size(); ++s) {
      applyBias(found.scans[s], placed[s], pool);
      placed[s].image.geometry = stacks[s].image.geometry;
    }
    std::vector<StackAlignment> again = alignStacks(placed, pool);
    for (std::size_t s = 0; s < placed.size(); ++s)
      again[s].gain *= alignment[s].gain;
    placed.assign(stacks.begin(), stacks.end());
    applyAlignment(again, placed);
    BiasCorrection better = findFields(placed, search, pool);
    const bool gains = better.psnrAfter > found.psnrAfter + kConverged;
    alignment = std::move(again);
    found = std::move(better);
    if (!gains) break;
  }
  return found;
}

/// The better of alternate() from the alignment and from the headers.
BiasCorrection find(std::span<const Stack> stacks, std::vector<StackAlignment>& alignment,
                    const Search& search, ThreadPool& pool) {
  BiasCorrection found = alternate(stacks, alignment, search, pool);
  if (std::all_of(alignment.begin(), alignment.end(), [](const auto& a) { return a.displacement == 0; }))
    return found;
  // Shading can make the alignment move scans that are already in place.
  std::vector<StackAlignment> still(alignment.size());
  BiasCorrection other = alternate(stacks, still, search, pool);
  if (other.scans.empty() || !(other.psnrAfter > found.psnrAfter + kConverged)) return found;
  alignment = std::move(still);
  return other;
}

} // namespace

BiasCorrection findBias(std::span<const Stack> stacks, std::vector<StackAlignment>& alignment, bool always,
                        ThreadPool& pool) {
  return find(stacks, alignment, {always ? 0 : kWorthwhile}, pool);
}

BiasCorrection findShading(std::span<const Stack> stacks, std::vector<StackAlignment>& alignment,
                           ThreadPool& pool) {
  std::vector<StackAlignment> refined = alignment;
  BiasCorrection found = find(stacks, refined, {kClear, false}, pool);
  if (!found.scans.empty()) alignment = std::move(refined);
  return found;
}

void applyBias(const BiasCorrection::Scan& scan, Stack& stack, ThreadPool& pool,
               const BiasCorrection::Scan* kept) {
  if (kept && kept->field.coefficients.empty()) kept = nullptr;
  if (scan.field.coefficients.empty() && !kept) return;
  const GridGeometry& g = stack.image.geometry;
  const Affine3 map = g.indexToWorld();
  pool.blocks(g.size[1] * g.size[2], 16, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t row = from; row < to; ++row)
      for (std::int64_t i = 0; i < g.size[0]; ++i) {
        const Vec3 x = map({static_cast<double>(i), static_cast<double>(row % g.size[1]),
                            static_cast<double>(row / g.size[1])});
        double log = scan.field.coefficients.empty() ? 0 : -scan.field.logAt(x);
        if (kept) log += kept->field.logAt(x);
        stack.image.voxels[row * g.size[0] + i] *= static_cast<float>(std::exp(log));
      }
  });
}

std::string biasSentence(const BiasCorrection::Scan& scan, const std::string& name) {
  if (scan.field.coefficients.empty() || scan.highest - scan.lowest < kLeast) return {};
  return name + formatted(" is shaded by %.2f to %.2f against the others: this was corrected.", scan.lowest,
                          scan.highest);
}

std::string biasSentence(const BiasCorrection& c, const std::string& kept) {
  if (c.scans.empty()) return {};
  if (!kept.empty())
    return formatted("With the same shading, that of %s, the scans agree to %.1f dB (before: %.1f dB).",
                     kept.c_str(), c.psnrAfter, c.psnrBefore);
  std::string text = formatted("With shading removed, the scans agree to %.1f dB (before: %.1f dB).",
                               c.psnrAfter, c.psnrBefore);
  if (c.sharedHighest > c.sharedLowest)
    text += formatted(
        " A shading by %.2f to %.2f that all share was estimated from their histogram and corrected as well.",
        c.sharedLowest, c.sharedHighest);
  else
    text += " Shading that all scans share remains.";
  return text;
}

std::string shadingSentence(const BiasCorrection& c) {
  if (c.scans.empty()) return {};
  return formatted("The scans look shaded differently: evened out, they would agree to %.1f dB (as they are: "
                   "%.1f dB). The setting biasField (--bias-field auto) does that.",
                   c.psnrAfter, c.psnrBefore);
}

} // namespace innergs
