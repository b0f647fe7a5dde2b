#include "CLI/Command.h"
#include "CLI/Interrupt.h"
#include "CLI/ProgressDisplay.h"
#include "CLI/ReconstructReport.h"
#include "CLI/Version.h"

#include "Core/Error.h"
#include "Core/JobInput.h"
#include "Core/Region.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/Ply.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace innergs::cli {
namespace {

// Everything that can be refused without reading a voxel is refused here.
void checkOutputs(const ReconstructOptions& options) {
  if (options.output.empty() && options.saveModel.empty() && options.ply.empty())
    throw CLI::ValidationError("reconstruct", "needs --output, --save-model or --ply");
  if (!options.output.empty()) checkVolumePath(options.output);
  for (const auto& path : {options.saveModel, options.ply, options.report})
    if (!path.empty()) checkOutputFolder(path);
  checkSettings(options.settings);
}

std::vector<Stack> readScans(const ReconstructOptions& options) {
  const auto count = options.inputs.size();
  if (options.thickness.size() > 1 && options.thickness.size() != count)
    throw Error(ErrorCode::InvalidArgument,
                fmt::format("--thickness has {} numbers for {} scan{}: give one, or one per scan.",
                            options.thickness.size(), count, count == 1 ? "" : "s"));
  std::vector<Stack> stacks;
  for (std::size_t n = 0; n < count; ++n) {
    Stack stack = readStack(options.inputs[n], {options.frame});
    if (!options.thickness.empty())
      stack.thickness = options.thickness[options.thickness.size() == 1 ? 0 : n];
    if (options.profile) stack.profile = *options.profile;
    if (stack.name.empty()) stack.name = options.inputs[n];
    stacks.push_back(std::move(stack));
  }
  return stacks;
}

// A region needs only the voxels in and around it.
void keepRegion(std::vector<Stack>& stacks, const Region& region) {
  double margin = 0;
  for (const auto& stack : stacks)
    margin = std::max({margin, 2 * stack.thickness, 2 * stack.image.geometry.spacing[2]});
  for (auto& stack : stacks)
    stack = cropped(stack, region, margin);
}

ReconstructionInput readInput(const ReconstructOptions& options, std::vector<ScanRecord>& scans) {
  ReconstructionInput input;
  input.heldOutFraction = options.heldOut;
  if (!options.resume.empty()) input.resume = std::make_shared<const Checkpoint>(readModel(options.resume));
  input.stacks = readScans(options);
  for (std::size_t n = 0; n < input.stacks.size(); ++n)
    scans.push_back(record(options.inputs[n], input.stacks[n]));
  if (!options.mask.empty()) input.mask = readMask(options.mask);
  if (options.grid.given())
    input.outputGrid =
        options.grid.choose(input.stacks.front().image.geometry, defaultOutputGrid(input.stacks));
  if (const auto& roi = options.grid.roi; !roi.empty())
    keepRegion(input.stacks, Region{{roi[0], roi[2], roi[4]}, {roi[1], roi[3], roi[5]}});
  return input;
}

ModelNotes notesOf(const ReconstructOptions& options, const ReconstructionResult& result) {
  std::string inputs;
  for (const auto& path : options.inputs)
    inputs += (inputs.empty() ? "" : "; ") + utf8(std::filesystem::path(path).filename());
  const auto decibels = [](double psnr) { return fmt::format("{:.3f}", psnr); };
  ModelNotes notes{{"Version", INNERGS_VERSION},
                   {"Inputs", inputs},
                   {"Settings", settingsText(result.settings, options.heldOut)},
                   {"InstructionSet", result.instructionSet},
                   {"Device", result.device.id},
                   {"TrainingPSNR", decibels(result.trainingPsnr)}};
  if (!std::isnan(result.heldOutPsnr)) notes["HeldOutPSNR"] = decibels(result.heldOutPsnr);
  return notes;
}

// The report goes last: it exists only when everything it names exists.
void writeResults(const ReconstructOptions& options, const std::vector<ScanRecord>& scans,
                  const ReconstructionResult& result, const ProgressDisplay& display) {
  if (!options.saveModel.empty()) writeModel(*result.checkpoint, options.saveModel, notesOf(options, result));
  if (!options.output.empty()) writeVolume(result.volume, options.output, options.type);
  if (!options.ply.empty()) writePly(result.checkpoint->field, options.ply);
  if (!options.report.empty())
    writeFileAtomically(options.report,
                        reconstructReport(options, scans, result, display.phases()).dump(2) + "\n");
}

std::string writtenFiles(const ReconstructOptions& options) {
  std::string files;
  for (const auto& path : {options.output, options.saveModel, options.ply, options.report})
    if (!path.empty()) files += (files.empty() ? "" : ", ") + path;
  return files;
}

int reconstruct(const ReconstructOptions& options) {
  checkOutputs(options);
  ProgressDisplay display(options.quiet);
  Interrupt interrupt;
  std::vector<ScanRecord> scans;
  ReconstructionJob job(readInput(options, scans), options.settings);
  job.onProgress([&](const Progress& progress) { display.show(progress); });
  const ReconstructionResult result = job.run(interrupt.token(), !options.output.empty());
  display.finish();
  for (const auto& warning : result.warnings)
    fmt::print(stderr, "innergs: warning: {}\n", warning);
  if (result.cancelled && (!result.checkpoint || result.checkpoint->field.gaussians.empty()))
    throw Error(ErrorCode::Cancelled, "Interrupted before the fit began; nothing was written.");
  writeResults(options, scans, result, display);
  if (!options.ply.empty() && !result.checkpoint->field.detail.voxels.empty())
    fmt::print(stderr, "innergs: warning: The PLY file holds the Gaussians alone; only a model file keeps "
                       "their detail grid.\n");
  if (result.cancelled) {
    fmt::print(
        stderr, "innergs: Interrupted after {} of {} sweeps; what was reached is in {}.\n", result.iterations,
        result.settings.iterations.value_or(0) * result.settings.members.value_or(1), writtenFiles(options));
    return Interrupted;
  }
  display.say(fmt::format("{} Gaussians, {} sweeps, {}. {}\nWrote {}.", result.checkpoint->field.size(),
                          result.iterations, durationText(result.seconds), qualitySentence(result),
                          writtenFiles(options)));
  return Success;
}

} // namespace

Subcommand addReconstruct(CLI::App& app) {
  auto* command = app.add_subcommand("reconstruct", "Scans in, a volume and a continuous model out");
  auto options = std::make_shared<ReconstructOptions>();
  addOptions(*command, *options);
  return {command, [options] { return reconstruct(*options); }};
}

} // namespace innergs::cli
