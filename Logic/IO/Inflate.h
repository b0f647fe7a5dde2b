#pragma once
#include <cstdint>
#include <istream>

namespace innergs {

/// Decompressed length of the zlib or gzip stream that begins at `start`; 0 if it is damaged (including its
/// checksum) or truncated.
std::uint64_t inflatedBytes(std::istream& in, std::uint64_t start);

} // namespace innergs
