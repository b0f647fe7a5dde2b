#include "CLI/ReconstructOptions.h"

namespace innergs::cli {
void addOptions(CLI::App& app, ReconstructOptions& o) {
  addOption(app, "inputs", o.inputs, "SCAN",
            "One scan, or several scans of the same anatomy in any orientation: NIfTI, NRRD, MHA, MINC2 or\n"
            "a folder of DICOM files; a tracked ultrasound sweep (.igs.mha)")
      ->required();

  auto* output = app.add_option_group("Output", "at least one of --output, --save-model and --ply is needed");
  addOption(*output, "-o,--output", o.output, "FILE", "Volume to write: .nii, .nii.gz, .nrrd or .mha");
  addOption(*output, "--save-model", o.saveModel, "FILE",
            "Model to write (.innergs), for slice, resample and --resume");
  addOption(*output, "--ply", o.ply, "FILE",
            "Gaussians to write as PLY with the names of 3D Gaussian splatting");
  addOption(*output, "--report", o.report, "FILE",
            "JSON report to write: settings, geometry, quality, timings");
  addOption(*output, "--slices", o.slices, "FILE",
            "Table to write (TSV): where each slice of several scans lies, its weight and how well it fits");
  addOption(*output, "--transforms", o.transforms, "DIR",
            "Folder for the same places as ITK transforms (.tfm), one per slice");
  addOption(*output, "--uncertainty", o.uncertainty, "FILE",
            "Volume to write: the standard deviation by which the output may be off; takes a second "
            "fit\nwithout some of the slices");
  addOption(*output, "--measured", o.measured, "FILE",
            "Volume to write: 1 where some slice measured the tissue, 0 where the output is interpolated;\n"
            "takes the same second fit");
  addOutputType(*output, o.type);
  o.grid.add(*output,
             "the finest spacing of the scans, isotropic, over the box of the first and of those beside it");
  output->add_flag("-q,--quiet", o.quiet, "No progress and no summary; errors and warnings only");

  auto* input = app.add_option_group("Input", "how the scans were acquired");
  addOption(*input, "--frame", o.frame, "N", "Frame to take from 4D files, from 0")
      ->check(CLI::NonNegativeNumber);
  addOption(*input, "--series", o.series, "N",
            "Series to take from DICOM folders, from 1: one number, or one per folder as a,b,c; 'innergs\n"
            "info FOLDER' lists them [the only one]")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::PositiveNumber);
  addCalibration(*input, o.calibration);
  addNumbers(
      *input, "--thickness", o.thickness, {}, "MM",
      "Slice thickness in mm: one number, or one per scan as a,b,c [from the file, or the slice spacing]");
  addChoice<std::optional<SliceProfile>>(
      *input, "--profile", o.profile,
      {{"box", SliceProfile::Box}, {"gaussian", SliceProfile::Gaussian}, {"point", SliceProfile::Point}},
      "How a slice averages the tissue across its thickness; point = infinitely thin [box]");
  addOption(*input, "--mask", o.masks, "IMAGE",
            "Fit only inside this mask (any grid; not 0 = inside), or one per scan in their order; give it\n"
            "after the scans. The model has values there and up to one slice distance beyond, and without\n"
            "--reference and --roi the output is cropped to that box");
  addOption(*input, "--held-out", o.heldOut, "F",
            "Fraction of the slices, up to 0.5, held out from a second fit, to report the quality on\n"
            "them; takes about the same time again [0]");

  addSettings(app, o.settings);
  auto* resuming = app.add_option_group("Resuming");
  addOption(*resuming, "--resume", o.resume, "MODEL",
            "Resume from a model saved by an interrupted run with the same inputs and settings");

  app.footer(
      "Examples:\n"
      "  innergs reconstruct axial.nii.gz -o volume.nii.gz\n"
      "  innergs reconstruct ax.nii.gz cor.nii.gz sag.nii.gz --spacing 1 -o volume.nii.gz\n"
      "  innergs reconstruct ax.nii.gz cor.nii.gz sag.nii.gz --transforms poses -o volume.nii.gz\n"
      "  innergs reconstruct ax.nii.gz cor.nii.gz --mask ax-brain.nii.gz cor-brain.nii.gz -o volume.nii.gz\n"
      "  innergs reconstruct dicom-folder/ --reference t1.nii.gz --type int16 -o volume.nrrd\n"
      "  innergs reconstruct t2.nii.gz --thickness 4 --profile gaussian --mask brain.nii.gz \\\n"
      "      --preset best --save-model t2.innergs --held-out 0.1 --report t2.json -o t2-1mm.nii.gz\n"
      "  innergs reconstruct sweep.igs.mha --calibration PlusConfiguration.xml --spacing 0.5 -o "
      "volume.nii.gz\n"
      "Ctrl-C stops the fit and writes the result so far; --resume continues from the saved model.");
}

} // namespace innergs::cli
