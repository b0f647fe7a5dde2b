#include "Core/Base/InstructionSets.h"

#include <hwy/targets.h>
#include <mutex>

namespace innergs {

void forEachInstructionSet(const std::vector<std::int64_t>& targets, const std::function<void()>& visit) {
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
