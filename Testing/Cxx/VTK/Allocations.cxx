#include "Allocations.h"

#include <cstdlib>
#include <new>

namespace {

thread_local std::size_t allocated = 0;

} // namespace

namespace innergs::testing {

void resetLargeAllocations() {
  allocated = 0;
}

std::size_t largeAllocations() {
  return allocated;
}

} // namespace innergs::testing

// For the whole program, including shared libraries.
void* operator new(std::size_t size) {
  if (size >= std::size_t{1} << 16) allocated += size;
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
// By default this calls the other operator, but not under the sanitizers, which provide whatever is not
// defined here.
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  try {
    return operator new(size);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, const std::nothrow_t&) noexcept {
  std::free(memory);
}
