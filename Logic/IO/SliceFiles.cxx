#include "IO/SliceFiles.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"

#include <system_error>

namespace innergs {

std::string sliceTable(std::span<const FoundSlice> slices) {
  std::string text = "scan\tslice\tweight\tgain\tdisplacement_mm\tangle_degrees\tresidual";
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      text += formatted("\tm%d%d", row, column);
  text += "\n";
  for (const auto& [scan, slice, motion, place] : slices) {
    text += formatted("%zu\t%zu\t%.4g\t%.5g\t%.4g\t%.4g\t%.5g", scan + 1, slice, motion.weight, motion.gain,
                      motion.displacement, motion.angle, motion.residual);
    for (int row = 0; row < 3; ++row)
      text += formatted("\t%.9g\t%.9g\t%.9g\t%.9g", place.linear[row][0], place.linear[row][1],
                        place.linear[row][2], place.offset[row]);
    text += "\n";
  }
  return text;
}

std::string itkTransform(const Affine3& place) {
  const Affine3 back = inverse(place);
  std::string text =
      "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\nParameters:";
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      text += formatted(" %.17g", back.linear[row][column]);
  return text + formatted(" %.17g %.17g %.17g\nFixedParameters: 0 0 0\n", back.offset[0], back.offset[1],
                          back.offset[2]);
}

void writeTransforms(std::span<const FoundSlice> slices, const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure)
    throw Error(ErrorCode::Io,
                "The folder " + quoted(folder) + " could not be made: " + failure.message() + ".");
  for (const FoundSlice& one : slices)
    writeFileAtomically(folder / formatted("scan-%zu-slice-%03zu.tfm", one.scan + 1, one.slice),
                        itkTransform(one.place));
}

} // namespace innergs
