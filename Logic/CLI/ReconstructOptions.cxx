#include "CLI/ReconstructOptions.h"

namespace innergs::cli {

void addSettings(CLI::App& app, Settings& settings) {
  addChoice<Preset>(app, "--preset", settings.preset,
                    {{"fast", Preset::Fast}, {"balanced", Preset::Balanced}, {"best", Preset::Best}},
                    "How much work to put in: seconds, about a minute, minutes [balanced]");
  app.add_option("--gaussians", settings.gaussians, "At most this many Gaussians [chosen from the data]")
      ->type_name("N");
  app.add_option("--iterations", settings.iterations,
                 "Sweeps over the data, per member [chosen by the preset]")
      ->type_name("N");
  app.add_option("--members", settings.members,
                 "Fields fitted independently and merged, against noise across gaps [chosen from the data]")
      ->type_name("N");
  app.add_option("--seed", settings.seed, "Same seed, same result, bit for bit, on any number of threads [1]")
      ->type_name("N");
  addThreads(app, settings.threads);
  addChoice<Blending>(
      app, "--blending", settings.blending,
      {{"normalised", Blending::Normalised}, {"additive", Blending::Additive}, {"alpha", Blending::Alpha}},
      "How Gaussians add up [normalised]");
  addChoice<LossKind>(app, "--loss", settings.loss,
                      {{"l1", LossKind::L1}, {"l2", LossKind::L2}, {"huber", LossKind::Huber}},
                      "What the fit minimises [l2]");
  app.add_option("--huber-delta", settings.huberDelta,
                 "Where the Huber loss turns linear, as a fraction of the intensity range [0.02]")
      ->type_name("F");
  app.add_option("--ssim-weight", settings.ssimWeight, "Weight of 1 - SSIM beside the loss [0]")
      ->type_name("F");
  addChoice<Initialisation>(app, "--initialisation", settings.initialisation,
                            {{"adaptive", Initialisation::Adaptive}, {"grid", Initialisation::Grid}},
                            "Where Gaussians start: where the structure is, or on an even grid [adaptive]");
  app.add_flag("--paper-stop-rule", settings.paperStopRule,
               "Stop when the loss fell by less than 1e-4 over 100 sweeps, after 1000 at the latest");
  app.add_flag_callback(
      "--no-relocation", [&settings] { settings.relocate = false; },
      "On an even grid, leave useless Gaussians where they are");
  app.add_flag_callback(
      "--no-consistency", [&settings] { settings.consistency = false; },
      "Leave out the data-consistency step after the fit");
  app.add_option("--instruction-set", settings.instructionSet,
                 "Force one of those that 'innergs info' lists, e.g. scalar [best available]")
      ->type_name("NAME");
}

void addOptions(CLI::App& app, ReconstructOptions& o) {
  app.add_option(
         "inputs", o.inputs,
         "One scan, or several scans of the same anatomy in any orientation: NIfTI, NRRD, MHA, MINC2 or\n"
         "a folder with one DICOM series")
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
  addNumbers(
      *input, "--thickness", o.thickness, {},
      "Slice thickness in mm: one number, or one per scan as a,b,c [from the file, or the slice spacing]")
      ->type_name("MM");
  addChoice<std::optional<SliceProfile>>(
      *input, "--profile", o.profile,
      {{"box", SliceProfile::Box}, {"gaussian", SliceProfile::Gaussian}, {"point", SliceProfile::Point}},
      "How a slice averages the tissue across its thickness; point = infinitely thin [box]");
  input->add_option("--mask", o.mask, "Fit only inside this mask (any grid; not 0 = inside)")
      ->type_name("IMAGE");
  input
      ->add_option("--held-out", o.heldOut,
                   "Fraction of the slices withheld from the fit, to report the quality on them [0]")
      ->type_name("F")
      ->check(CLI::Range(0.0, 0.9));

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
