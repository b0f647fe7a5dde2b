#include "Core/Base/InstructionSets.h"
#include "Core/Prediction/NetworkKernels.h"

// The code stores vectors in array elements, which sizeless types do not allow.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Core/Prediction/NetworkKernelsSimd.cxx"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// after foreach_target.h
#include "Core/Prediction/SimdLayers-inl.h"
#include "Core/Prediction/SimdMatrix-inl.h"
#include "Core/Prediction/SimdTiles-inl.h"

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {

NetworkKernels simdNetworkKernels() {
  return {hwy::TargetName(HWY_TARGET),
          multiply,
          inputToPoints,
          outputOfPoints,
          gradientToPoints,
          activate,
          activateBack,
          addSums,
          adam};
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace innergs {
HWY_EXPORT(simdNetworkKernels);

namespace {

std::vector<NetworkKernels> findNetworkKernels() {
  std::vector<NetworkKernels> found;
  forEachInstructionSet(hwy::SupportedAndGeneratedTargets(),
                        [&] { found.push_back(HWY_DYNAMIC_DISPATCH(simdNetworkKernels)()); });
  found.push_back(scalarNetworkKernels());
  return found;
}

} // namespace

const std::vector<NetworkKernels>& networkKernelSets() {
  static const std::vector<NetworkKernels> sets = findNetworkKernels();
  return sets;
}

const NetworkKernels& networkKernels(const std::string& name) {
  return kernelsOf(networkKernelSets(), name);
}

} // namespace innergs
#endif
