#pragma once
#include "Core/Features/FeatureTraining.h"
#include "Core/Job/Progress.h"
#include "Core/Settings/Settings.h"
#include "Evaluation/ExperimentTable.h"

namespace innergs {

/// A labelmap of the experiment's volume: the truth and, on some slices, the training labels.
struct LabelSet {
  std::string name;
  Labelmap labels;
  std::vector<SegmentName> names;
};

struct SegmentationExperiment {
  Volume volume;
  std::string volumeName; // for titles
  std::vector<LabelSet> sets;
  std::vector<int> every{1, 5, 10}; // distances of the labelled slices along K: all, every 5th, every 10th
  std::int64_t leastVoxels = 500;   // minimum size of a class that counts
  Settings settings;                // for the fit; threads
  FeatureTraining training;
  ProgressCallback progress;                   // for the fit
  std::function<void(const std::string&)> say; // called with the next step
  std::stop_token stop;                        // when stopped, throws Error(Cancelled)
};

struct SegmentationResult {
  ExperimentTable methods; // by set and distance of labelled slices, means over the classes
  ExperimentTable classes; // per class
  ExperimentTable grids;   // all slices labelled, on an oblique and on a finer grid
  ExperimentTable queries; // how long decoding a grid and making one segment after it take
};

/// Fits the volume, learns features from the labels of some slices, and compares with the truth on the
/// others, next to label interpolations that ignore the image. Throws Error(InvalidArgument) if a labelmap
/// has another grid than the volume, Error(Cancelled).
SegmentationResult runSegmentation(const SegmentationExperiment& experiment);

} // namespace innergs
