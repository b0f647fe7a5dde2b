#include "Core/Settings.h"

#include "Core/Error.h"

#include <cmath>

namespace innergs {

void checkSettings(const Settings& s) {
  const auto require = [](bool ok, const std::string& sentence) {
    if (!ok) throw Error(ErrorCode::InvalidArgument, sentence);
  };
  require(!s.gaussians || *s.gaussians > 0, "The number of Gaussians must be at least 1.");
  require(!s.gaussians || *s.gaussians <= 1'000'000'000,
          "The number of Gaussians must be at most 1,000,000,000.");
  require(!s.iterations || (*s.iterations > 0 && *s.iterations <= 1'000'000),
          "The number of iterations must be between 1 and 1,000,000.");
  require(!s.members || (*s.members > 0 && *s.members <= 64),
          "The number of members must be between 1 and 64.");
  require(!(s.members && *s.members > 1 && s.blending == Blending::Additive),
          "Additive fields cannot be merged: use one member.");
  require(std::isfinite(s.huberDelta) && s.huberDelta > 0, "The Huber loss needs a positive delta.");
  require(std::isfinite(s.ssimWeight) && s.ssimWeight >= 0, "The weight of 1 − SSIM must not be negative.");
  require(s.threads >= 0 && s.threads <= 4096,
          "The number of threads must be between 0 (all cores) and 4096.");
  require(!(s.blending == Blending::Additive && s.linearIntensity.value_or(false)),
          "Additive blending has no linear intensity: leave one of the two out.");
}

} // namespace innergs
