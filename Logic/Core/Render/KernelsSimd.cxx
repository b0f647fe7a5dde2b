#include "Core/Base/InstructionSets.h"
#include "Core/Render/KernelsScalar.h"

// The code stores vectors in members and array elements, which sizeless types do not allow.
#define HWY_DISABLED_TARGETS (HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "Core/Render/KernelsSimd.cxx"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// after foreach_target.h
#include "Core/Render/SimdAlpha-inl.h"
#include "Core/Render/SimdField-inl.h"

#include <array>

HWY_BEFORE_NAMESPACE();
namespace innergs::HWY_NAMESPACE {

KernelSet kernels(Selection selection) {
  const char* name = hwy::TargetName(HWY_TARGET);
  const auto set = [&]<Selection s>() {
    return KernelSet{name, s, accumulate<s>, gather<s>, composite<s>, compositeBackward<s>};
  };
  return selection == Selection::Exact     ? set.template operator()<Selection::Exact>()
         : selection == Selection::Method1 ? set.template operator()<Selection::Method1>()
                                           : set.template operator()<Selection::Method2>();
}

} // namespace innergs::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace innergs {
HWY_EXPORT(kernels);

namespace {

std::vector<KernelSet> find(Selection selection) {
  std::vector<KernelSet> found;
  forEachInstructionSet(hwy::SupportedAndGeneratedTargets(),
                        [&] { found.push_back(HWY_DYNAMIC_DISPATCH(kernels)(selection)); });
  found.push_back(scalarKernels(selection));
  return found;
}

} // namespace

const std::vector<KernelSet>& kernelSets(Selection selection) {
  static const std::array<std::vector<KernelSet>, 3> sets{find(Selection::Exact), find(Selection::Method1),
                                                          find(Selection::Method2)};
  return sets[static_cast<std::size_t>(selection)];
}

const KernelSet& kernelSet(const std::string& name, Selection selection) {
  return kernelsOf(kernelSets(selection), name);
}

} // namespace innergs
#endif
