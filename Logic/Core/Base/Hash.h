#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace innergs {

constexpr std::uint64_t kHashStart = 0xcbf29ce484222325ull;

/// FNV-1a over 8-byte words, into a hash that starts as kHashStart.
inline void hash(std::uint64_t& h, const void* data, std::size_t bytes) {
  const char* p = static_cast<const char*>(data);
  for (; bytes > 0;) {
    std::uint64_t word = 0;
    const std::size_t n = std::min<std::size_t>(8, bytes);
    std::memcpy(&word, p, n);
    h = (h ^ word) * 0x100000001b3ull;
    h ^= h >> 29;
    p += n;
    bytes -= n;
  }
}

} // namespace innergs
