#include "Core/Settings/Settings.h"

#include "Core/Base/Error.h"
#include "Core/Settings/DeviceRequest.h"

#include <cmath>

namespace innergs {
namespace {

void require(bool ok, const std::string& sentence) {
  if (!ok) throw Error(ErrorCode::InvalidArgument, sentence);
}

bool atLeastZero(double x) {
  return std::isfinite(x) && x >= 0;
}

void checkBlending(const Settings& s) {
  const Blending blending = chosenBlending(s);
  if (blending == Blending::Normalised) return;
  const std::string name = blending == Blending::Additive ? "Additive" : "Alpha";
  require(s.ensembleSize.value_or(1) <= 1, name + " fields cannot be merged: use one member.");
  require(!s.linearIntensity.value_or(false),
          name + " blending has no linear intensity: leave one of the two out.");
}

bool insideUnit(double x) {
  return x > 0 && x < 1;
}

void checkSchedule(const Settings& s) {
  require(insideUnit(s.beta1.value_or(0.5)) && insideUnit(s.beta2.value_or(0.5)),
          "Adam's beta1 and beta2 must lie between 0 and 1.");
  require(s.plateau.patience >= 1 && s.plateau.patience <= 1'000'000,
          "The patience of the plateau schedule must be between 1 and 1,000,000 iterations.");
  require(s.plateau.factor > 0 && s.plateau.factor < 1,
          "The factor of the plateau schedule must lie between 0 and 1.");
  require(s.plateau.lowest > 0 && s.plateau.lowest <= 1,
          "The lowest share of the learning rates must be above 0 and at most 1.");
  require(atLeastZero(s.plateau.threshold) && s.plateau.threshold < 1,
          "The improvement that the plateau schedule counts must be at least 0 and below 1.");
}

void checkDensification(const Settings& s) {
  require(!s.densifyEvery || (*s.densifyEvery >= 0 && *s.densifyEvery <= 1'000'000),
          "The iterations between densifications must be between 0 (never) and 1,000,000.");
  require(!s.densify.opacity || (atLeastZero(*s.densify.opacity) && *s.densify.opacity < 1),
          "The opacity below which Gaussians are pruned must be at least 0 and below 1.");
  require(std::isfinite(s.densify.size) && s.densify.size > 0,
          "The size in voxels above which Gaussians are pruned must be positive.");
  require(atLeastZero(s.densify.gradient),
          "The gradient above which Gaussians are densified must not be negative.");
  require(atLeastZero(s.densify.split), "The size above which Gaussians are split must not be negative.");
  require(!s.maxGaussians || (*s.maxGaussians > 0 && *s.maxGaussians <= 1'000'000'000),
          "The largest number of Gaussians must be between 1 and 1,000,000,000.");
  require(!s.maxGaussians || !s.gaussians || *s.maxGaussians >= *s.gaussians,
          "The largest number of Gaussians must not be below the number at the start.");
}

} // namespace

Blending chosenBlending(const Settings& s) {
  return s.blending.value_or(s.preset == Preset::Paper ? Blending::Alpha : Blending::Normalised);
}

void checkSettings(const Settings& s) {
  require(!s.gaussians || *s.gaussians > 0, "The number of Gaussians must be at least 1.");
  require(!s.gaussians || *s.gaussians <= 1'000'000'000,
          "The number of Gaussians must be at most 1,000,000,000.");
  require(!s.iterations || (*s.iterations > 0 && *s.iterations <= 1'000'000),
          "The number of iterations must be between 1 and 1,000,000.");
  require(!s.ensembleSize || (*s.ensembleSize > 0 && *s.ensembleSize <= 64),
          "The number of members must be between 1 and 64.");
  require(!s.cutoff || (*s.cutoff >= 1 && *s.cutoff <= 5),
          "The cut-off radius must be between 1 and 5 standard deviations.");
  require(std::isfinite(s.huberDelta) && s.huberDelta > 0, "The Huber loss needs a positive delta.");
  require(!s.pointWeight || atLeastZero(*s.pointWeight), "The weight of the loss must not be negative.");
  require(!s.ssimWeight || atLeastZero(*s.ssimWeight), "The weight of 1 − SSIM must not be negative.");
  require(s.pointWeight.value_or(1) > 0 || s.ssimWeight.value_or(s.preset == Preset::Paper ? 0.4 : 0) > 0,
          "The loss and 1 − SSIM must not both have the weight 0.");
  require(s.threads >= 0 && s.threads <= 4096,
          "The number of threads must be between 0 (all cores) and 4096.");
  require(std::abs(s.fill) <= 1e30, "The value outside the mask must be a finite number.");
  parseDeviceRequest(s.device);
  checkBlending(s);
  checkSchedule(s);
  checkDensification(s);
}

} // namespace innergs
