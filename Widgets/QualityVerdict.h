#pragma once
#include "Widgets/Request.h"

namespace innergs::ui {

enum class Verdict {
  Unknown,
  Better, // in at least one measure, and worse in none
  AsGood,
  Mixed, // better in one measure and worse in the other
  Worse
};

/// InnerGS compared with the best of the other methods in one measure.
struct Measured {
  int sign = 0;    // 1: better, 0: no visible difference, or unknown; −1: worse
  double gain = 0; // of InnerGS over the other; NaN: unknown
  QString other;   // method
};

/// PSNR and SSIM count equally, for InnerGS and against it.
struct Comparison {
  Verdict verdict = Verdict::Unknown;
  Measured psnr, ssim;
};
Comparison compare(const QVector<QualityRow>& rows);

} // namespace innergs::ui
