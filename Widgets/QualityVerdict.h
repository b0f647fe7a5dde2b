#pragma once
#include "Widgets/Request.h"

namespace innergs::ui {

enum class Verdict {
  Unknown,
  Better, // by one measure at least, and by none worse
  AsGood,
  Mixed, // better by one measure and worse by the other
  Worse
};

/// How InnerGS compares with the best of the other methods by one measure.
struct Measured {
  int sign = 0;    // 1: better, 0: no visible difference, or unknown; −1: worse
  double gain = 0; // of InnerGS over the other; NaN: unknown
  QString other;   // method
};

/// PSNR and SSIM count alike, for InnerGS and against it.
struct Comparison {
  Verdict verdict = Verdict::Unknown;
  Measured psnr, ssim;
};
Comparison compare(const QVector<QualityRow>& rows);

} // namespace innergs::ui
