#include "Evaluation/ExperimentAblation.h"

#include "Core/Base/Error.h"

#include <algorithm>
#include <iterator>

namespace innergs {
namespace {

using Variants = std::vector<std::pair<std::string, Settings>>;

Settings with(Settings settings, const auto&... changes) {
  (changes(settings), ...);
  return settings;
}

constexpr auto grid = [](Settings& s) { s.initialisation = Initialisation::Grid; };
constexpr auto fixed = [](Settings& s) { s.relocate = false; };
constexpr auto alpha = [](Settings& s) { s.blending = Blending::Alpha; };
constexpr auto adam = [](double beta1, double beta2) {
  return [=](Settings& s) { s.beta1 = beta1, s.beta2 = beta2; };
};
constexpr auto plateau = [](Settings& s) { s.schedule = Schedule::Plateau; };
constexpr auto paperLoss = [](Settings& s) {
  s.loss = LossKind::L1;
  s.lossWeight = 0.8;
  s.ssimWeight = 0.4;
};

Variants blendings(const ExperimentFits& fits) {
  return {{"normalised", fits.base()},
          {"additive", with(fits.base(), [](Settings& s) { s.blending = Blending::Additive; })},
          {"alpha", with(fits.base(), alpha)},
          {"normalised, no slopes", with(fits.base(), [](Settings& s) { s.linearIntensity = false; })}};
}

Variants initialisations(const ExperimentFits& fits) {
  return {{"adaptive", fits.base()},
          {"even grid", with(fits.base(), grid, fixed)},
          {"alpha, adaptive", with(fits.base(), alpha)},
          {"alpha, even grid", with(fits.base(), alpha, grid, fixed)}};
}

/// Starts with half the Gaussians, with room for all of them.
void grow(Settings& s) {
  s.maxGaussians = s.gaussians;
  s.densify.gradient = 0.005; // L2 gradients are smaller than those of the default's loss
  s.gaussians = std::max<std::int64_t>(1, *s.gaussians / 2);
}

Variants densifications(const ExperimentFits& fits) {
  const auto early = [&](Settings& s) { fits.densify(s); };
  return {{"none (grid)", with(fits.base(), grid, fixed)},
          {"relocation (grid)", with(fits.base(), grid)},
          {"paper's, from half (grid)", with(fits.base(), grid, fixed, grow, early)},
          {"none (adaptive)", fits.base()},
          {"paper's, from half (adaptive)", with(fits.base(), grow, early)},
          {"alpha, none (grid)", with(fits.base(), alpha, grid, fixed)},
          {"alpha, paper's, from half (grid)", with(fits.base(), alpha, grid, fixed, grow, early)}};
}

Variants optimisers(const ExperimentFits& fits) {
  return {{"Adam .8/.95, exponential decay", fits.base()},
          {"Adam .9/.99", with(fits.base(), adam(0.9, 0.99))},
          {"Adam .9/.999", with(fits.base(), adam(0.9, 0.999))},
          {"plateau", with(fits.base(), plateau)},
          {"exponential, paper's loss", with(fits.base(), paperLoss)},
          {"paper's preset, normalised blending",
           with(fits.paper(200), [](Settings& s) { s.blending = Blending::Normalised; })},
          {"paper's preset (alpha)", fits.paper()}};
}

Variants counts(const ExperimentFits& fits) {
  Variants variants;
  auto full = std::vector<std::int64_t>{10'000, 20'000, 40'000, fits.setup().gaussians, 150'000, 300'000};
  std::sort(full.begin(), full.end());
  full.erase(std::unique(full.begin(), full.end()), full.end());
  const auto quick = std::vector<std::int64_t>{500, fits.setup().gaussians};
  for (const std::int64_t n : fits.setup().quick ? quick : full)
    variants.push_back({std::to_string(n), with(fits.base(), [n](Settings& s) { s.gaussians = n; })});
  return variants;
}

/// At the engine's own cut-off Method 2 covers every pixel; at the paper's cut-off it does not.
Variants selections(const ExperimentFits& fits) {
  constexpr int iterations = 40; // Method 1 is slow
  constexpr std::pair<Blending, double> groups[] = {
      {Blending::Normalised, 2.2}, {Blending::Normalised, 3}, {Blending::Alpha, 3}};
  Variants variants;
  for (const auto& [blending, cutoff] : groups)
    for (const Selection selection : {Selection::Exact, Selection::Method2, Selection::Method1}) {
      Settings settings = fits.base();
      settings.blending = blending;
      settings.cutoff = cutoff;
      settings.selection = selection;
      settings.iterations = std::min(iterations, settings.iterations.value_or(iterations));
      variants.push_back({std::string(blendingName(blending)) + ", " + decimals(cutoff, 1) + " sigma, " +
                              selectionName(selection),
                          settings});
    }
  return variants;
}

struct Kind {
  const char *name, *title;
  Variants (*variants)(const ExperimentFits&);
};
constexpr Kind kKinds[] = {{"blending", "Blending", blendings},
                           {"initialisation", "Initialisation", initialisations},
                           {"densification", "Densification", densifications},
                           {"optimiser", "Optimiser, schedule and loss", optimisers},
                           {"gaussians", "Number of Gaussians", counts},
                           {"selection", "Candidate selection", selections}};

const char* const kHeldP = "held-out slices (P)";

} // namespace

std::vector<std::string> ablationNames() {
  std::vector<std::string> names;
  for (const Kind& kind : kKinds)
    names.push_back(kind.name);
  return names;
}

Ablation runAblation(ExperimentFits& fits, const std::string& name) {
  const auto kind =
      std::find_if(std::begin(kKinds), std::end(kKinds), [&](const Kind& k) { return name == k.name; });
  if (kind == std::end(kKinds))
    throw Error(ErrorCode::InvalidArgument, "There is no ablation '" + name + "'.");
  Ablation result;
  result.name = name;
  result.title = kind->title;
  ExperimentTable& table = result.table;
  table.name = "ablation-" + name;
  table.title = std::string("Ablation: ") + kind->title + ", " + fits.setup().volumeName;
  table.columns = {"choice",     "gaussians", "iterations",   "psnr_db",   "paper_psnr_db",         "ssim",
                   "paper_ssim", "seconds",   "ms_iteration", "render_ms", "fitted_samples_psnr_db"};
  const bool densifies = name == "densification";
  if (densifies) table.columns.insert(table.columns.end(), {"pruned", "split", "cloned"});
  table.columns.push_back("measured_on");
  for (const auto& [label, settings] : kind->variants(fits)) {
    const FitOutcome& fit = fits.run(std::string(kind->title) + ": " + label, settings);
    result.rows.push_back({label, &fit});
    const bool papers = settings.preset == Preset::Paper && chosenBlending(settings) == Blending::Alpha;
    std::vector<std::string> row{label,
                                 std::to_string(fit.count),
                                 std::to_string(fit.iterations),
                                 decimals(fit.gaussians.psnr, 2),
                                 papers ? "32.47" : "",
                                 decimals(fit.gaussians.ssim, 4),
                                 papers ? "0.9676" : "",
                                 decimals(fit.gaussians.seconds, 1),
                                 decimals(1e3 * fit.secondsPerIteration, 1),
                                 decimals(1e3 * fit.renderSeconds, 1),
                                 fit.curve.empty() ? "" : decimals(fit.curve.back().psnr, 2)};
    if (densifies)
      for (const std::int64_t count : {fit.densified.pruned, fit.densified.split, fit.densified.cloned})
        row.push_back(std::to_string(count));
    row.push_back(kHeldP);
    table.add(std::move(row));
  }
  table.notes = {"PSNR and SSIM are measured on " + result.rows.front().fit->report.samples,
                 "Fitted samples: PSNR of the last iteration on what was fitted, not held out.",
                 "Unless the row says otherwise: preset balanced, " + std::to_string(fits.setup().gaussians) +
                     " Gaussians, normalised, adaptive start, no densification. The paper's figures are "
                     "shown for its own choices only."};
  if (name == "selection")
    table.notes.push_back("40 iterations, trained and rendered with the same selection; everything else is "
                          "the same within a cut-off and blending. Render ms is the time for the whole "
                          "volume, once. The paper measures its selections in the simulation only.");
  if (densifies)
    table.notes.push_back(
        "From half: the fit begins with half the Gaussians and may prune, split and clone "
        "up to the number of the others (gradient threshold 0.005, for L2). Pruned, split and cloned are "
        "counted over the whole fit.");
  if (std::any_of(table.rows.begin(), table.rows.end(), [](const auto& row) { return !row[4].empty(); }))
    notePapersFigures(fits.setup(), table);
  return result;
}

ExperimentTable curvesOf(const Ablation& ablation) {
  ExperimentTable table;
  table.name = "ablation-" + ablation.name + "-curves";
  table.title = ablation.title + ": PSNR over time";
  table.columns = {"choice", "iteration", "seconds", "psnr_db", "measured_on"};
  for (const auto& [label, fit] : ablation.rows) {
    for (const FitPoint& point : fit->curve)
      table.add({label, std::to_string(point.iteration), decimals(point.seconds, 3), decimals(point.psnr, 3),
                 "fitted samples (not held out)"});
    table.add({label, std::to_string(fit->iterations), decimals(fit->gaussians.seconds, 3),
               decimals(fit->gaussians.psnr, 3), kHeldP});
  }
  return table;
}

} // namespace innergs
