#include "CLI/Command.h"
#include "CLI/Options.h"

#include "Core/Image/Simulate.h"
#include "Evaluation/Protocols.h"
#include "IO/FilePath.h"
#include "IO/OutputFiles.h"

#include <spdlog/fmt/fmt.h>

namespace innergs::cli {
namespace {

struct SimulateOptions {
  std::string input, output, axis = "k";
  ReadOptions reading;
  int thickness = 0, keepEvery = 0, orthogonal = 1;
  double noise = 0;
  std::uint64_t seed = 1;
  OutputType type = OutputType::Float32;
  bool quiet = false;
};

// scan.nii.gz → scan-axial.nii.gz
std::filesystem::path withSuffix(const std::filesystem::path& path, const std::string& suffix) {
  std::string name = utf8(path.filename());
  name.insert(name.size() - fullExtension(path).size(), "-" + suffix);
  return path.parent_path() / pathOf(name);
}

int simulate(const SimulateOptions& o) {
  if ((o.thickness > 0) == (o.keepEvery > 0))
    throw CLI::ValidationError("simulate", "needs either --thickness or --keep-every");
  constexpr std::array planes{Plane::Axial, Plane::Coronal, Plane::Sagittal};
  std::vector<std::filesystem::path> paths;
  for (int n = 0; o.orthogonal > 1 && n < o.orthogonal; ++n)
    paths.push_back(withSuffix(o.output, planeName(planes[n])));
  if (paths.empty()) paths.push_back(o.output);
  OutputFiles files;
  files.read(o.input);
  for (const auto& path : paths)
    files.add(path, OutputFiles::Kind::Volume);
  const Volume volume = readVolume(o.input, o.reading);

  const auto axisOf = [&](std::size_t scan) {
    if (paths.size() > 1) return sliceAxis(volume.geometry, planes[scan]);
    for (const Plane plane : planes)
      if (o.axis == planeName(plane)) return sliceAxis(volume.geometry, plane);
    return o.axis[0] - 'i';
  };
  std::uint64_t seed = o.seed;
  for (std::size_t scan = 0; scan < paths.size(); ++scan) {
    const int axis = axisOf(scan);
    const Stack stack = o.thickness > 0 ? simulateThickStack(volume, axis, o.thickness, o.noise, seed++)
                                        : keepEvery(volume, axis, o.keepEvery);
    const bool written = files.write(paths[scan], [&](const auto& path) {
      warn(writeVolume(stack.image, path, o.type, VoxelValues(volume.voxels)));
    });
    if (written && !o.quiet)
      fmt::print(stderr, "Wrote {} ({} slices, {:g} mm apart).\n", utf8(paths[scan]),
                 stack.image.geometry.size[2], stack.image.geometry.spacing[2]);
  }
  files.check();
  if (o.keepEvery > 0 && !o.quiet)
    fmt::print(stderr, "The slices are thin: reconstruct them with --profile point.\n");
  return Success;
}

} // namespace

Subcommand addSimulate(CLI::App& app) {
  auto* command =
      app.add_subcommand("simulate", "Simulates thick-slice scans of a volume, for tests with a known truth");
  auto o = std::make_shared<SimulateOptions>();
  addOption(*command, "volume", o->input, "VOLUME", "Volume to scan")->required();
  addOption(*command, "-o,--output", o->output, "FILE",
            "Scan to write; --orthogonal appends -axial, -coronal, ... to the name")
      ->required();
  auto* thickness = addOption(*command, "--thickness", o->thickness, "K",
                              "Voxels averaged into a slice; slices touch each other")
                        ->check(CLI::Range(1, 1000));
  auto* keep =
      addOption(*command, "--keep-every", o->keepEvery, "K", "Instead: keep every k-th slice as it is")
          ->check(CLI::Range(1, 1000))
          ->excludes(thickness);
  auto* axis = addOption(*command, "--axis", o->axis, "i|j|k|axial|coronal|sagittal",
                         "Slice axis: i, j, k (of the voxel grid) or the plane's name [k]")
                   ->check(CLI::IsMember({"i", "j", "k", "axial", "coronal", "sagittal"}));
  addOption(*command, "--orthogonal", o->orthogonal, "N",
            "Number of scans at right angles: 2 (axial, coronal) or 3")
      ->check(CLI::Range(1, 3))
      ->excludes(axis);
  addOption(*command, "--noise", o->noise, "SD",
            "Standard deviation of added Gaussian noise, in the volume's units [0]")
      ->check(CLI::NonNegativeNumber)
      ->excludes(keep);
  addOption(*command, "--seed", o->seed, "N", "Seed of the noise [1]");
  addReading(*command, o->reading);
  addOutputType(*command, o->type);
  command->add_flag("-q,--quiet", o->quiet, "Print only errors");
  command->footer("Examples:\n"
                  "  innergs simulate t1.nii.gz --thickness 5 --orthogonal 3 -o scan.nii.gz\n"
                  "  innergs simulate t1.nii.gz --thickness 4 --axis axial --noise 3 -o thick.nii.gz\n"
                  "  innergs simulate t1.nii.gz --keep-every 4 -o sparse.nii.gz");
  return {command, [o] { return simulate(*o); }};
}

} // namespace innergs::cli
