#include "IO/MotionFieldIO.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/VoxelWriting.h"

#include <bit>
#include <fstream>

namespace fs = std::filesystem;

namespace innergs {
namespace {

/// 3D Slicer looks for the times under "axis 3", whatever the list's axis is.
std::string header(const MotionSequence& motion) {
  const GridGeometry& g = motion.geometry;
  std::string text = "NRRD0005\ntype: float\ndimension: 5\nspace: left-posterior-superior\nsizes: 3";
  for (const std::int64_t n : g.size)
    text += " " + std::to_string(n);
  text += " " + std::to_string(motion.times.size()) + "\nspace directions: none";
  for (int axis = 0; axis < 3; ++axis)
    text += " " + nrrdVector(g.spacing[axis] * column(g.direction, axis));
  text += " none\nkinds: vector domain domain domain list\n"
          "labels: \"displacement\" \"\" \"\" \"\" \"time\"\nunits: \"mm\" \"\" \"\" \"\" \"s\"\n"
          "space units: \"mm\" \"mm\" \"mm\"\n";
  text += std::string("endian: ") + (std::endian::native == std::endian::little ? "little" : "big") +
          "\nencoding: gzip\nspace origin: " + nrrdVector(g.origin) + "\n";
  text += "DataNodeClassName:=vtkMRMLVectorVolumeNode\naxis 3 index type:=numeric\naxis 3 index values:=";
  for (std::size_t f = 0; f < motion.times.size(); ++f)
    text += (f ? " " : "") + exactText(motion.times[f]);
  return text + "\n\n";
}

void writeSequence(const MotionSequence& motion, const fs::path& path) {
  const std::string failed = writingFailed(path);
  std::vector<float> all;
  for (const auto& field : motion.fields)
    all.insert(all.end(), field.begin(), field.end());
  writeAtomically(path, [&](const fs::path& temporary) {
    {
      std::ofstream out(temporary, std::ios::binary);
      out << header(motion);
      if (!out.flush()) throw Error(ErrorCode::Io, failed);
    }
    writeBehind("", all.data(), all.size() * sizeof(float), "ab", temporary, failed);
  });
}

} // namespace

std::vector<fs::path> motionFiles(const fs::path& path, std::size_t times) {
  const std::string extension = fullExtension(path);
  if (!isSequenceFile(path) && extension != ".nrrd" && extension != ".nii" && extension != ".nii.gz" &&
      extension != ".mha")
    throw Error(ErrorCode::InvalidArgument,
                quoted(path) +
                    " has no extension of a displacement field; use .seq.nrrd for all in one file, "
                    "or .nrrd, .nii.gz, .nii or .mha for one file per frame.");
  if (isSequenceFile(path) || times == 1) return {path};
  std::vector<fs::path> files;
  for (std::size_t f = 0; f < times; ++f) {
    std::string number = std::to_string(f);
    if (number.size() < 3) number.insert(0, 3 - number.size(), '0');
    files.push_back(withEnding(path, "-" + number + extension));
  }
  return files;
}

void writeMotion(const MotionSequence& motion, const fs::path& path) {
  const auto values = static_cast<std::size_t>(motion.geometry.voxelCount()) * 3;
  if (motion.fields.empty() || motion.fields.size() != motion.times.size())
    throw Error(ErrorCode::InvalidArgument, "The motion for " + quoted(path) + " needs one field per time.");
  for (const auto& field : motion.fields)
    if (field.size() != values)
      throw Error(ErrorCode::InvalidArgument,
                  "The motion for " + quoted(path) + " has a field of another size than its grid.");
  if (isSequenceFile(path)) return writeSequence(motion, path);
  const std::vector<fs::path> files = motionFiles(path, motion.times.size());
  for (std::size_t f = 0; f < files.size(); ++f)
    writeItkFile(files[f], motion.geometry, OutputType::Float32,
                 TypedVoxels(motion.fields[f], OutputType::Float32, {}, files[f]), {}, 3);
}

} // namespace innergs
