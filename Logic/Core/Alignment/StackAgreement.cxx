#include "Core/Alignment/StackAgreement.h"

#include "Core/Alignment/PairedSums.h"
#include "Core/Alignment/SamplePlaces.h"
#include "Core/Base/NumberText.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::int64_t kBlock = 4096;
constexpr double kPlaceDistance = 0.7; // in σ of the common resolution
constexpr double kClose = 0.95;        // least correlation of scans that lie where they should
constexpr double kSameBrightness = 0.05;

/// What the scans show at common places; NaN: not seen, or air.
struct CommonSamples {
  std::size_t scans = 0, places = 0;
  std::vector<double> values; // [places][scans]

  double at(std::size_t place, std::size_t scan) const { return values[place * scans + scan]; }
};

CommonSamples look(std::span<const BlurredStack> images, double distance, ThreadPool& pool) {
  std::vector<GridGeometry> boxes;
  std::vector<double> threshold;
  for (const BlurredStack& image : images) {
    boxes.push_back(observedBox(image));
    threshold.push_back(bodyThreshold(image));
  }
  const std::vector<Vec3> places = spreadPlaces(gridAround(boxes, distance, 0), distance);
  CommonSamples seen{images.size(), places.size(), std::vector<double>(images.size() * places.size(), kNaN)};
  pool.blocks(static_cast<std::int64_t>(places.size()), kBlock, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t p = from; p < to; ++p)
      for (std::size_t s = 0; s < images.size(); ++s)
        if (const auto value = images[s].at(places[p]); value && *value >= threshold[s])
          seen.values[p * images.size() + s] = *value;
  });
  return seen;
}

double correlationOf(const CommonSamples& seen, std::size_t one, std::size_t other) {
  PairedSums sums;
  for (std::size_t p = 0; p < seen.places; ++p)
    if (const double a = seen.at(p, one), b = seen.at(p, other); std::isfinite(a + b)) sums.add(a, b);
  return sums.correlation();
}

/// The scan's group: a number that scans share if a chain of alike ones joins them.
std::vector<std::size_t> groupsOf(const std::vector<std::vector<double>>& correlation) {
  std::vector<std::size_t> group(correlation.size());
  for (std::size_t s = 0; s < group.size(); ++s)
    group[s] = s;
  for (std::size_t s = 0; s < group.size(); ++s)
    for (std::size_t t = 0; t < s; ++t)
      if (correlation[s][t] >= kSameTissue) {
        const std::size_t from = std::max(group[s], group[t]), to = std::min(group[s], group[t]);
        std::replace(group.begin(), group.end(), from, to);
      }
  return group;
}

std::string listed(const std::vector<double>& values) {
  std::string text;
  for (std::size_t n = 0; n < values.size(); ++n)
    text += (n == 0 ? "" : n + 1 == values.size() ? " and " : ", ") + formatted("%.1f", values[n]);
  return text;
}

/// How well the scans agree.
std::string between(std::span<const StackAgreement> agreement) {
  std::vector<double> psnr;
  double least = 1;
  bool fit = true, bright = true;
  for (const StackAgreement& a : agreement) {
    fit = fit && a.fits;
    bright = bright && std::abs(a.ratio - 1) < kSameBrightness;
    if (!std::isfinite(a.psnr)) continue;
    psnr.push_back(a.psnr);
    least = std::min(least, a.correlation);
  }
  if (psnr.empty())
    return fit ? "Whether the scans agree is not known: they show too little in common to be compared."
               : "The scans do not agree: they show too little in common to be compared.";
  const char* how = !fit             ? "Not all scans agree"
                    : least < kClose ? "The scans agree in part"
                    : bright         ? "The scans agree"
                                     : "The scans agree except in brightness";
  const auto [low, high] = std::minmax_element(psnr.begin(), psnr.end());
  const std::string range =
      *high - *low < 0.05 ? formatted("%.1f dB", *low) : formatted("%.1f to %.1f dB", *low, *high);
  return formatted("%s: PSNR between them %s, correlation %.2f%s.", how, range.c_str(), least,
                   psnr.size() > 1 ? " or more" : "");
}

/// What the finished result shows of the slices that it was fitted to; "" if that was not measured.
std::string fitted(std::span<const StackAgreement> agreement) {
  std::vector<double> psnr;
  for (const StackAgreement& a : agreement)
    if (!std::isnan(a.fittedPsnr)) psnr.push_back(a.fittedPsnr);
  if (psnr.size() != agreement.size()) return {};
  return " The result shows the slices of each scan, which it was fitted to, at " + listed(psnr) + " dB.";
}

} // namespace

std::vector<StackAgreement> compareStacks(std::span<const Stack> stacks, ThreadPool& pool) {
  std::vector<StackAgreement> result(stacks.size());
  std::vector<std::size_t> part;
  for (std::size_t s = 0; s < stacks.size(); ++s)
    if (stacks[s].poses.empty()) part.push_back(s);
  if (part.size() < 2) return result;
  const double sigma = commonResolution(stacks, part);
  std::vector<BlurredStack> images;
  for (const std::size_t s : part)
    images.emplace_back(stacks[s], sigma, pool);
  const CommonSamples seen = look(images, kPlaceDistance * sigma, pool);
  const std::size_t count = part.size();
  std::vector<std::vector<double>> correlation(count, std::vector<double>(count, kNaN));
  for (std::size_t s = 0; s < count; ++s)
    for (std::size_t t = 0; t < s; ++t)
      correlation[s][t] = correlation[t][s] = correlationOf(seen, s, t);
  const std::vector<std::size_t> group = groupsOf(correlation);
  const auto members = [&](std::size_t g) { return std::count(group.begin(), group.end(), g); };
  std::size_t most = group.front();
  for (const std::size_t g : group)
    if (members(g) > members(most)) most = g;
  const ValueRange range = valuesOf(images.front());
  const double peak = static_cast<double>(range.high) - range.low;
  for (std::size_t s = 0; s < count; ++s) {
    if (std::none_of(correlation[s].begin(), correlation[s].end(), [](double c) { return std::isfinite(c); }))
      continue; // a slab that adjoins
    StackAgreement& mine = result[part[s]];
    mine.fits = group[s] == most;
    const bool alone = members(most) == 1; // no two are alike
    PairedSums sums;
    for (std::size_t p = 0; p < seen.places; ++p) {
      double others = 0;
      int n = 0;
      for (std::size_t t = 0; t < count; ++t)
        if (t != s && (alone || group[t] == most) && std::isfinite(seen.at(p, t))) {
          others += seen.at(p, t);
          ++n;
        }
      if (n > 0 && std::isfinite(seen.at(p, s))) sums.add(others / n, seen.at(p, s));
    }
    mine.correlation = sums.correlation();
    mine.psnr = sums.psnr(peak);
    if (sums.enough() && mine.fits && !belowZero(valuesOf(images[s]))) mine.ratio = sums.ab / sums.bb;
  }
  return result;
}

std::vector<StackAgreement> agreementsOf(std::span<const StackAlignment> alignment) {
  std::vector<StackAgreement> result;
  for (const StackAlignment& a : alignment) {
    StackAgreement& mine = result.emplace_back();
    mine.correlation = a.correlation;
    mine.psnr = a.psnrAfter;
    mine.fits = a.fits;
  }
  return result;
}

std::string agreementSentence(std::span<const StackAgreement> agreement) {
  return agreement.size() < 2 ? std::string() : between(agreement) + fitted(agreement);
}

std::string misfitSentence(const StackAgreement& a, const std::string& name, bool slicesMoved) {
  if (a.fits) return {};
  if (std::isnan(a.correlation))
    return name + " shares too little with the other scans to be compared with them: it was not moved. "
                  "Check that it shows the same body.";
  return name + formatted(" does not fit the other scans (correlation %.2f, PSNR %.1f dB between them)%s. "
                          "Check that it shows the same body with the same contrast.",
                          a.correlation, a.psnr,
                          slicesMoved ? ", even with its slices moved" : ": it was not moved");
}

} // namespace innergs
