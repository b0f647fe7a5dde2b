#pragma once
#include "Evaluation/ExperimentTable.h"
#include "Evaluation/Protocols.h"

#include <deque>
#include <string>

namespace innergs {

constexpr std::int64_t kPaperGaussians = 42 * 42 * 42;

/// The input of an experiment that fits a volume.
struct ExperimentSetup {
  Volume volume;
  std::string volumeName;    // for titles
  bool papersVolume = false; // see isPapersVolume()
  bool quick = false;        // a small crop and few iterations: only shows that it runs
  std::int64_t gaussians = kPaperGaussians;
  Settings settings;                           // threads, seed, instruction set
  ProgressCallback progress;                   // for every fit
  std::function<void(const std::string&)> say; // called before each fit with its description
  std::stop_token stop;                        // when stopped, throws Error(Cancelled)
};

/// BrainWeb's T1 as the paper cropped it, recognised by file name and size: only then are its figures
/// comparable.
bool isPapersVolume(const std::string& fileName, const Volume& volume);

/// Adds a note if the paper's figures are for another volume or another number of Gaussians.
void notePapersFigures(const ExperimentSetup& setup, ExperimentTable& table);

/// The middle of a volume, at most `size` voxels along each axis.
Volume centralCrop(const Volume& volume, std::int64_t size);

struct FitPoint {
  double seconds = 0; // since the start, including preparation
  int iteration = 0;
  double psnr = 0; // dB on the fitted samples, peak from the truth's range; full-resolution iterations only
};

/// One evaluated fit with its history.
struct FitOutcome {
  EvaluationReport report;
  MethodScore gaussians; // the report's row for them
  std::vector<FitPoint> curve;
  int iterations = 0;
  std::int64_t count = 0;         // Gaussians at the end
  std::int64_t memory = 0;        // bytes, estimated before the start
  double secondsPerIteration = 0; // of full-resolution iterations
  double renderSeconds = 0;       // of the whole volume, once
  DensifyCounts densified;
};

/// Runs fits, each only once, however many tables show it.
class ExperimentFits {
public:
  explicit ExperimentFits(ExperimentSetup setup);
  const ExperimentSetup& setup() const { return setup_; }

  /// The settings to vary: preset balanced with the set-up's number of Gaussians.
  Settings base() const;
  /// The paper's preset: Algorithm 1. iterations: the maximum, before its stop rule.
  Settings paper(int iterations = 1000) const;
  /// For settings that densify: makes a quick fit densify early enough.
  void densify(Settings& settings) const;

  /// Runs protocol P, or protocol H keeping every 4th slice. `label`: for the progress. keep: keeps the
  /// Gaussians' volume and model. The reference lives as long as this object.
  const FitOutcome& run(const std::string& label, const Settings& settings, bool heldOut = false,
                        bool keep = false);

private:
  ExperimentSetup setup_;
  std::deque<std::pair<std::string, FitOutcome>> done_; // by settings and protocol
};

} // namespace innergs
