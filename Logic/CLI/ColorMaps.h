#pragma once
#include "CLI/Picture.h"
#include "Core/Image/Volume.h"

namespace innergs::cli {

constexpr Colour kPictureBackground{24, 24, 28}, kFaintText{170, 170, 170};
constexpr double kErrorCeiling = 0.1; // of the peak: the brightest error colour

/// 0 black, 1 white; the background for what is not finite.
Colour grey(double value);
/// 0 black, then red and yellow, 1 white; the background for what is not finite.
Colour heat(double value);

/// Greys of one volume's values: its 0.1 % and 99.9 % quantiles are black and white.
class GreyScale {
public:
  explicit GreyScale(const Volume& volume);
  Colour operator()(float value) const { return grey((value - low_) / (high_ - low_)); }

private:
  double low_, high_;
};

} // namespace innergs::cli
