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
      const std::string remark = writeVolume(stack.image, path, o.type, VoxelValues(volume.voxels));
      if (!remark.empty()) fmt::print(stderr, "innergs: warning: {}\n", remark);
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
  command->add_option("volume", o->input, "Volume to scan")->required()->type_name("VOLUME");
  command
      ->add_option("-o,--output", o->output,
                   "Scan to write; --orthogonal appends -axial, -coronal, ... to the name")
      ->required()
      ->type_name("FILE");
  auto* thickness =
      command
          ->add_option("--thickness", o->thickness, "Voxels averaged into a slice; slices touch each other")
          ->type_name("K")
          ->check(CLI::Range(1, 1000));
  auto* keep = command->add_option("--keep-every", o->keepEvery, "Instead: keep every k-th slice as it is")
                   ->type_name("K")
                   ->check(CLI::Range(1, 1000))
                   ->excludes(thickness);
  auto* axis =
      command
          ->add_option("--axis", o->axis, "Slice axis: i, j, k (of the voxel grid) or the plane's name [k]")
          ->type_name("i|j|k|axial|coronal|sagittal")
          ->check(CLI::IsMember({"i", "j", "k", "axial", "coronal", "sagittal"}));
  command
      ->add_option("--orthogonal", o->orthogonal, "Number of scans at right angles: 2 (axial, coronal) or 3")
      ->type_name("N")
      ->check(CLI::Range(1, 3))
      ->excludes(axis);
  command
      ->add_option("--noise", o->noise,
                   "Standard deviation of added Gaussian noise, in the volume's units [0]")
      ->type_name("SD")
      ->check(CLI::NonNegativeNumber)
      ->excludes(keep);
  command->add_option("--seed", o->seed, "Seed of the noise [1]")->type_name("N");
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
