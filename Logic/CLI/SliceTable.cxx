#include "CLI/SliceTable.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"

#include <spdlog/fmt/fmt.h>

#include <system_error>

namespace innergs::cli {
namespace {

template <class Visit>
void forEachSlice(const ReconstructionResult& result, const Visit& visit) {
  for (std::size_t scan = 0; scan < result.sliceMotion.slices.size(); ++scan)
    for (std::size_t slice = 0; slice < result.sliceMotion.slices[scan].size(); ++slice)
      visit(scan, slice, result.sliceMotion.slices[scan][slice]);
}

} // namespace

std::string sliceTable(const ReconstructionResult& result) {
  std::string text = "scan\tslice\tweight\tgain\tdisplacement_mm\tangle_degrees\tresidual";
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      text += fmt::format("\tm{}{}", row, column);
  text += "\n";
  forEachSlice(result, [&](std::size_t scan, std::size_t slice, const SlicePose& pose) {
    text += fmt::format("{}\t{}\t{:.4g}\t{:.5g}\t{:.4g}\t{:.4g}\t{:.5g}", scan + 1, slice, pose.weight,
                        pose.gain, pose.displacement, pose.angle, pose.residual);
    const Affine3 place = slicePlace(result, scan, slice);
    for (int row = 0; row < 3; ++row)
      text += fmt::format("\t{:.9g}\t{:.9g}\t{:.9g}\t{:.9g}", place.linear[row][0], place.linear[row][1],
                          place.linear[row][2], place.offset[row]);
    text += "\n";
  });
  return text;
}

nlohmann::ordered_json slicesOf(const ReconstructionResult& result) {
  const SliceMotion& motion = result.sliceMotion;
  if (motion.slices.empty()) return {};
  const auto finite = [](double x) {
    return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json();
  };
  auto slices = nlohmann::ordered_json::array();
  forEachSlice(result, [&](std::size_t scan, std::size_t slice, const SlicePose& pose) {
    const Affine3 place = slicePlace(result, scan, slice);
    auto matrix = nlohmann::ordered_json::array();
    for (int row = 0; row < 3; ++row)
      matrix.push_back({place.linear[row][0], place.linear[row][1], place.linear[row][2], place.offset[row]});
    slices.push_back({{"scan", scan + 1},
                      {"slice", slice},
                      {"weight", pose.weight},
                      {"gain", pose.gain},
                      {"displacement_mm", pose.displacement},
                      {"angle_degrees", pose.angle},
                      {"residual", finite(pose.residual)},
                      {"matrix_lps", matrix}});
  });
  return {{"moved", motion.moved},
          {"psnr_to_others_db", finite(motion.psnrAfter)},
          {"psnr_to_others_before_db", finite(motion.psnrBefore)},
          {"median_displacement_mm", finite(motion.displacement)},
          {"median_angle_degrees", finite(motion.angle)},
          {"left_out", motion.rejected},
          {"slices", slices}};
}

std::string itkTransform(const Affine3& place) {
  const Affine3 back = inverse(place);
  std::string text =
      "#Insight Transform File V1.0\n#Transform 0\nTransform: AffineTransform_double_3_3\nParameters:";
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      text += fmt::format(" {:.17g}", back.linear[row][column]);
  return text + fmt::format(" {:.17g} {:.17g} {:.17g}\nFixedParameters: 0 0 0\n", back.offset[0],
                            back.offset[1], back.offset[2]);
}

void writeTransforms(const ReconstructionResult& result, const std::filesystem::path& folder) {
  std::error_code failure;
  std::filesystem::create_directories(folder, failure);
  if (failure)
    throw Error(ErrorCode::Io,
                "The folder " + quoted(folder) + " could not be made: " + failure.message() + ".");
  forEachSlice(result, [&](std::size_t scan, std::size_t slice, const SlicePose&) {
    writeFileAtomically(folder / fmt::format("scan-{}-slice-{:03}.tfm", scan + 1, slice),
                        itkTransform(slicePlace(result, scan, slice)));
  });
}

} // namespace innergs::cli
