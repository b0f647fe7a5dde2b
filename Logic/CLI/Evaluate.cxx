#include "CLI/Command.h"
#include "CLI/ComparisonPicture.h"
#include "CLI/Interrupt.h"
#include "CLI/ProgressDisplay.h"
#include "CLI/ReconstructOptions.h"

#include "Core/Base/Error.h"
#include "Evaluation/HeldOutProtocol.h"
#include "Evaluation/PaperProtocol.h"
#include "Evaluation/Report.h"
#include "Evaluation/ScansProtocol.h"
#include "Evaluation/StacksProtocol.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/OutputFiles.h"

#include <spdlog/fmt/fmt.h>

#include <iostream>

namespace innergs::cli {
namespace {

enum class Protocol { HeldOut, Paper, Both, Stacks, Scans };

struct EvaluateOptions {
  std::vector<std::string> volumes, masks;
  ReadOptions reading;
  Protocol protocol = Protocol::HeldOut;
  int keepEvery = 0, thickness = 0, orthogonal = 0;
  double noise = 0;
  std::optional<double> heldOut;
  StacksCase stacks;
  Settings settings;
  bool baselinesOnly = false, uncertainty = false;
  std::string csv, json, picture, saveVolume, saveModel;
  bool quiet = false;
};

StacksCase stacksCase(const EvaluateOptions& o) {
  StacksCase chosen = o.stacks;
  if (o.orthogonal > 0) chosen.stacks = o.orthogonal;
  if (o.thickness > 0) chosen.thickness = o.thickness;
  chosen.noise = o.noise;
  chosen.seed = o.settings.seed;
  return chosen;
}

HeldOutCase heldOutCase(const EvaluateOptions& o) {
  HeldOutCase chosen;
  chosen.noise = o.noise;
  if (o.orthogonal > 0) {
    chosen.kind = HeldOutCase::Kind::Orthogonal;
    chosen.stacks = o.orthogonal;
    chosen.factor = o.thickness > 0 ? o.thickness : 4;
  } else if (o.thickness > 0) {
    chosen.kind = HeldOutCase::Kind::Thick;
    chosen.factor = o.thickness;
  } else {
    chosen.factor = o.keepEvery > 0 ? o.keepEvery : 4;
  }
  return chosen;
}

const MethodScore& gaussiansOf(const EvaluationReport& report) {
  for (const auto& method : report.methods)
    if (method.name == "gaussians") return method;
  throw Error(ErrorCode::Internal, "The evaluation has no Gaussians to save.");
}

int evaluate(const EvaluateOptions& o) {
  const bool keep = !o.picture.empty() || !o.saveVolume.empty() || !o.saveModel.empty();
  if (keep && (o.baselinesOnly || o.protocol == Protocol::Both))
    throw CLI::ValidationError(
        "evaluate", "--picture, --save-volume and --save-model need one protocol and the Gaussians");
  const bool scans = o.protocol == Protocol::Scans;
  if (!scans && (o.volumes.size() > 1 || !o.masks.empty()))
    throw CLI::ValidationError("evaluate", "several volumes and --mask need --protocol scans");
  if (scans && (o.baselinesOnly || o.uncertainty || !o.picture.empty()))
    throw CLI::ValidationError("evaluate",
                               "--protocol scans has no --baselines-only, --uncertainty or --picture");
  OutputFiles files;
  for (const auto& path : o.volumes)
    files.read(path);
  for (const auto& path : o.masks)
    files.read(path);
  files.add(o.saveVolume, OutputFiles::Kind::Volume);
  files.add(o.saveModel, OutputFiles::Kind::Model);
  files.add(o.picture, OutputFiles::Kind::Png);
  files.add(o.csv);
  files.add(o.json);
  checkSettings(o.settings);

  ProgressDisplay display(o.quiet);
  Interrupt interrupt;
  EvaluationOptions options;
  options.settings = o.settings;
  options.gaussians = !o.baselinesOnly;
  options.uncertainty = o.uncertainty;
  options.totalVariation = true;
  options.keepVolumes = keep;
  options.heldOutFraction = o.heldOut.value_or(scans ? 0.2 : 0.05);
  options.progress = [&](const Progress& progress) { display.show(progress); };
  options.onMethod = [&](const std::string& name) { display.say("Running " + name); };
  options.stop = interrupt.token();
  std::vector<EvaluationReport> reports;
  if (scans) {
    std::vector<Stack> stacks;
    for (const auto& path : o.volumes)
      stacks.push_back(readStack(path, o.reading));
    std::vector<Mask> masks;
    for (const auto& path : o.masks)
      masks.push_back(readMask(path));
    reports.push_back(evaluateScans(stacks, masks, options));
  }
  const Volume volume = scans ? Volume{} : readVolume(o.volumes.front(), o.reading);
  if (o.protocol == Protocol::Stacks) reports.push_back(evaluateStacks(volume, stacksCase(o), options));
  if (o.protocol == Protocol::HeldOut || o.protocol == Protocol::Both)
    reports.push_back(evaluateHeldOut(volume, heldOutCase(o), options));
  if (o.protocol == Protocol::Paper || o.protocol == Protocol::Both)
    reports.push_back(evaluatePaper(volume, options));
  display.finish();

  std::cout << textReport(reports) << std::flush;
  const auto& report = reports.front();
  files.write(o.saveVolume, [&](const auto& path) { writeVolume(*gaussiansOf(report).volume, path); });
  files.write(o.saveModel, [&](const auto& path) { writeModel(*report.model, path); });
  files.write(o.picture, [&](const auto& path) {
    const auto name = utf8(std::filesystem::path(o.volumes.front()).filename());
    const Picture picture = comparisonPicture(report, fmt::format("{}, {}", name, report.caseName));
    writePng(path, picture.width, picture.height, 3, picture.rgb);
  });
  files.write(o.csv, [&](const auto& path) { writeFileAtomically(path, csvReport(reports)); });
  files.write(o.json, [&](const auto& path) { writeFileAtomically(path, jsonReport(reports)); });
  files.check();
  return Success;
}

} // namespace

Subcommand addEvaluate(CLI::App& app) {
  auto* command = app.add_subcommand(
      "evaluate", "Measures the quality against a known truth, compared with classic methods");
  auto o = std::make_shared<EvaluateOptions>();
  addOption(*command, "volume", o->volumes, "VOLUME",
            "The truth: the volume that input is taken from; with --protocol scans, two scans or more")
      ->required();
  addReading(*command, o->reading);
  addChoice<Protocol>(
      *command, "--protocol", o->protocol,
      {{"held-out", Protocol::HeldOut},
       {"paper", Protocol::Paper},
       {"both", Protocol::Both},
       {"stacks", Protocol::Stacks},
       {"scans", Protocol::Scans}},
      "held-out: the held-out data are hidden in every plane; paper: held out per plane, so that the\nother "
      "planes still show them; stacks: thick scans at right angles of a patient who moves; scans: "
      "slices\nheld out from several real scans, predicted from the rest and from their average [held-out]");
  auto* keepEvery =
      addOption(*command, "--keep-every", o->keepEvery, "K",
                "Held-out: keep every k-th axial slice, score on the others [4, without other case]")
          ->check(CLI::Range(2, 64));
  addOption(*command, "--thickness", o->thickness, "K",
            "Held-out: slices averaged over k voxels, score on the whole volume; stacks: mm [5]")
      ->check(CLI::Range(2, 64))
      ->excludes(keepEvery);
  addOption(*command, "--orthogonal", o->orthogonal, "N",
            "Held-out: this many thick scans at right angles, with --thickness [4]; stacks: [3]")
      ->check(CLI::Range(2, 3))
      ->excludes(keepEvery);
  addOption(*command, "--noise", o->noise, "SD",
            "Held-out, stacks: standard deviation of noise added to the input, image units [0]")
      ->check(CLI::NonNegativeNumber);
  addOption(*command, "--withheld", o->heldOut, "F",
            "Paper: fraction of each plane's slices held out [0.05]; scans: of each scan's, a third "
            "at most [0.2]")
      ->check(CLI::Range(0.001, 0.5));
  addOption(*command, "--mask", o->masks, "IMAGE",
            "Scans: fit and score inside this mask, or one per scan in their order; give it after them");
  const auto amount = [&](const char* name, double& target, const char* unit, const char* help) {
    addOption(*command, name, target, unit, help)->check(CLI::NonNegativeNumber);
  };
  amount("--gap", o->stacks.gap, "MM", "Stacks: distance between slices [0]");
  addOption(*command, "--pixels", o->stacks.pixels, "MM",
            "Stacks: size of each one's pixels, separated by commas [the volume's voxels]")
      ->delimiter(',')
      ->check(CLI::NonNegativeNumber);
  command->add_flag("--interpolated", o->stacks.interpolated,
                    "Stacks: --pixels are then interpolated to the volume's voxels, as scanners may do");
  amount("--motion", o->stacks.motion, "MM", "Stacks: largest shift of a slice along each axis [0]");
  amount("--turn", o->stacks.turn, "DEG", "Stacks: largest turn of a slice about each axis [0]");
  addOption(*command, "--motion-packets", o->stacks.motionPackets, "N",
            "Stacks: number of interleaved packets whose slices move together [0: every slice moves "
            "by itself]")
      ->check(CLI::Range(0, 10'000));
  amount("--shading", o->stacks.shading, "F",
         "Stacks: the brightness of each scan varies smoothly by up to ± this share [0]");
  amount("--slice-gain", o->stacks.gain, "F", "Stacks: each slice is multiplied by 1 ± up to this [0]");
  addOption(*command, "--central", o->stacks.central, "N",
            "Stacks: edge of the cube in the middle that is scanned, in voxels [all]")
      ->check(CLI::Range(16, 4096));
  command->add_flag(
      "--uncertainty", o->uncertainty,
      "Held-out, stacks: also how often the stated uncertainty of the Gaussians holds; takes a second fit");
  command->add_flag("--baselines-only", o->baselinesOnly, "Leave out the Gaussians");
  addOption(*command, "--csv", o->csv, "FILE", "Table to write as CSV");
  addOption(*command, "--json", o->json, "FILE", "Table to write as JSON");
  addOption(*command, "--picture", o->picture, "FILE",
            "PNG to write: three planes of input, result, truth and errors");
  addOption(*command, "--save-volume", o->saveVolume, "FILE",
            "The Gaussians' volume: .nii, .nii.gz, .nrrd or .mha");
  addOption(*command, "--save-model", o->saveModel, "FILE", "The Gaussians' model (.innergs)");
  command->add_flag("-q,--quiet", o->quiet, "No progress; the table only");
  addSettings(*command, o->settings);
  command->footer(
      "PSNR in dB on the range of the truth, pooled over the body (held-out) or a mean over slices (paper);\n"
      "SSIM with an 11x11 window of sigma 1.5 on slices.\n"
      "Examples:\n"
      "  innergs evaluate t1.nii.gz --keep-every 4\n"
      "  innergs evaluate t1.nii.gz --thickness 4 --csv table.csv\n"
      "  innergs evaluate t1.nii.gz --orthogonal 3 --thickness 5 --picture result.png --json table.json\n"
      "  innergs evaluate t1.nii.gz --protocol stacks --motion 3 --turn 3 --central 120 --noise 10\n"
      "  innergs evaluate a.nii.gz b.nii.gz --protocol scans --mask a-brain.nii.gz b-brain.nii.gz\n"
      "  innergs evaluate t1.nii.gz --protocol paper --gaussians 74088");
  return {command, [o] { return evaluate(*o); }};
}

} // namespace innergs::cli
