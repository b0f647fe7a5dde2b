#include "Evaluation/ExperimentFits.h"

#include "Core/Fit/Plan.h"
#include "Core/Image/Region.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Job/Resume.h"
#include "Evaluation/EvaluationRuns.h"
#include "Evaluation/HeldOutProtocol.h"
#include "Evaluation/PaperProtocol.h"

#include <algorithm>
#include <cctype>
#include <cmath>

namespace innergs {
namespace {

const HeldOutCase kEveryFourth{HeldOutCase::Kind::KeepEvery, 4, 2, 0};
// Densification runs between the 8 coarse iterations and the middle of the fit.
constexpr int kQuickIterations = 24, kQuickDensifyEvery = 3;
constexpr std::int64_t kQuickGaussians = 1500;

} // namespace

bool isPapersVolume(const std::string& fileName, const Volume& volume) {
  std::string name = fileName;
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  std::array<std::int64_t, 3> size = volume.geometry.size;
  std::sort(size.begin(), size.end());
  return name.find("brainweb") != std::string::npos && name.find("t1") != std::string::npos &&
         size == std::array<std::int64_t, 3>{145, 145, 174};
}

void notePapersFigures(const ExperimentSetup& setup, ExperimentTable& table) {
  if (!setup.papersVolume)
    table.notes.push_back("The paper's figures are for BrainWeb T1, 145x174x145, not for this volume: they "
                          "are not comparable.");
  if (setup.gaussians != kPaperGaussians)
    table.notes.push_back("The paper's figures are for " + std::to_string(kPaperGaussians) +
                          " Gaussians at the start, not for " + std::to_string(setup.gaussians) +
                          ": they are not comparable.");
}

Volume centralCrop(const Volume& volume, std::int64_t size) {
  const auto& n = volume.geometry.size;
  std::array<std::int64_t, 3> first{}, extent = n;
  for (int a = 0; a < 3; ++a) {
    extent[a] = std::min(n[a], size);
    first[a] = (n[a] - extent[a]) / 2;
  }
  return cropped(volume, IndexBlock{first, extent});
}

ExperimentFits::ExperimentFits(ExperimentSetup setup) : setup_(std::move(setup)) {
  if (setup_.quick) setup_.gaussians = std::min(setup_.gaussians, kQuickGaussians);
  checkSettings(base());
}

Settings ExperimentFits::base() const {
  Settings settings = setup_.settings;
  settings.preset = Preset::Balanced;
  settings.gaussians = setup_.gaussians;
  if (setup_.quick) settings.iterations = kQuickIterations;
  return settings;
}

Settings ExperimentFits::paper(int iterations) const {
  Settings settings = base();
  settings.preset = Preset::Paper;
  settings.iterations = setup_.quick ? kQuickIterations : iterations;
  densify(settings);
  return settings;
}

void ExperimentFits::densify(Settings& settings) const {
  if (setup_.quick) settings.densifyEvery = kQuickDensifyEvery;
}

const FitOutcome& ExperimentFits::run(const std::string& label, const Settings& settings, bool heldOut,
                                      bool keep) {
  EvaluationOptions options;
  const bool alpha = chosenBlending(settings) == Blending::Alpha;
  const EvaluationInput input =
      heldOut ? heldOutInput(setup_.volume, kEveryFourth, settings.seed)
              : paperInput(setup_.volume, options.heldOutFraction, settings.seed, alpha);
  const IntensityMap map = chooseIntensityMap(input.stacks);
  Settings filled = settings;
  const int coarse = makePlan(filled, measureTraits(input.stacks, map)).coarseIterations;
  const std::string key = settingsKey(filled, heldOut ? "H" : "P");
  for (const auto& [name, outcome] : done_)
    if (name == key && (!keep || outcome.gaussians.volume)) return outcome;
  if (setup_.say) setup_.say(std::string(heldOut ? "Protocol H: " : "Protocol P: ") + label);

  FitOutcome outcome;
  options.settings = settings;
  options.keepVolumes = keep;
  options.stop = setup_.stop;
  const double shift = 20 * std::log10(intensityRange(input.truth) / map.scale);
  ReconstructionInput whole;
  whole.stacks = input.stacks;
  whole.outputGrid = input.truth.geometry;
  outcome.memory = estimateMemory(whole, heldOut ? settings : withoutResidualGrid(settings));
  whole = {};
  double rendering = 0; // since when
  options.progress = [&](const Progress& p) {
    if (p.phase == Phase::Rendering) rendering = p.elapsed;
    if (p.phase == Phase::Done) outcome.renderSeconds = p.elapsed - rendering;
    if (p.phase == Phase::Fitting && p.iteration > 0) {
      outcome.iterations = p.iteration;
      outcome.count = p.gaussians;
      const int ofMember = (p.iteration - 1) % std::max(1, *filled.iterations) + 1;
      if (ofMember > coarse && (outcome.curve.empty() || p.iteration > outcome.curve.back().iteration))
        outcome.curve.push_back({p.elapsed, p.iteration, p.trainingPsnr + shift});
    }
    if (setup_.progress) setup_.progress(p);
  };
  outcome.report =
      heldOut ? evaluateHeldOut(setup_.volume, kEveryFourth, options) : evaluatePaper(setup_.volume, options);
  outcome.densified = outcome.report.densified;
  for (const MethodScore& method : outcome.report.methods)
    if (method.name == "gaussians") outcome.gaussians = method;
  std::vector<double> gaps; // reports may be rarer than iterations, and coarse iterations start each member
  for (std::size_t n = 1; n < outcome.curve.size(); ++n)
    gaps.push_back((outcome.curve[n].seconds - outcome.curve[n - 1].seconds) /
                   (outcome.curve[n].iteration - outcome.curve[n - 1].iteration));
  if (!gaps.empty()) {
    std::nth_element(gaps.begin(), gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2), gaps.end());
    outcome.secondsPerIteration = gaps[gaps.size() / 2];
  }
  // Many fits are kept, so this drops the volumes that no picture shows.
  for (MethodScore& method : outcome.report.methods)
    method.volume.reset();
  outcome.report.truth.reset();
  outcome.report.input.reset();
  done_.emplace_back(key, std::move(outcome));
  return done_.back().second;
}

} // namespace innergs
