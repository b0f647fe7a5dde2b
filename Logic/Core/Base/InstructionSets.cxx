#include "Core/Base/InstructionSets.h"

#include <hwy/detect_targets.h>
#include <hwy/targets.h>
#include <mutex>

namespace innergs {

void forEachInstructionSet(std::vector<std::int64_t> targets, const std::function<void()>& visit) {
  std::erase_if(targets, [](std::int64_t t) { return t == HWY_SCALAR || t == HWY_EMU128; });
  static std::mutex mutex;
  std::lock_guard lock(mutex);
  for (const std::int64_t target : targets) {
    hwy::SetSupportedTargetsForTest(target);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    visit();
  }
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

} // namespace innergs
