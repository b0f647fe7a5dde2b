#include "Widgets/QualityVerdict.h"

#include <cmath>

namespace innergs::ui {
namespace {

// Invisible differences.
constexpr double kSamePsnr = 0.1; // dB
constexpr double kSameSsim = 0.005;

Measured measured(const QVector<QualityRow>& rows, double QualityRow::*score, double same) {
  const QualityRow *ours = nullptr, *best = nullptr;
  for (const QualityRow& row : rows) {
    if (!std::isfinite(row.*score)) continue;
    const QualityRow*& place = row.isOurs() ? ours : best;
    if (!place || row.*score > place->*score) place = &row;
  }
  if (!ours || !best) return {0, NAN, {}};
  const double gain = ours->*score - best->*score;
  // Rounded like the printed figure.
  const int sign = gain > same - 1e-9 ? 1 : gain < -same + 1e-9 ? -1 : 0;
  return {sign, gain, best->method};
}

} // namespace

Comparison compare(const QVector<QualityRow>& rows) {
  Comparison found;
  found.psnr = measured(rows, &QualityRow::psnr, kSamePsnr);
  found.ssim = measured(rows, &QualityRow::ssim, kSameSsim);
  if (std::isnan(found.psnr.gain) && std::isnan(found.ssim.gain)) return found;
  const int sum = found.psnr.sign + found.ssim.sign;
  found.verdict = sum > 0                                        ? Verdict::Better
                  : sum < 0                                      ? Verdict::Worse
                  : found.psnr.sign == 0 && found.ssim.sign == 0 ? Verdict::AsGood
                                                                 : Verdict::Mixed;
  return found;
}

} // namespace innergs::ui
