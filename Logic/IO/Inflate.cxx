#include "IO/Inflate.h"

#include <itk_zlib.h>

#include <vector>

namespace innergs {

std::uint64_t inflatedBytes(std::istream& in, std::uint64_t start) {
  in.seekg(static_cast<std::streamoff>(start));
  z_stream stream{};
  constexpr int zlibOrGzip = 15 + 32;
  if (inflateInit2(&stream, zlibOrGzip) != Z_OK) return 0;
  std::vector<unsigned char> input(1 << 16), output(1 << 18);
  std::uint64_t total = 0;
  int status = Z_OK;
  while (status == Z_OK) {
    in.read(reinterpret_cast<char*>(input.data()), static_cast<std::streamsize>(input.size()));
    stream.next_in = input.data();
    stream.avail_in = static_cast<unsigned>(in.gcount());
    if (stream.avail_in == 0) break;
    do {
      stream.next_out = output.data();
      stream.avail_out = static_cast<unsigned>(output.size());
      status = inflate(&stream, Z_NO_FLUSH);
      total += output.size() - stream.avail_out;
    } while (status == Z_OK && stream.avail_out == 0);
    if (status == Z_BUF_ERROR) status = Z_OK; // input exhausted
  }
  inflateEnd(&stream);
  return status == Z_STREAM_END ? total : 0;
}

} // namespace innergs
