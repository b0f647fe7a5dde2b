#include "CLI/ReconstructOptions.h"

namespace innergs::cli {
namespace {

void addSchedule(CLI::App& app, Settings& settings) {
  addChoice<std::optional<Schedule>>(
      app, "--schedule", settings.schedule,
      {{"exponential", Schedule::Exponential}, {"plateau", Schedule::Plateau}},
      "Learning rates: decay over the iterations, or fall when the loss stops improving\n"
      "[exponential; --preset paper: plateau]");
  app.add_option("--patience", settings.plateau.patience,
                 "Plateau: iterations without improvement before the rates fall [10]")
      ->type_name("N");
  app.add_option("--plateau-factor", settings.plateau.factor,
                 "Plateau: what the rates are multiplied by [0.5]")
      ->type_name("F");
  app.add_option("--beta1", settings.beta1, "Adam: share of the old mean of the gradient in the new [0.8]")
      ->type_name("F");
  app.add_option("--beta2", settings.beta2, "Adam: share of the old mean of its square in the new [0.95]")
      ->type_name("F");
}

void addDensification(CLI::App& app, Settings& settings) {
  app.add_option("--densify-every", settings.densifyEvery,
                 "Prune and densify Gaussians every so many iterations; 0 = never\n"
                 "[0; --preset paper or with --max-gaussians: 10]")
      ->type_name("N");
  app.add_option("--max-gaussians", settings.maxGaussians,
                 "Gaussians that densification may reach; it also turns it on [as many as at the start]")
      ->type_name("N");
  app.add_option("--prune-opacity", settings.densify.opacity,
                 "Prune Gaussians of a lower opacity [alpha blending 0.3, others 0.01]")
      ->type_name("F");
  app.add_option("--prune-size", settings.densify.size,
                 "Prune Gaussians with a standard deviation of more voxels [20]")
      ->type_name("F");
  app.add_option(
         "--densify-gradient", settings.densify.gradient,
         "Densify Gaussians whose move by one voxel would change the loss by more than that of so many\n"
         "samples [1]")
      ->type_name("F");
  app.add_option("--split-size", settings.densify.split,
                 "Split those whose covariance has a larger norm, in voxels squared, clone the others [2]")
      ->type_name("F");
}

} // namespace

void addSettings(CLI::App& app, Settings& settings) {
  addChoice<Preset>(
      app, "--preset", settings.preset,
      {{"fast", Preset::Fast},
       {"balanced", Preset::Balanced},
       {"best", Preset::Best},
       {"paper", Preset::Paper}},
      "How much work to put in: seconds, about a minute, minutes; or the paper's own method, where\n"
      "no other option says otherwise [balanced]");
  app.add_option("--gaussians", settings.gaussians, "Gaussians to start with [chosen from the data]")
      ->type_name("N");
  app.add_option("--iterations", settings.iterations,
                 "Iterations over the data, per member [chosen by the preset]")
      ->type_name("N");
  app.add_option("--members", settings.ensembleSize,
                 "Fields fitted independently and merged, against noise across gaps [chosen from the data]")
      ->type_name("N");
  app.add_option("--seed", settings.seed, "Same seed, same result, bit for bit, on any number of threads [1]")
      ->type_name("N");
  addThreads(app, settings.threads);
  addDevice(
      app, settings.device,
      "Where the fit runs: auto takes a GPU that 'innergs info' lists and whose memory suffices [auto]");
  addChoice<std::optional<Blending>>(
      app, "--blending", settings.blending,
      {{"normalised", Blending::Normalised}, {"additive", Blending::Additive}, {"alpha", Blending::Alpha}},
      "How Gaussians add up [normalised]");
  app.add_flag(
      "--all-axes,!--no-all-axes", settings.allAxes,
      "Fit the slices of one scan along all three of its axes [alpha blending of nearly cubic voxels]");
  addChoice<std::optional<LossKind>>(app, "--loss", settings.loss,
                                     {{"l1", LossKind::L1}, {"l2", LossKind::L2}, {"huber", LossKind::Huber}},
                                     "What the fit minimises [l2]");
  app.add_option("--loss-weight", settings.pointWeight, "Weight of that loss [1]")->type_name("F");
  app.add_option("--huber-delta", settings.huberDelta,
                 "Where the Huber loss turns linear, as a fraction of the intensity range [0.02]")
      ->type_name("F");
  app.add_option("--ssim-weight", settings.ssimWeight,
                 "Weight of 1 - SSIM beside the loss; the paper's loss: --loss l1 --loss-weight 0.8\n"
                 "--ssim-weight 0.4 [0]")
      ->type_name("F");
  addChoice<std::optional<Initialisation>>(
      app, "--initialisation", settings.initialisation,
      {{"adaptive", Initialisation::Adaptive}, {"grid", Initialisation::Grid}},
      "Where Gaussians start: where the structure is, or on an even grid [adaptive]");
  addSchedule(app, settings);
  addDensification(app, settings);
  app.add_flag("--paper-stop-rule", settings.paperStopRule,
               "Stop when the loss fell by less than 1e-4 over 100 iterations, after 1000 at the latest");
  app.add_flag_callback(
      "--no-relocation", [&settings] { settings.relocate = false; },
      "On an even grid, leave useless Gaussians where they are");
  app.add_flag_callback(
      "--no-consistency", [&settings] { settings.consistency = false; },
      "Leave out the data-consistency step after the fit");
  addSelection(app, settings.selection);
  app.add_option("--cutoff", settings.cutoff,
                 "Where Gaussians end, in standard deviations, 1 to 5; the paper's: 3 [2.2]")
      ->type_name("R");
  app.add_option("--instruction-set", settings.instructionSet,
                 "Force one of those that 'innergs info' lists, e.g. scalar [best available]")
      ->type_name("NAME");
}

void addOptions(CLI::App& app, ReconstructOptions& o) {
  app.add_option(
         "inputs", o.inputs,
         "One scan, or several scans of the same anatomy in any orientation: NIfTI, NRRD, MHA, MINC2 or\n"
         "a folder of DICOM files")
      ->required()
      ->type_name("SCAN");

  auto* output = app.add_option_group("Output", "at least one of --output, --save-model and --ply is needed");
  output->add_option("-o,--output", o.output, "Volume to write: .nii, .nii.gz, .nrrd or .mha")
      ->type_name("FILE");
  output
      ->add_option("--save-model", o.saveModel, "Model to write (.innergs), for slice, resample and --resume")
      ->type_name("FILE");
  output->add_option("--ply", o.ply, "Gaussians to write as PLY with the names of 3D Gaussian splatting")
      ->type_name("FILE");
  output->add_option("--report", o.report, "JSON report to write: settings, geometry, quality, timings")
      ->type_name("FILE");
  addOutputType(*output, o.type);
  o.grid.add(*output, "the finest spacing of the scans, isotropic, over the first scan's box");
  output->add_flag("-q,--quiet", o.quiet, "No progress and no summary; errors and warnings only");

  auto* input = app.add_option_group("Input", "how the scans were acquired");
  input->add_option("--frame", o.frame, "Frame to take from 4D files, from 0")
      ->type_name("N")
      ->check(CLI::NonNegativeNumber);
  input
      ->add_option(
          "--series", o.series,
          "Series to take from DICOM folders, from 1: one number, or one per folder as a,b,c; 'innergs\n"
          "info FOLDER' lists them [the only one]")
      ->type_name("N")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::PositiveNumber);
  addNumbers(
      *input, "--thickness", o.thickness, {},
      "Slice thickness in mm: one number, or one per scan as a,b,c [from the file, or the slice spacing]")
      ->type_name("MM");
  addChoice<std::optional<SliceProfile>>(
      *input, "--profile", o.profile,
      {{"box", SliceProfile::Box}, {"gaussian", SliceProfile::Gaussian}, {"point", SliceProfile::Point}},
      "How a slice averages the tissue across its thickness; point = infinitely thin [box]");
  input
      ->add_option(
          "--mask", o.mask,
          "Fit only inside this mask (any grid; not 0 = inside): the model has values there and up\n"
          "to one slice distance beyond, and without --reference and --roi the output is cut to that box")
      ->type_name("IMAGE");
  input
      ->add_option("--fill", o.settings.fill,
                   "Value of the volume, and of every later query of the model, outside the mask [0]")
      ->type_name("VALUE");
  input
      ->add_option("--held-out", o.heldOut,
                   "Fraction of the slices, up to 0.5, withheld from a second fit, to report the quality on\n"
                   "them; takes about the same time again [0]")
      ->type_name("F");

  auto* fit = app.add_option_group("Fit");
  addSettings(*fit, o.settings);
  fit->add_option("--resume", o.resume,
                  "Go on from a model that an interrupted run of the same inputs and settings saved")
      ->type_name("MODEL");

  app.footer("Examples:\n"
             "  innergs reconstruct axial.nii.gz -o volume.nii.gz\n"
             "  innergs reconstruct ax.nii.gz cor.nii.gz sag.nii.gz --spacing 1 -o volume.nii.gz\n"
             "  innergs reconstruct dicom-folder/ --reference t1.nii.gz --type int16 -o volume.nrrd\n"
             "  innergs reconstruct t2.nii.gz --thickness 4 --profile gaussian --mask brain.nii.gz \\\n"
             "      --preset best --save-model t2.innergs --held-out 0.1 --report t2.json -o t2-1mm.nii.gz\n"
             "Ctrl-C stops the fit and writes what it has reached; --resume goes on from the saved model.");
}

} // namespace innergs::cli
