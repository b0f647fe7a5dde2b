#pragma once
#include <cstdint>
#include <functional>
#include <vector>

namespace innergs {

/// Calls visit() once for each of Highway's `targets`, with dynamic dispatch restricted to it. That choice is
/// process-wide, so only one visit runs at a time.
void forEachInstructionSet(const std::vector<std::int64_t>& targets, const std::function<void()>& visit);

} // namespace innergs
