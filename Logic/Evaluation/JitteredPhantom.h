#pragma once
#include "Core/Motion/TimeSeries.h"

namespace innergs {

/// A moving phantom whose poses nobody can foresee: textured blobs and rods on a ground, of which one half
/// turns about a joint while the other stays, smoothly in time but for a jitter of every frame's own; Rician
/// noise.
struct JitteredPhantom {
  GridGeometry geometry{{64, 64, 12}, {0, 0, 0}, {1.6, 1.6, 5}, {}};
  int frames = 38;
  double interval = 0.5;     // s
  double swing = 20;         // degrees, amplitude
  double period = 15;        // s
  double angleJitter = 0.5;  // degrees, standard deviation
  double shiftJitter = 0.2; // mm, standard deviation, along every axis in-plane
  double noise = 30;         // of a range of about 4000
  std::uint64_t seed = 1;
};

TimeSeries makeJitteredPhantom(const JitteredPhantom& phantom);

} // namespace innergs
