#include "CLI/Command.h"
#include "CLI/Interrupt.h"
#include "CLI/ProgressDisplay.h"
#include "CLI/ReconstructReport.h"
#include "CLI/ScanRemarks.h"
#include "CLI/Version.h"

#include "Core/Base/Error.h"
#include "Core/Image/Region.h"
#include "Core/Job/JobInput.h"
#include "Core/Settings/SettingsTable.h"
#include "IO/AtomicFile.h"
#include "IO/FilePath.h"
#include "IO/ModelFile.h"
#include "IO/N4Correction.h"
#include "IO/OutputFiles.h"
#include "IO/Ply.h"
#include "IO/SliceFiles.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <utility>

namespace innergs::cli {
namespace {

// Rejects here everything that can be rejected without reading a voxel.
OutputFiles checkedOutputs(const ReconstructOptions& options) {
  if (options.output.empty() && options.saveModel.empty() && options.ply.empty())
    throw CLI::ValidationError("reconstruct", "needs --output, --save-model or --ply");
  for (const double mm : options.thickness)
    if (!(mm > 0))
      throw Error(ErrorCode::InvalidArgument,
                  "--thickness must be above 0 mm: leave it out for the distance between the slices, or give "
                  "--profile point for infinitely thin ones.");
  for (std::size_t n = 1; n < options.inputs.size(); ++n)
    for (std::size_t before = 0; before < n; ++before)
      if (isSameFile(options.inputs[before], options.inputs[n]) &&
          !(options.series.size() > 1 && std::filesystem::is_directory(options.inputs[n])))
        throw Error(ErrorCode::InvalidArgument,
                    innergs::quoted(options.inputs[n]) + " is given twice; give each scan once.");
  OutputFiles files;
  for (const auto& input : options.inputs)
    files.read(input);
  for (const auto& mask : options.masks)
    files.read(mask);
  files.read(options.calibration);
  files.read(options.grid.reference);
  files.add(options.saveModel, OutputFiles::Kind::Model); // before read(): may be the resumed model itself
  files.read(options.resume);
  files.add(options.output, OutputFiles::Kind::Volume);
  files.add(options.ply, OutputFiles::Kind::Ply);
  files.add(options.uncertainty, OutputFiles::Kind::Volume);
  files.add(options.measured, OutputFiles::Kind::Volume);
  files.add(options.slices);
  files.add(options.report);
  checkSettings(options.settings);
  checkHeldOutFraction(options.heldOut);
  return files;
}

std::vector<Stack> readScans(const ReconstructOptions& options) {
  const auto count = options.inputs.size();
  if (options.thickness.size() > 1 && options.thickness.size() != count)
    throw Error(ErrorCode::InvalidArgument,
                fmt::format("--thickness has {} numbers for {} scan{}: give one, or one per scan.",
                            options.thickness.size(), count, count == 1 ? "" : "s"));
  const auto folders = std::count_if(options.inputs.begin(), options.inputs.end(),
                                     [](const auto& input) { return std::filesystem::is_directory(input); });
  const auto& series = options.series;
  if (!series.empty() && (folders == 0 || (series.size() > 1 && std::ssize(series) != folders)))
    throw Error(ErrorCode::InvalidArgument,
                fmt::format("--series has {} number{} for {} DICOM folder{}: give one, or one per folder.",
                            series.size(), series.size() == 1 ? "" : "s", folders, folders == 1 ? "" : "s"));
  std::vector<Stack> stacks;
  std::size_t folder = 0;
  for (std::size_t n = 0; n < count; ++n) {
    ReadOptions reading{options.frame};
    reading.calibration = options.calibration;
    if (!series.empty() && std::filesystem::is_directory(options.inputs[n]))
      reading.series = series[series.size() == 1 ? 0 : folder++];
    Stack stack = readStack(options.inputs[n], reading);
    if (!options.thickness.empty()) {
      stack.thickness = options.thickness[options.thickness.size() == 1 ? 0 : n];
      stack.thicknessFrom = "--thickness";
    }
    if (options.profile) stack.profile = *options.profile;
    if (stack.name.empty()) stack.name = options.inputs[n];
    stacks.push_back(std::move(stack));
  }
  if (!options.calibration.empty() &&
      std::all_of(stacks.begin(), stacks.end(), [](const Stack& stack) { return stack.poses.empty(); }))
    throw Error(ErrorCode::InvalidArgument,
                "--calibration is for tracked ultrasound, but no scan is: leave it out.");
  return stacks;
}

bool asksForUncertainty(const ReconstructOptions& options) {
  return !options.uncertainty.empty() || !options.measured.empty();
}

// Crops the stacks: a region needs only the voxels in and around it.
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
  input.uncertainty = asksForUncertainty(options);
  input.n4 = correctByN4;
  if (!options.resume.empty()) input.resume = std::make_shared<const Model>(readModel(options.resume));
  input.stacks = readScans(options);
  for (std::size_t n = 0; n < input.stacks.size(); ++n)
    scans.push_back(record(options.inputs[n], input.stacks[n]));
  for (const auto& mask : options.masks)
    input.masks.push_back(readMask(mask));
  if (options.grid.given())
    input.outputGrid = options.grid.choose(acquisitionGrid(input.stacks), defaultOutputGrid(input.stacks));
  if (!options.grid.roi.empty()) keepRegion(input.stacks, options.grid.region());
  input.cropToMask = options.grid.reference.empty() && options.grid.roi.empty();
  return input;
}

// The values that an integer type must hold; non-finite voxels get the fill value.
VoxelValues valuesOf(const std::vector<Stack>& stacks) {
  VoxelValues values(stacks.front().image.voxels);
  for (std::size_t n = 1; n < stacks.size(); ++n)
    values.join(VoxelValues(stacks[n].image.voxels));
  values.notFinite = 0;
  return values;
}

ModelNotes notesOf(const ReconstructOptions& options, const ReconstructionResult& result) {
  const auto names = [](const std::vector<std::string>& paths) {
    std::string text;
    for (const auto& path : paths)
      text += (text.empty() ? "" : "; ") + utf8(std::filesystem::path(path).filename());
    return text;
  };
  return notesOf(result, names(options.inputs), names(options.masks),
                 settingsText(result.settings, options.heldOut));
}

// Adds to the result's warnings. Writes the report last, as it names the files that exist.
void writeResults(const ReconstructOptions& options, const std::vector<ScanRecord>& scans,
                  const VoxelValues& values, ReconstructionResult& result, const ProgressDisplay& display,
                  OutputFiles& files) {
  ReconstructOptions named = options;
  const auto write = [&](std::string ReconstructOptions::*file,
                         const std::function<void(const std::filesystem::path&)>& writer) {
    if (!files.write(options.*file, writer)) (named.*file).clear();
  };
  const auto note = [&](const std::string& sentence) {
    if (!sentence.empty()) result.warnings.push_back(sentence);
  };
  write(&ReconstructOptions::saveModel,
        [&](const auto& path) { writeModel(*result.model, path, notesOf(options, result)); });
  write(&ReconstructOptions::output,
        [&](const auto& path) { note(writeVolume(result.volume, path, options.type, values)); });
  write(&ReconstructOptions::ply, [&](const auto& path) {
    writePly(result.model->field, path);
    note(droppedByPly(result.model->field));
  });
  if (const auto& u = result.uncertainty) {
    write(&ReconstructOptions::uncertainty, [&](const auto& path) { writeVolume(u->deviation, path); });
    write(&ReconstructOptions::measured, [&](const auto& path) {
      writeVolume({u->deviation.geometry, {u->measured.begin(), u->measured.end()}}, path, OutputType::UInt8);
    });
  } else {
    named.uncertainty.clear();
    named.measured.clear();
  }
  write(&ReconstructOptions::slices,
        [&](const auto& path) { writeFileAtomically(path, sliceTable(foundSlices(result))); });
  write(&ReconstructOptions::transforms,
        [&](const auto& path) { writeTransforms(foundSlices(result), path); });
  for (const auto& warning : result.warnings)
    warn(warning);
  for (const auto& failure : files.failures())
    note(failure);
  files.write(options.report, [&](const auto& path) {
    writeFileAtomically(path, reconstructReport(named, scans, result, display.phases()).dump(2) + "\n");
  });
}

int reconstruct(const ReconstructOptions& options) {
  OutputFiles files = checkedOutputs(options);
  ProgressDisplay display(options.quiet);
  Interrupt interrupt;
  std::vector<ScanRecord> scans;
  ReconstructionInput input = readInput(options, scans);
  VoxelValues values = valuesOf(input.stacks);
  if (!input.masks.empty()) {
    const double span = values.span; // of the scanned values
    values.join(VoxelValues(std::array{static_cast<float>(options.settings.fill)}));
    values.span = span;
  }
  checkType(options.type, values, input.stacks.size() == 1 ? "the scan" : "the scans");
  std::vector<std::string> remarks = scanRemarks(input.stacks, options.settings);
  ReconstructionJob job(std::move(input), options.settings);
  job.onProgress([&](const Progress& progress) {
    if (progress.phase != Phase::Preparing) // an error in that phase gets its own single line
      for (const std::string& remark : std::exchange(remarks, {}))
        display.say(remark);
    display.show(progress);
  });
  ReconstructionResult result = job.run(interrupt.token(), !options.output.empty());
  display.finish();
  if (result.cancelled && (!result.model || result.model->field.gaussians.empty()))
    throw Error(ErrorCode::Cancelled, "Interrupted before the fit began; nothing was written.");
  writeResults(options, scans, values, result, display, files);
  files.check();
  if (result.cancelled) {
    fmt::print(stderr, "innergs: Interrupted after {} of {} iterations; the result so far is in {}.\n",
               result.iterations,
               result.settings.iterations.value_or(0) * result.settings.ensembleSize.value_or(1),
               files.written());
    return Interrupted;
  }
  display.say(fmt::format("{} Gaussians, {} iterations, {}. {}\nWrote {}.", result.model->field.size(),
                          result.iterations, durationText(result.seconds), qualitySentence(result),
                          files.written()));
  if (!result.profiles.sentence.empty()) display.say(result.profiles.sentence);
  if (const std::string said = agreementSentence(result.agreement); !said.empty()) display.say(said);
  if (result.uncertainty) display.say("Uncertainty: " + uncertaintySentence(*result.uncertainty));
  const bool unknown = asksForUncertainty(options) && !result.uncertainty && interrupt.requested();
  return unknown || result.judging == Judging::Stopped ? Interrupted : Success;
}

} // namespace

Subcommand addReconstruct(CLI::App& app) {
  auto* command =
      app.add_subcommand("reconstruct", "Reconstructs a volume and a continuous model from scans");
  auto options = std::make_shared<ReconstructOptions>();
  addOptions(*command, *options);
  return {command, [options] { return reconstruct(*options); }};
}

} // namespace innergs::cli
