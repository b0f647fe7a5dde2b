#include "Evaluation/Report.h"

#include "Core/Base/NumberText.h"
#include "Core/Base/Quantities.h"

#include <algorithm>
#include <nlohmann/json.hpp>

namespace innergs {
namespace {

std::vector<const EvaluationReport*> heldOutFirst(std::span<const EvaluationReport> reports) {
  std::vector<const EvaluationReport*> order;
  for (const EvaluationReport& report : reports)
    order.push_back(&report);
  std::stable_partition(order.begin(), order.end(),
                        [](const EvaluationReport* report) { return report->protocol == "held-out"; });
  return order;
}

std::string number(int digits, double value) {
  if (!std::isfinite(value)) return std::isnan(value) ? "n/a" : "inf";
  return formatted("%.*f", digits, value);
}

std::string paddedCell(const std::string& text, std::size_t width, bool left = false) {
  const std::string space(text.size() < width ? width - text.size() : 0, ' ');
  return left ? text + space : space + text;
}

std::string quoted(const std::string& text) {
  std::string result = "\"";
  for (char c : text)
    result += c == '"' ? std::string("\"\"") : std::string(1, c);
  return result + "\"";
}

nlohmann::ordered_json toJson(const PoseErrors& errors) {
  const auto spread = [](const PoseErrors::Spread& s) {
    return nlohmann::ordered_json{{"median", s.median}, {"percentile_90", s.ninetieth}, {"worst", s.worst}};
  };
  return {{"mm", spread(errors.millimetres)},
          {"degrees", spread(errors.degrees)},
          {"slices", errors.slices},
          {"common_mm", errors.commonMillimetres},
          {"common_degrees", errors.commonDegrees}};
}

nlohmann::ordered_json toJson(const EvaluationReport& report) {
  nlohmann::ordered_json methods = nlohmann::ordered_json::object();
  for (const MethodScore& method : report.methods) {
    nlohmann::ordered_json entry;
    entry["psnr"] = method.psnr;
    entry["ssim"] = method.ssim;
    entry["seconds"] = method.seconds;
    if (method.cpuSeconds > 0) entry["cpu_seconds"] = method.cpuSeconds;
    if (method.peakMemory > 0) entry["peak_memory_bytes"] = method.peakMemory;
    entry["pooled_psnr"] = method.pooledPsnr;
    if (method.ncc) entry["ncc"] = *method.ncc;
    if (method.poses) entry["pose_errors"] = toJson(*method.poses);
    if (method.bias)
      entry["bias_errors"] = {{"between", method.bias->between}, {"shared", method.bias->shared}};
    if (method.intervals)
      entry["uncertainty"] = {{"coverage_90", method.intervals->coverage},
                              {"coverage_90_withheld_slices", method.intervals->own},
                              {"median_deviation", method.intervals->width}};
    entry["per_plane"] = nlohmann::ordered_json::object();
    for (const PlaneScore& plane : method.perPlane)
      entry["per_plane"][planeName(plane.plane)] = {{"psnr", plane.psnr},
                                                    {"ssim", plane.ssim},
                                                    {"pooled_psnr", plane.pooledPsnr},
                                                    {"slices", plane.slices}};
    methods[method.name] = std::move(entry);
  }
  return {{"protocol", report.protocol}, {"case", report.caseName}, {"samples", report.samples},
          {"range", report.range},       {"peak", report.peak},     {"voxels", report.voxels},
          {"methods", methods},          {"notes", report.notes}};
}

} // namespace

std::string textReport(std::span<const EvaluationReport> reports) {
  std::string text;
  for (const EvaluationReport* report : heldOutFirst(reports)) {
    if (!text.empty()) text += "\n";
    const bool paper = report->protocol == "paper";
    text += paper                          ? "Protocol P (paper), "
            : report->protocol == "stacks" ? "Simulated stacks, "
            : report->protocol == "scans"  ? "Held-out slices of real scans, "
                                           : "Protocol H (held-out), ";
    text += report->caseName + "\n";
    text += "Samples: " + report->samples + "\n" + report->range + "\n";
    text += paddedCell("method", 16, true) + paddedCell("PSNR dB", 9) + paddedCell("SSIM", 9) +
            paddedCell("seconds", 10);
    if (report->protocol == "scans") text += paddedCell("NCC", 8);
    if (paper) {
      text += paddedCell("pooled dB", 11);
      for (Plane plane : {Plane::Axial, Plane::Coronal, Plane::Sagittal})
        text += paddedCell(std::string(planeName(plane)) + " dB / SSIM", 24);
    }
    text += "\n";
    for (const MethodScore& method : report->methods) {
      text += paddedCell(method.name, 16, true) + paddedCell(number(2, method.psnr), 9) +
              paddedCell(number(4, method.ssim), 9) + paddedCell(number(2, method.seconds), 10);
      if (method.ncc) text += paddedCell(number(4, *method.ncc), 8);
      if (paper) text += paddedCell(number(2, method.pooledPsnr), 11);
      for (const PlaneScore& plane : method.perPlane)
        text += paddedCell(number(2, plane.psnr) + " / " + number(4, plane.ssim), 24);
      text += "\n";
    }
    for (const MethodScore& method : report->methods)
      if (method.poses) {
        const PoseErrors& e = *method.poses;
        text += formatted(
            "Poses of %s: median %.2f mm %.2f°, 90th percentile %.2f mm %.2f°, worst %.2f mm %.2f° over "
            "%lld slices, after %.2f mm %.2f° common to all.\n",
            method.name.c_str(), e.millimetres.median, e.degrees.median, e.millimetres.ninetieth,
            e.degrees.ninetieth, e.millimetres.worst, e.degrees.worst, static_cast<long long>(e.slices),
            e.commonMillimetres, e.commonDegrees);
      }
    for (const MethodScore& method : report->methods)
      if (method.bias)
        text += formatted("Shading left by %s: %.1f %% between the stacks, %.1f %% shared by all.\n",
                          method.name.c_str(), 100 * method.bias->between, 100 * method.bias->shared);
    for (const MethodScore& method : report->methods)
      if (method.intervals)
        text += formatted(
            "Uncertainty of %s: its 90 %% intervals held %.1f %% of these samples (%.1f %% of its own "
            "held-out slices); median standard deviation %.3g.\n",
            method.name.c_str(), 100 * method.intervals->coverage, 100 * method.intervals->own,
            method.intervals->width);
    if (!report->methods.empty() && report->methods.front().peakMemory > 0)
      text += formatted("Memory: %s at most until %s was done.\n",
                        bytesText(static_cast<double>(report->methods.front().peakMemory)).c_str(),
                        report->methods.front().name.c_str());
    for (const std::string& note : report->notes)
      text += "Note: " + note + "\n";
  }
  return text;
}

std::string csvReport(std::span<const EvaluationReport> reports) {
  std::string text = "protocol,case,method,plane,psnr,ssim,pooled_psnr,seconds,voxels,samples\n";
  for (const EvaluationReport* report : heldOutFirst(reports))
    for (const MethodScore& method : report->methods) {
      const auto row = [&](const char* plane, double psnr, double ssim, double pooled) {
        text += report->protocol + "," + report->caseName + "," + method.name + "," + plane + "," +
                number(4, psnr) + "," + number(6, ssim) + "," + number(4, pooled) + "," +
                number(3, method.seconds) + "," + std::to_string(report->voxels) + "," +
                quoted(report->samples) + "\n";
      };
      row("all", method.psnr, method.ssim, method.pooledPsnr);
      for (const PlaneScore& plane : method.perPlane)
        row(planeName(plane.plane), plane.psnr, plane.ssim, plane.pooledPsnr);
    }
  return text;
}

std::string jsonReport(std::span<const EvaluationReport> reports) {
  if (reports.size() == 1) return toJson(reports[0]).dump(2) + "\n";
  auto all = nlohmann::ordered_json::array();
  for (const EvaluationReport* report : heldOutFirst(reports))
    all.push_back(toJson(*report));
  return all.dump(2) + "\n";
}

} // namespace innergs
