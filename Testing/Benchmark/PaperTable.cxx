#include "Markdown.h"
#include "Tables.h"

#include <cmath>

namespace innergs::bench {
namespace {

constexpr const char* kHeldOut = "held-out slices of the three planes (protocol P)";
constexpr const char* kFitted = "fitted samples, pooled (monitor of the fit)";

/// Seconds until the fitted samples' PSNR reached `level`; NaN: never.
double timeTo(const nlohmann::json& run, double level) {
  for (const auto& point : run.at("fitted"))
    if (point.at(1).is_number() && point.at(1).get<double>() >= level) return point.at(0).get<double>();
  return NAN;
}

struct Targets {
  double psnr, ssim, seconds, megabytes, timeTo32; // 0: none
};

std::string atLeast(double target, int digits, const char* unit) {
  return target > 0 ? "≥ " + fixed(target, digits) + unit : "";
}
std::string atMost(double target, const char* unit) {
  return target > 0 ? "≤ " + fixed(target, 0) + unit : "";
}

void addRun(MarkdownTable& table, const std::string& name, const Outcome& outcome, const Targets& t) {
  if (!outcome.json) {
    table.add({name, "", "", outcome.missing});
    return;
  }
  const auto& run = *outcome.json;
  const auto& g = run.at("methods").at("gaussians");
  const auto value = [](const nlohmann::json& j) { return j.is_number() ? j.get<double>() : NAN; };
  const double psnr = value(g.at("psnr")), ssim = value(g.at("ssim")), seconds = value(g.at("seconds"));
  const auto high = [&](double x, double target, int digits, const char* unit) {
    return target > 0 ? verdict(x >= target, x - target, digits, unit) : "";
  };
  const auto low = [&](double x, double target, int digits, const char* unit) {
    return target > 0 ? verdict(x <= target, x - target, digits, unit) : "";
  };
  const double t32 = timeTo(run, 32.47);
  table.add({name, "time to 32.47 dB", kFitted, std::isnan(t32) ? "not reached" : fixed(t32, 1) + " s",
             atMost(t.timeTo32, " s"),
             t.timeTo32 > 0 && std::isnan(t32) ? "no" : low(t32, t.timeTo32, 1, "s")});
  std::string times;
  for (int level : {35, 38, 40, 42, 44})
    times += (times.empty() ? "" : ", ") + std::to_string(level) + " dB " +
             (std::isnan(timeTo(run, level)) ? "–" : fixed(timeTo(run, level), 1) + " s");
  table.add({name, "time to", kFitted, times});
  table.add({name, "PSNR, mean over slices", kHeldOut,
             fixed(psnr, 2) + " dB (pooled " + fixed(value(g.at("pooled_psnr")), 2) + ")",
             atLeast(t.psnr, 0, " dB"), high(psnr, t.psnr, 2, "dB")});
  table.add({name, "SSIM, mean over slices", kHeldOut, fixed(ssim, 4), atLeast(t.ssim, 3, ""),
             high(ssim, t.ssim, 4, "")});
  const double cores = value(run.at("cpu_seconds")) / seconds;
  table.add({name, "whole reconstruction",
             std::to_string(run.at("iterations").get<int>()) + " iterations and rendering",
             fixed(seconds, 1) + " s (" + fixed(cores, 2) + " cores busy)", atMost(t.seconds, " s"),
             low(seconds, t.seconds, 1, "s")});
  const auto& m = run.at("memory");
  const double megabytes = (value(m.at("peak")) - value(m.at("at_start")) - value(m.at("volume"))) / 1e6;
  table.add({name, "memory beyond the volume", "peak of the process, less start and volume",
             fixed(megabytes, 0) + " MB", atMost(t.megabytes, " MB"), low(megabytes, t.megabytes, 0, "MB")});
}

} // namespace

std::string paperTable(const PaperOutcomes& outcomes) {
  MarkdownTable table({"Gaussians", "what", "measured on", "result", "target", "met"});
  addRun(table, "74,088", outcomes.paperCount, {42, .982, 60, 250, 3});
  addRun(table, "300,000", outcomes.large, {45, 0, 90, 0, 0});
  if (const auto& r = outcomes.responsiveness; r.json) {
    const double preview = r.json->at("first_preview"), cancel = 1e3 * r.json->at("cancel").get<double>();
    table.add({"74,088", "first preview", "slowest of 3 runs", fixed(preview, 2) + " s", "≤ 2 s",
               verdict(preview <= 2, preview - 2, 2, "s")});
    table.add({"74,088", "cancel to return", "slowest of 3 runs", fixed(cancel, 0) + " ms", "≤ 200 ms",
               verdict(cancel <= 200, cancel - 200, 0, "ms")});
  } else {
    table.add({"74,088", "first preview, cancel", "", r.missing});
  }
  std::string text = table.text();
  if (outcomes.paperCount.json) {
    const auto& methods = outcomes.paperCount.json->at("methods");
    text += "\nOn the same held-out slices";
    for (const char* name : {"linear", "cubic", "lanczos"})
      if (methods.contains(name))
        text += std::string(name == std::string("linear") ? ": " : ", ") + name + " " +
                fixed(methods.at(name).at("psnr").get<double>(), 2) + " dB / " +
                fixed(methods.at(name).at("ssim").get<double>(), 4);
    text += ". Samples: " + outcomes.paperCount.json->value("samples", "") + "\n";
    for (const auto& note : outcomes.paperCount.json->at("notes"))
      text += note.get<std::string>() + "\n";
  }
  return text;
}

} // namespace innergs::bench
