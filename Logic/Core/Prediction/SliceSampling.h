#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

#include <vector>

namespace innergs {

/// A filter along a line: out[t] = Σ_i weights[i] · in[t + first + i].
struct LineFilter {
  int first = 0;
  std::vector<float> weights;

  int last() const { return first + static_cast<int>(weights.size()) - 1; }
};

/// Gaussian of σ (samples), weights summing to 1; the identity for σ below 0.05.
LineFilter gaussianFilter(double sigma);

/// One after the other.
LineFilter convolved(const LineFilter& a, const LineFilter& b);

/// A slice profile of `width` samples (box width or FWHM) around a sample; the identity where it is no wider
/// than one. `centre`: of the profile, in samples after that one.
LineFilter profileFilter(SliceProfile profile, double width, double centre = 0);

/// How slices sample a line of thin samples: slice c is `slice` applied around thin sample c·phases, and the
/// thin samples that belong to it are c·phases + firstPhase … + phases − 1.
struct SliceSampling {
  int phases = 0;     // thin samples per slice distance
  int firstPhase = 0; // so that they lie around the slice's centre
  double pitch = 0;   // mm between thin samples
  double centre = 0;  // the slice's centre, in thin samples after c·phases
  LineFilter slice;   // the slice profile
};

/// Of a stack whose thin samples are the K indices of `thin`: the stack's lattice but for the K axis.
SliceSampling sliceSampling(const Stack& stack, const GridGeometry& thin, int phases);

/// Positions in samples of one lattice, of the samples of another along an axis: first + step·t.
struct LinePositions {
  double first = 0, step = 1;
};

/// A memory-order array [outer][n][inner] with its middle axis sampled at `count` positions, windowed sinc of
/// radius 4, the border sample repeated. Copies where the positions are the samples. With a pool, on its
/// threads.
std::vector<float> resampledAlong(const float* values, std::int64_t outer, std::int64_t n, std::int64_t inner,
                                  const LinePositions& positions, std::int64_t count,
                                  ThreadPool* pool = nullptr);

} // namespace innergs
