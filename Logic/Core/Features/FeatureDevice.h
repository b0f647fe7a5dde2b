#pragma once
#include "Core/Features/FeatureRows.h"
#include "Core/Features/FeatureStep.h"
#include "Core/Features/LabelCompletion.h"
#include "Core/Features/SupportLists.h"

#include <span>
#include <vector>

namespace innergs {

/// What the iterations of trainFeatures() work on; it outlives the device that is made for it.
struct FeatureProblem {
  int channels = 16;
  std::span<const float> latents, codes; // as in FeatureModel, at the start
  const FeatureRows* rows = nullptr;
  const SupportLists* lists = nullptr; // the classes of a block
  std::vector<float> ranks;            // per row: the image there
  std::vector<SoftLabel> labels;       // per row: the target
  std::vector<std::int64_t> blocks;    // per row: where its classes are listed
};

/// The iterations of trainFeatures() on a device. Throws Error(Memory) if device memory runs out.
class FeatureDevice {
public:
  virtual ~FeatureDevice() = default;
  virtual void step(const FeatureStep& step) = 0;
  virtual void download(std::span<float> latents, std::span<float> codes) = 0;
};

} // namespace innergs
