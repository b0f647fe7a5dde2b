#pragma once
#include <cstdint>
#include <functional>
#include <vector>

namespace innergs {

/// Calls visit() with each of Highway's `targets` in turn as what its dynamic dispatch chooses. The choice is
/// the process's own: only one such visit runs at a time.
void forEachInstructionSet(const std::vector<std::int64_t>& targets, const std::function<void()>& visit);

} // namespace innergs
