#pragma once
#include "Core/Features/FeatureTraining.h"
#include "Core/Job/Progress.h"
#include "Core/Settings/Settings.h"
#include "Evaluation/ExperimentTable.h"

namespace innergs {

/// A labelmap of the experiment's volume: it is truth and, on some slices, teacher.
struct LabelSet {
  std::string name;
  Labelmap labels;
  std::vector<SegmentName> names;
};

struct SegmentationExperiment {
  Volume volume;
  std::string volumeName; // for titles
  std::vector<LabelSet> sets;
  std::vector<int> every{1, 5, 10}; // slices along K that the teacher labels: all, every 5th, every 10th
  std::int64_t leastVoxels = 500;   // of a class that counts
  Settings settings;                // of the fit; threads
  FeatureTraining training;
  ProgressCallback progress;                   // of the fit
  std::function<void(const std::string&)> say; // what begins
  std::stop_token stop;                        // stopped: throws Error(Cancelled)
};

struct SegmentationResult {
  ExperimentTable methods; // per set and spacing of labelled slices, means over the classes
  ExperimentTable classes; // per class
  ExperimentTable grids;   // all slices labelled, on an oblique and on a finer grid
  ExperimentTable queries; // how long decoding a grid and making one segment after it take
};

/// Fits the volume, learns features from the labels of some slices, and compares with the truth on the
/// others; beside what interpolation without the image makes of the same slices. Throws
/// Error(InvalidArgument) where a labelmap has another lattice than the volume, Error(Cancelled).
SegmentationResult runSegmentation(const SegmentationExperiment& experiment);

} // namespace innergs
