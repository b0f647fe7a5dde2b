#pragma once
#include <nlohmann/json.hpp>
#include <string>

namespace innergs::bench {

/// The methods in a report of `innergs evaluate`; NaN for what it lacks.
class Scores {
public:
  explicit Scores(const nlohmann::json& report) : methods_(report.at("methods")) {}
  /// key: "psnr", or a path: "pose_errors/mm/median".
  double get(const std::string& method, const std::string& key) const;
  double psnr(const std::string& method) const { return get(method, "psnr"); }
  double best(std::initializer_list<const char*> methods, const std::string& key) const;
  std::string text(const std::string& method) const; // "31.25 / 0.8750", PSNR and SSIM; empty: not there

private:
  const nlohmann::json& methods_;
};

} // namespace innergs::bench
