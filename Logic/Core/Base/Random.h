#pragma once
#include <cstdint>

namespace innergs {

/// SplitMix64 (Steele et al. 2014): the same numbers on every platform, which the standard distributions do
/// not guarantee.
class Random {
public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = (state_ += 0x9e3779b97f4a7c15ull);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ull;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebull;
    return z ^ (z >> 31);
  }
  double uniform() { return static_cast<double>(next() >> 11) * 0x1p-53; } // [0, 1)

private:
  std::uint64_t state_;
};

} // namespace innergs
