#pragma once
#include "Core/Motion/TimeSeries.h"

namespace innergs {

/// A moving phantom with unpredictable poses: textured blobs and rods on a background; one half rotates about
/// a joint while the other stays, smoothly in time except for an independent jitter of every frame. Rician
/// noise.
struct JitteredPhantom {
  GridGeometry geometry{{64, 64, 12}, {0, 0, 0}, {1.6, 1.6, 5}, {}};
  int frames = 38;
  double interval = 0.5;    // s
  double swing = 20;        // degrees, amplitude
  double period = 15;       // s
  double angleJitter = 0.5; // degrees, standard deviation
  double shiftJitter = 0.2; // mm, standard deviation along each in-plane axis
  double noise = 30;        // for a range of about 4000
  std::uint64_t seed = 1;
};

TimeSeries makeJitteredPhantom(const JitteredPhantom& phantom);

} // namespace innergs
