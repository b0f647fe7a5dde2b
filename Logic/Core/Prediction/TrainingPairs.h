#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Base/Random.h"
#include "Core/Image/FilledImage.h"
#include "Core/Prediction/SliceSampling.h"

namespace innergs {

/// The known voxels of the image's body mask.
std::vector<std::uint8_t> knownBody(const FilledImage& filled, const std::stop_token& stop);

/// An in-plane image whose rows run along the axis to be degraded, in thin samples: values[row][column].
struct TrainingPlane {
  int rows = 0, columns = 0;
  std::vector<float> values;
  std::vector<std::uint8_t> inside; // in the body and known; the same shape
  double share = 0;                 // share of it inside
};

/// The in-plane images of a scan for training, and those held out to measure the result.
struct TrainingPlanes {
  std::vector<TrainingPlane> learning, measuring;
  double noise = 0; // standard deviation in image units
};

struct TrainingPlanesRequest {
  std::array<bool, 2> axes{true, true}; // in-plane axes that are degraded
  double sigma = 0;                     // of the matching blur, in in-plane samples
  std::int64_t mostSamples = 8'000'000; // of all planes together
};
/// Takes slices evenly spread over the stack and holds out every sixth. body: 1 inside, like the image.
TrainingPlanes trainingPlanes(const FilledImage& filled, const std::vector<std::uint8_t>& body,
                              const SliceSampling& sampling, const TrainingPlanesRequest& request,
                              ThreadPool& pool);

/// A piece of a plane as slices show it, with the thin samples between them.
struct TrainingPair {
  int slices = 0, columns = 0;
  std::vector<float> low;           // [slice][column]
  std::vector<float> thin;          // [slice][column][phase]
  std::vector<std::uint8_t> inside; // [slice][column]: scored
};

/// Size and place of a pair within its plane.
struct PairPlace {
  int plane = 0, row = 0, column = 0; // thin sample of the first slice, first column
  bool flipRows = false, flipColumns = false;
};

/// Thin rows that a pair of this many slices needs.
int thinRows(const SliceSampling& sampling, int slices);

/// Degrades the plane like the slices; `noise`: standard deviation of the noise that averaging removed and
/// that is added again.
void makePair(const TrainingPlane& plane, const PairPlace& place, const SliceSampling& sampling, int slices,
              int columns, double noise, Random& random, TrainingPair& pair);

} // namespace innergs
