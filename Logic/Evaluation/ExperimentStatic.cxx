#include "Evaluation/ExperimentStatic.h"

#include "Evaluation/PaperProtocol.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

/// The paper's row for BrainWeb T1, on an RTX 4070.
constexpr double kPaperPsnr[3] = {32.48, 31.86, 33.08}, kPaperMean = 32.47, kPaperSsim = 0.9676,
                 kPaperSeconds = 25.9 * 60;

const char* const kHeldP = "held-out slices (P)";
const char* const kHeldH = "held-out slices (H)";

std::vector<std::pair<std::string, Settings>> variants(const ExperimentFits& fits) {
  Settings alpha = fits.base(), additive = fits.base();
  alpha.blending = Blending::Alpha;
  additive.blending = Blending::Additive;
  return {{"alpha, the paper's training", fits.paper()},
          {"alpha", alpha},
          {"additive", additive},
          {"normalised", fits.base()}};
}

std::string megabytes(const FitOutcome& fit) {
  return decimals(static_cast<double>(fit.memory) / 1e6, 0);
}

void addPerPlane(ExperimentTable& table, const std::string& label, const MethodScore& score,
                 const FitOutcome* fit) {
  const auto row = [&](const std::string& plane, double psnr, double ssim, const std::string& paperPsnr,
                       const std::string& paperSsim, bool whole) {
    table.add({label, plane, fit ? std::to_string(fit->count) : "", decimals(psnr, 2), paperPsnr,
               decimals(ssim, 4), paperSsim, whole ? decimals(score.seconds, 1) : "",
               whole && fit ? decimals(kPaperSeconds, 0) : "", whole && fit ? megabytes(*fit) : "", kHeldP});
  };
  for (const PlaneScore& plane : score.perPlane)
    row(planeName(plane.plane), plane.psnr, plane.ssim,
        fit ? decimals(kPaperPsnr[static_cast<int>(plane.plane)], 2) : "", "", false);
  row("average", score.psnr, score.ssim, fit ? decimals(kPaperMean, 2) : "",
      fit ? decimals(kPaperSsim, 4) : "", true);
}

} // namespace

StaticExperiment runStatic(ExperimentFits& fits) {
  const ExperimentSetup& setup = fits.setup();
  StaticExperiment result;
  result.perPlane.name = "static";
  result.perPlane.title = "Static reconstruction of " + setup.volumeName + ", protocol P, " +
                          std::to_string(setup.gaussians) + " Gaussians at the start";
  result.perPlane.columns = {"method",     "plane",      "gaussians", "psnr_db",       "paper_psnr_db",
                             "ssim",       "paper_ssim", "seconds",   "paper_seconds", "estimated_memory_mb",
                             "measured_on"};
  result.held.name = "static-held-out";
  result.held.title = "The same blendings by protocol H: every 4th axial slice of " + setup.volumeName +
                      " kept, all others held out in every plane";
  result.held.columns = {"method",  "gaussians",           "psnr_db",    "paper_psnr_db", "ssim",
                         "seconds", "estimated_memory_mb", "measured_on"};

  for (const auto& [label, settings] : variants(fits)) {
    Settings free = settings; // protocol H: the program chooses the number of Gaussians
    if (!setup.quick && free.preset != Preset::Paper) free.gaussians.reset();
    result.rows.push_back(
        {label, &fits.run(label, settings, false, true), &fits.run(label, free, true, false)});
    const auto& row = result.rows.back();
    addPerPlane(result.perPlane, label, row.paper->gaussians, row.paper);
    result.held.add({label, std::to_string(row.heldOut->count), decimals(row.heldOut->gaussians.psnr, 2), "",
                     decimals(row.heldOut->gaussians.ssim, 4), decimals(row.heldOut->gaussians.seconds, 1),
                     megabytes(*row.heldOut), kHeldH});
  }
  const auto& last = result.rows.back();
  for (const MethodScore& method : last.paper->report.methods)
    if (method.name != "gaussians") addPerPlane(result.perPlane, method.name, method, nullptr);
  for (const MethodScore& method : last.heldOut->report.methods)
    if (method.name != "gaussians")
      result.held.add({method.name, "", decimals(method.psnr, 2), "", decimals(method.ssim, 4),
                       decimals(method.seconds, 1), "", kHeldH});

  const EvaluationReport& report = last.paper->report;
  result.perPlane.notes = {"Measured on " + report.samples, report.range};
  for (const auto& row : result.rows)
    for (const std::string& note : row.paper->report.notes)
      if (std::find(result.perPlane.notes.begin(), result.perPlane.notes.end(), note) ==
          result.perPlane.notes.end())
        result.perPlane.notes.push_back(note);
  result.perPlane.notes.push_back("Memory is estimated before the start, without the input. The paper's time "
                                  "is for an RTX 4070, ours for this machine's processor.");
  notePapersFigures(setup, result.perPlane);
  result.held.notes = {"Measured on " + last.heldOut->report.samples, last.heldOut->report.range,
                       "The paper has no figures for this protocol."};

  const EvaluationInput input =
      paperInput(setup.volume, EvaluationOptions{}.heldOutFraction, fits.base().seed);
  result.truth = input.truth;
  result.peak = report.peak;
  const std::int64_t middle = result.truth.geometry.size[2] / 2;
  const auto& candidates = input.scored[2].empty() ? input.heldOut[2] : input.scored[2];
  result.slice = candidates.front();
  for (const std::int64_t k : candidates)
    if (std::abs(k - middle) < std::abs(result.slice - middle)) result.slice = k;
  return result;
}

} // namespace innergs
