#include "CLI/ReconstructOptions.h"

namespace innergs::cli {
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
  output
      ->add_option(
          "--slices", o.slices,
          "Table to write (TSV): where each slice of several scans lies, its weight and how well it fits")
      ->type_name("FILE");
  output
      ->add_option("--transforms", o.transforms,
                   "Folder for the same places as ITK transforms (.tfm), one per slice")
      ->type_name("DIR");
  output
      ->add_option("--uncertainty", o.uncertainty,
                   "Volume to write: the standard deviation by which the output may be off; takes a second "
                   "fit\nwithout some of the slices")
      ->type_name("FILE");
  output
      ->add_option(
          "--measured", o.measured,
          "Volume to write: 1 where some slice measured the tissue, 0 where the output is interpolated;\n"
          "takes the same second fit")
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
          "--mask", o.masks,
          "Fit only inside this mask (any grid; not 0 = inside), or one per scan in their order; give it\n"
          "after the scans. The model has values there and up to one slice distance beyond, and without\n"
          "--reference and --roi the output is cropped to that box")
      ->type_name("IMAGE");
  input
      ->add_option("--held-out", o.heldOut,
                   "Fraction of the slices, up to 0.5, withheld from a second fit, to report the quality on\n"
                   "them; takes about the same time again [0]")
      ->type_name("F");

  addSettings(app, o.settings);
  auto* resuming = app.add_option_group("Resuming");
  resuming
      ->add_option("--resume", o.resume,
                   "Resume from a model saved by an interrupted run with the same inputs and settings")
      ->type_name("MODEL");

  app.footer(
      "Examples:\n"
      "  innergs reconstruct axial.nii.gz -o volume.nii.gz\n"
      "  innergs reconstruct ax.nii.gz cor.nii.gz sag.nii.gz --spacing 1 -o volume.nii.gz\n"
      "  innergs reconstruct ax.nii.gz cor.nii.gz sag.nii.gz --transforms poses -o volume.nii.gz\n"
      "  innergs reconstruct ax.nii.gz cor.nii.gz --mask ax-brain.nii.gz cor-brain.nii.gz -o volume.nii.gz\n"
      "  innergs reconstruct dicom-folder/ --reference t1.nii.gz --type int16 -o volume.nrrd\n"
      "  innergs reconstruct t2.nii.gz --thickness 4 --profile gaussian --mask brain.nii.gz \\\n"
      "      --preset best --save-model t2.innergs --held-out 0.1 --report t2.json -o t2-1mm.nii.gz\n"
      "Ctrl-C stops the fit and writes the result so far; --resume continues from the saved model.");
}

} // namespace innergs::cli
