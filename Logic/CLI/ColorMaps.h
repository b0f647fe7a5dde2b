#pragma once
#include "CLI/Picture.h"
#include "Core/Image/Volume.h"

namespace innergs::cli {

constexpr Colour kPictureBackground{24, 24, 28}, kFaintText{170, 170, 170};
constexpr double kErrorCeiling = 0.1; // share of the peak that gets the brightest error colour

/// 0 black, 1 white; the background colour for non-finite values.
Colour grey(double value);
/// 0 black, through red and yellow to 1 white; the background colour for non-finite values.
Colour heat(double value);

/// Maps one volume's values to greys: its 0.1 % and 99.9 % quantiles are black and white.
class GreyScale {
public:
  explicit GreyScale(const Volume& volume);
  Colour operator()(float value) const { return grey((value - low_) / (high_ - low_)); }

private:
  double low_, high_;
};

} // namespace innergs::cli
