#include "CLI/ReconstructReport.h"

#include "CLI/Platform.h"
#include "CLI/Version.h"

#include "Core/Acquisition/SliceOrder.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Job/FoundSlices.h"

#include <itkVersion.h>
#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace innergs::cli {
namespace {

using Json = nlohmann::ordered_json;

const char* name(SliceProfile profile) {
  return std::array{"point", "box", "gaussian"}.at(static_cast<std::size_t>(profile));
}

const char* name(Judging judging) {
  return std::array{"not asked", "done", "stopped", "failed"}.at(static_cast<std::size_t>(judging));
}

/// Null where it is not finite.
Json known(double value) {
  return std::isfinite(value) ? Json(value) : Json();
}

/// The rows of its 3×4 matrix.
Json matrixOf(const Affine3& map) {
  Json matrix = Json::array();
  for (int row = 0; row < 3; ++row)
    matrix.push_back({map.linear[row][0], map.linear[row][1], map.linear[row][2], map.offset[row]});
  return matrix;
}

/// Null if slice motion was not estimated.
Json slicesOf(const ReconstructionResult& result) {
  const SliceMotion& motion = result.sliceMotion;
  if (motion.slices.empty()) return {};
  Json slices = Json::array();
  for (const auto& [scan, slice, pose, place] : foundSlices(result))
    slices.push_back({{"scan", scan + 1},
                      {"slice", slice},
                      {"weight", pose.weight},
                      {"gain", pose.gain},
                      {"displacement_mm", pose.displacement},
                      {"angle_degrees", pose.angle},
                      {"residual", known(pose.residual)},
                      {"matrix_lps", matrixOf(place)}});
  return {{"moved", motion.moved},
          {"psnr_to_others_db", known(motion.psnrAfter)},
          {"psnr_to_others_before_db", known(motion.psnrBefore)},
          {"median_displacement_mm", known(motion.displacement)},
          {"median_angle_degrees", known(motion.angle)},
          {"left_out", motion.rejected},
          {"slices", slices}};
}

/// The alignment of each scan: LPS mm, degrees, dB.
Json alignmentOf(const ReconstructionResult& result) {
  Json scans = Json::array();
  for (const StackAlignment& a : result.alignment)
    scans.push_back({{"fits", a.fits},
                     {"displacement_mm", a.displacement},
                     {"angle_degrees", a.angle},
                     {"gain", a.gain},
                     {"matrix_lps", matrixOf(a.toOthers)},
                     {"correlation", known(a.correlation)},
                     {"psnr_to_others_db", known(a.psnrAfter)},
                     {"psnr_to_others_before_db", known(a.psnrBefore)}});
  return scans;
}

/// How well each scan agrees with the others before the fit, and with the result after it.
Json agreementsIn(const ReconstructionResult& result) {
  if (result.agreement.size() < 2) return {};
  Json scans = Json::array();
  for (const StackAgreement& a : result.agreement)
    scans.push_back({{"fits", a.fits},
                     {"correlation", known(a.correlation)},
                     {"psnr_to_others_db", known(a.psnr)},
                     {"fitted_psnr_db", known(a.fittedPsnr)}});
  return {{"scans", scans}, {"statement", agreementSentence(result.agreement)}};
}

/// The range of each scan's shading against the others, and of what all share; dB between the scans.
Json shadingOf(const ReconstructionResult& result) {
  const BiasCorrection& bias = result.bias;
  Json scans = Json::array();
  for (const BiasCorrection::Scan& scan : bias.scans)
    scans.push_back({{"lowest", scan.lowest}, {"highest", scan.highest}});
  return {{"scans", scans},
          {"shared", {{"lowest", bias.sharedLowest}, {"highest", bias.sharedHighest}}},
          {"psnr_between_db", known(bias.psnrAfter)},
          {"psnr_between_before_db", known(bias.psnrBefore)}};
}

/// Null if it was not requested or could not be estimated.
Json uncertaintyOf(const ReconstructionResult& result) {
  if (!result.uncertainty) return {};
  const Uncertainty& u = *result.uncertainty;
  return {{"coverage_90_withheld_slices", known(u.coverage)},
          {"withheld_voxels", u.samples},
          {"noise", known(u.noise)},
          {"statement", uncertaintySentence(u)}};
}

} // namespace

Json toJson(const GridGeometry& geometry) {
  Json direction = Json::array();
  for (const auto& row : geometry.direction.m)
    direction.push_back(row);
  return {{"size", geometry.size},
          {"spacing_mm", geometry.spacing},
          {"origin_mm_lps", geometry.origin},
          {"direction_lps", direction}};
}

Json toJson(const Settings& settings, bool dynamic) {
  using Type = Setting::Type;
  Json json;
  for (const Setting& row : settingsTable()) {
    if (dynamic ? !concernsDynamicScans(row) : row.group == Setting::Group::Dynamic) continue;
    const std::string text = row.textIn(settings);
    const bool word = row.type() == Type::Choice || row.type() == Type::Text;
    json[row.name] = !row.isIn(settings) ? Json() : word ? Json(text) : Json::parse(text);
  }
  return json;
}

Json toJson(const DeviceUse& device) {
  return {{"asked", device.asked}, {"used", device.id}, {"name", device.name}, {"reason", device.reason}};
}

Json versions() {
  return {{"innergs", INNERGS_VERSION}, {"itk", itk::Version::GetITKVersion()}};
}

ScanRecord record(const std::string& file, const Stack& stack) {
  const auto& voxels = stack.image.voxels;
  const auto bad = std::count_if(voxels.begin(), voxels.end(), [](float v) { return !std::isfinite(v); });
  const double thickness = stack.thickness > 0 ? stack.thickness : stack.image.geometry.spacing[2];
  return {file,
          stack.image.geometry,
          thickness,
          stack.profile,
          bad,
          stack.thickness > 0 ? stack.thicknessFrom : "assumed: the distance between slices",
          sliceOrderText(stack.times)};
}

std::string qualitySentence(const ReconstructionResult& result) {
  const std::string fitted =
      std::isinf(result.trainingPsnr) ? "no error" : fmt::format("PSNR {:.2f} dB", result.trainingPsnr);
  if (result.judging == Judging::Done)
    return fmt::format("PSNR {:.2f} dB on {} held-out slice{}, from a second fit that did not see them; the "
                       "result is fitted to all slices ({} on these).",
                       result.heldOutPsnr, result.heldOutSlices, result.heldOutSlices == 1 ? "" : "s",
                       fitted);
  if (std::isnan(result.trainingPsnr)) return "No iteration was made: the quality is unknown.";
  return fmt::format("{} on the fitted samples themselves: it says how well the model reproduces the "
                     "scans, not how true the volume between them is (--held-out measures that).",
                     std::isinf(result.trainingPsnr) ? "No error" : fitted);
}

Json reconstructReport(const ReconstructOptions& options, const std::vector<ScanRecord>& scans,
                       const ReconstructionResult& result,
                       const std::vector<std::pair<std::string, double>>& phases) {
  Json inputs = Json::array();
  for (std::size_t n = 0; n < scans.size(); ++n) {
    const ScanRecord& scan = scans[n];
    Json entry{{"file", scan.file}};
    entry.update(toJson(scan.geometry));
    entry["thickness_mm"] = scan.thickness;
    entry["thickness_from"] = scan.thicknessFrom;
    entry["slice_order"] = scan.sliceOrder.empty() ? Json() : Json(scan.sliceOrder);
    entry["profile"] = name(scan.profile);
    if (n < result.profiles.scans.size()) {
      const ProfileEstimate& seen = result.profiles.scans[n];
      entry["estimated_thickness"] = {{"mm", seen.known ? Json(seen.thickness) : Json()},
                                      {"confidence", seen.confidence},
                                      {"statement", seen.sentence}};
    }
    entry["non_finite_voxels"] = scan.nonFiniteVoxels;
    inputs.push_back(entry);
  }
  const auto spent = [](double seconds) { return seconds > 0 ? Json(seconds) : Json(); };
  Json timings{{"total", result.seconds},
               {"fit", spent(result.fitSeconds)},
               {"judging", spent(result.judgingSeconds)}};
  for (const auto& [phase, seconds] : phases)
    timings["phases"][phase] = seconds;
  const auto file = [](const std::string& path) { return path.empty() ? Json() : Json(path); };
  Json settings = toJson(result.settings);
  settings["instructionSet"] = result.instructionSet;
  settings["threads"] = result.threads;
  return {{"date", utcTime()},
          {"versions", versions()},
          {"interrupted", result.cancelled},
          {"inputs", inputs},
          {"mask", options.masks.size() > 1 ? Json(options.masks)
                                            : file(options.masks.empty() ? "" : options.masks.front())},
          {"resumed_from", file(options.resume)},
          {"settings", settings},
          {"device", toJson(result.device)},
          {"output",
           {{"volume", file(options.output)},
            {"model", file(options.saveModel)},
            {"ply", file(options.ply)},
            {"slices", file(options.slices)},
            {"transforms", file(options.transforms)},
            {"uncertainty", file(options.uncertainty)},
            {"measured", file(options.measured)},
            {"grid", result.volume.voxels.empty() ? Json() : toJson(result.volume.geometry)}}},
          {"quality",
           {{"held_out_fraction", options.heldOut},
            {"judging", name(result.judging)},
            {"held_out_slices", result.judging == Judging::Done ? Json(result.heldOutSlices) : Json()},
            {"held_out_psnr_db", known(result.heldOutPsnr)},
            {"fitted_psnr_db", known(result.trainingPsnr)},
            {"statement", qualitySentence(result)}}},
          {"uncertainty", uncertaintyOf(result)},
          {"gaussians", result.model ? result.model->field.size() : 0},
          {"densified",
           {{"pruned", result.densified.pruned},
            {"split", result.densified.split},
            {"cloned", result.densified.cloned}}},
          {"iterations", result.iterations},
          {"agreement", agreementsIn(result)},
          {"alignment", alignmentOf(result)},
          {"shading", shadingOf(result)},
          {"slice_motion", slicesOf(result)},
          {"prediction", result.prediction.empty() ? Json() : Json(result.prediction)},
          {"profiles", result.profiles.sentence.empty() ? Json() : Json(result.profiles.sentence)},
          {"noise", known(result.noise)},
          {"non_finite_voxels", result.nonFiniteVoxels},
          {"seconds", timings},
          {"peak_memory_bytes", peakMemory() > 0 ? Json(peakMemory()) : Json()},
          {"warnings", result.warnings}};
}

} // namespace innergs::cli
