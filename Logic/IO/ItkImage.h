#pragma once
#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Image/GridGeometry.h"
#include "IO/ClassicStreams.h"
#include "IO/MemoryCheck.h"
#include "IO/QuietItk.h"

#include <itkImageIOBase.h>

#include <cstddef>
#include <new>
#include <span>
#include <string>

namespace innergs {

/// Calls `work`; converts any exception of ITK or of a library below it to Error(code, sentence).
template <typename Work>
auto withItk(ErrorCode code, const std::string& sentence, Work&& work) {
  const QuietItk quiet;
  const ClassicNumbers numbers; // for the C library, which readers and writers use
  const ClassicStreams streams;
  try {
    return work();
  } catch (const Error&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw Error(ErrorCode::Memory,
                "There is not enough memory for the image; crop it or lower its resolution.");
  } catch (const std::exception&) {
    throw Error(code, sentence);
  }
}

/// The image described by an ImageIO that has read its header, as scalar frames on one grid.
struct ItkHeader {
  GridGeometry geometry; // not checked yet
  std::int64_t frames = 1;
  bool interleaved = false; // the frames of a voxel are adjacent, as the components of a pixel
};

/// Throws Error(UnsupportedImage) if pixels are not single numbers (RGB, complex, vector, tensor) and for 2D
/// images. `sequence`: treat the components of a vector pixel as frames.
ItkHeader describe(const itk::ImageIOBase& io, const std::string& what, bool sequence = false);

/// out[i] = source[first + i·stride] as float; `source` holds components of the given type.
void convertVoxels(itk::CommonEnums::IOComponent type, const std::byte* source, std::size_t first,
                   std::size_t stride, std::span<float> out);

} // namespace innergs
