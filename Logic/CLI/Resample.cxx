#include "CLI/Command.h"
#include "CLI/Interrupt.h"
#include "CLI/Options.h"

#include "Core/Render/Render.h"
#include "IO/OutputFiles.h"

#include <spdlog/fmt/fmt.h>

namespace innergs::cli {
namespace {

struct ResampleOptions {
  std::string model, output;
  GridOptions grid;
  std::optional<double> fill;
  OutputType type = OutputType::Float32;
  Settings settings; // threads, selection and device
  bool quiet = false;
};

int resample(const ResampleOptions& o) {
  OutputFiles files;
  files.read(o.model);
  files.read(o.grid.reference);
  files.add(o.output, OutputFiles::Kind::Volume);
  Interrupt interrupt;
  const GaussianField field = loadField(o.model, o.fill);
  const GridGeometry grid = o.grid.choose(field.region(), field.region());
  checkMemory(8 * grid.voxelCount(), "The volume");
  RenderOptions render;
  render.threads = o.settings.threads;
  render.selection = o.settings.selection;
  render.stop = interrupt.token();
  render.device = renderDevice(o.settings.device, field, grid.voxelCount(), o.settings.selection);
  writeRendered(innergs::render(field, grid, render), field, o.output, o.type);
  if (!o.quiet)
    fmt::print(stderr, "Wrote {} ({}x{}x{} voxels of {:g}x{:g}x{:g} mm).\n", o.output, grid.size[0],
               grid.size[1], grid.size[2], grid.spacing[0], grid.spacing[1], grid.spacing[2]);
  return Success;
}

} // namespace

Subcommand addResample(CLI::App& app) {
  auto* command = app.add_subcommand("resample", "Resamples a model to a volume on any grid");
  auto o = std::make_shared<ResampleOptions>();
  addOption(*command, "model", o->model, "MODEL", "Model (.innergs) or Gaussians (.ply)")->required();
  addOption(*command, "-o,--output", o->output, "FILE", "Volume to write: .nii, .nii.gz, .nrrd or .mha")
      ->required();
  o->grid.add(*command, "the fitted grid, cropped to the mask's box");
  addOutputType(*command, o->type);
  addFill(*command, o->fill);
  addSetting(*command, o->settings, "threads");
  addSetting(*command, o->settings, "selection");
  addSetting(*command, o->settings, "device", "Where to render; auto takes a GPU for many voxels [auto]");
  command->add_flag("-q,--quiet", o->quiet, "Print only errors");
  command->footer("Examples:\n"
                  "  innergs resample head.innergs --spacing 0.5 -o fine.nii.gz\n"
                  "  innergs resample head.innergs --reference t1.nii.gz --type int16 -o on-t1.nrrd\n"
                  "  innergs resample head.innergs --spacing 0.25 --roi -20,20,-10,30,0,40 -o detail.nii.gz");
  return {command, [o] { return resample(*o); }};
}

} // namespace innergs::cli
