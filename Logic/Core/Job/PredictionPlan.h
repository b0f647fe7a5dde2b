#pragma once
#include "Core/Job/JobInput.h"
#include "Core/Prediction/SlicePredictor.h"

namespace innergs {

/// Whether a field fitted to the slices alone takes part in the prediction of this many voxels.
bool triesField(const Settings& settings, double voxels);

/// The grids of a prediction's trial on a scan: every second slice, and all slices up to the last of
/// these.
struct TrialGrids {
  GridGeometry kept, all;
};
TrialGrids trialGrids(const GridGeometry& scan);

/// Slice thickness over slice distance, at most 1; 0: slices are taken as points.
double relativeThickness(const Stack& scan);

/// The share with which a field fitted to noisy slices alone is averaged with their prediction on this
/// many voxels, once its noise is removed: the errors of the two differ. noise: standard deviation relative
/// to the intensity range.
double fieldShareOfNoisy(const Stack& scan, const Settings& settings, double noise, std::int64_t voxels);

/// For estimates: the input of the fit to a prediction, thin slices without voxels.
ReconstructionInput predictionOutline(const ReconstructionInput& input, const GridGeometry& output);

/// The effort spent on learning for a prediction of this many voxels, before its trial says how much there is
/// to learn. trial: of learning from every second slice.
PredictionEffort learningEffort(const Settings& settings, double voxels, bool trial);

/// The settings of the field of triesField(). longer: more iterations with the preset balanced. noisy: as few
/// as with the preset fast, since more would fit the noise.
Settings fieldSettings(const Settings& settings, bool longer = false, bool noisy = false);
/// Likewise of the one that is fitted to every second slice, for a prediction of this many voxels.
Settings trialFieldSettings(const Settings& settings, double voxels, bool noisy = false);

/// The settings of a prediction from one of several scans: longer learning gains nothing there.
Settings scanSettings(Settings settings);

/// About how long the steps of a prediction and of the fit to it take, in multiply-adds of a network by one
/// thread.
struct PredictionCost {
  double choosing = 0;   // interpolations
  double trialField = 0; // a field fitted to every second slice, if triesField()
  double trial = 0;      // learning from these, and applying it
  double learning = 0;   // likewise from all slices
  double field = 0;      // a field fitted to all slices
  double mixing = 0;     // and making the mixture consistent with the slices
  double fit = 0;        // of the Gaussians to the prediction, to the end of the job

  /// All but the fit, for a prediction of this many voxels. averaged: with a field, see fieldShareOfNoisy().
  double beforeFit(const Settings& settings, double voxels, bool averaged) const;
};

/// From the grids of a scan and of its prediction; needs no voxels.
PredictionCost predictionCost(const Stack& scan, const GridGeometry& grid, const Settings& settings);

/// PredictionCost::learning with this effort and PredictionOptions::muchToLearn.
double learningCost(const GridGeometry& scan, const GridGeometry& grid, PredictionEffort effort,
                    const Settings& settings, double muchToLearn = 0);

} // namespace innergs
