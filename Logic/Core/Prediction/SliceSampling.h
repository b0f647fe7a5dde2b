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

/// Gaussian of σ (samples), with weights summing to 1; the identity for σ below 0.05.
LineFilter gaussianFilter(double sigma);

/// Both filters, one after the other.
LineFilter convolved(const LineFilter& a, const LineFilter& b);

/// A slice profile of `width` samples (box width or FWHM) around a sample; the identity if it is no wider
/// than one sample. `centre`: of the profile, in samples after that sample.
LineFilter profileFilter(SliceProfile profile, double width, double centre = 0);

/// How slices sample a line of thin samples: slice c is `slice` applied around thin sample c·phases; its own
/// thin samples are c·phases + firstPhase … + phases − 1.
struct SliceSampling {
  int phases = 0;     // thin samples per slice distance
  int firstPhase = 0; // places them around the slice's centre
  double pitch = 0;   // mm between thin samples
  double centre = 0;  // the slice's centre, in thin samples after c·phases
  LineFilter slice;   // the slice profile
};

/// For a stack whose thin samples are the K indices of `thin`, which equals the stack's grid except along
/// K.
SliceSampling sliceSampling(const Stack& stack, const GridGeometry& thin, int phases);

/// Positions of one grid's samples in the samples of another along an axis: first + step·t.
struct LinePositions {
  double first = 0, step = 1;
};

/// Resamples the middle axis of a memory-order array [outer][n][inner] at `count` positions: windowed sinc of
/// radius 4, border samples repeated; a copy if the positions are the samples. Runs on the pool, if given.
std::vector<float> resampledAlong(const float* values, std::int64_t outer, std::int64_t n, std::int64_t inner,
                                  const LinePositions& positions, std::int64_t count,
                                  ThreadPool* pool = nullptr);

} // namespace innergs
