#pragma once
#include "Core/Job/JobInput.h"
#include "Core/Job/JobProgress.h"
#include "Core/Job/PredictionPlan.h"
#include "Core/Prediction/CandidateChoice.h"
#include "Core/Prediction/SlicePredictor.h"

#include <utility>

namespace innergs {

/// Predicts what lies between the slices of one scan before the fit: the Gaussians are fitted to it, and what
/// they miss of it is kept with them.
class SlicePrediction {
public:
  /// The volume, on a grid, of a field fitted to slices alone; from, to: its part of the progress.
  using FieldFit = std::function<Volume(const Stack& slices, const GridGeometry& grid,
                                        const Settings& settings, double from, double to)>;

  /// noise: of the scan, scanner units. thenFitted: a fit to the prediction follows in the same progress.
  /// predict() uses everything else but the settings.
  SlicePrediction(const PreparedInput& prepared, Settings settings, PredictionParts parts, double noise,
                  FieldFit fitField, bool thenFitted, JobProgress& progress, ThreadPool& pool);

  /// Has predict() also fit, and keep, a field to the slices alone.
  void keepField() { keepsField_ = parts_.field; }
  /// The prediction as thin slices. Throws Error(Cancelled).
  Stack predict();
  /// That field's volume on the grid of the prediction; nothing where the scan is only interpolated.
  std::optional<Volume> takeField() { return std::exchange(field_, std::nullopt); }
  /// After predict(): whether it was made to agree with thick slices by back-projection.
  bool backProjects() const {
    return settings_.consistency && choice_.backProject && scan_.profile != SliceProfile::Point;
  }
  /// Says what was put between the slices.
  const std::string& sentence() const { return sentence_; }

private:
  /// Volumes between the slices that may be mixed with the interpolation.
  struct Candidates {
    std::optional<Volume> field, learned;
    std::optional<Volume> mean;      // of a trial: what was learned, with the mean of the two planes
    std::vector<std::uint8_t> known; // voxels that were learned; empty: all
    std::string sentence;            // on the learning
    PairErrors pairs;                // likewise
  };
  /// What the candidates add to the interpolation.
  struct Contribution {
    double field = 0, learned = 0; // shares
    double gain = 0;               // dB over interpolation alone, on the slices used for the choice
    std::string nothingLearned;    // a sentence
  };
  /// A step's part of the progress, by its cost relative to all that is left (PredictionPlan.h).
  struct Part {
    double from = 0, to = 0;
  };
  /// The next step's part. expected: the cost that was planned for it; cost: what it turned out to be.
  Part step(double expected, double cost);
  void report(double fraction);
  bool triesAField() const { return parts_.field && triesField(settings_, voxels_); }
  void interpolate(const Stack& stack, std::span<const float> complete, const GridGeometry& grid,
                   std::span<float> planes) const;
  void anchor(Volume& guess, const Stack& scan) const;
  Candidates makeCandidates(const Stack& scan, const GridGeometry& grid, bool withField, bool withLearned,
                            bool trial, Part fieldPart, Part learnedPart);
  Stack withoutGaps(Stack filled, const std::array<std::span<const float>, 3>& guesses);
  Contribution addCandidates(Volume& between);

  const PreparedInput& prepared_;
  const Stack& scan_;
  const Settings settings_;
  const PredictionParts parts_;
  const double noise_;
  const FieldFit fitField_;
  JobProgress& progress_;
  ThreadPool& pool_;
  PredictionCost cost_;
  std::array<std::vector<std::size_t>, 2> missing_; // missingVoxels() of both parities
  double filling_ = 0;                              // cost of withoutGaps()
  double progressed_ = 0, costLeft_ = 0; // progress up to the next step; cost of it and all later ones
  CandidateChoice choice_;
  bool fused_ = true; // PredictionOptions::fused
  bool keepsField_ = false;
  std::optional<Volume> field_; // takeField()
  double voxels_ = 0;           // of the prediction
  bool littleToLearn_ = false;  // the trial's network hardly improved on its linear filter
  double muchToLearn_ = 0;      // 0…1: how much it improved on it
  std::string sentence_;
};

} // namespace innergs
