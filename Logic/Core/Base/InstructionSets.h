#pragma once
#include "Core/Base/Error.h"

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace innergs {

/// Calls visit() once for each of the `targets` of Highway that this processor has, except those without
/// vectors, with dynamic dispatch restricted to it; the best comes first. That choice is process-wide, so
/// only one visit runs at a time.
void forEachInstructionSet(std::vector<std::int64_t> targets, const std::function<void()>& visit);

/// The entry of this `name`; the first one, which is the best, if it is empty. Throws Error(InvalidArgument)
/// for a name that is not among them.
template <class Kernels>
const Kernels& kernelsOf(const std::vector<Kernels>& sets, const std::string& name) {
  if (name.empty()) return sets.front();
  std::string known;
  for (const auto& set : sets) {
    if (set.name == name) return set;
    known += (known.empty() ? "" : ", ") + set.name;
  }
  throw Error(ErrorCode::InvalidArgument, "Instruction set '" + name +
                                              "' is not available on this processor; choose one of " + known +
                                              ".");
}

} // namespace innergs
