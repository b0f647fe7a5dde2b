#pragma once
#include <cstdint>
#include <istream>

namespace innergs {

/// Length of the zlib or gzip stream that begins at `start`, once decompressed; 0 when it is damaged (its
/// checksum is tested as well) or does not end.
std::uint64_t inflatedBytes(std::istream& in, std::uint64_t start);

} // namespace innergs
