#include "CLI/Command.h"
#include "CLI/Interrupt.h"
#include "CLI/Options.h"
#include "CLI/ProgressDisplay.h"
#include "CLI/ReconstructReport.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Motion/DynamicJob.h"
#include "Core/Motion/FrameRenderer.h"
#include "Core/Motion/MotionField.h"
#include "IO/AtomicFile.h"
#include "IO/DynamicModelFile.h"
#include "IO/FilePath.h"
#include "IO/MotionFieldIO.h"
#include "IO/OutputFiles.h"
#include "IO/TimeSeriesIO.h"
#include "IO/TimeSeriesWriting.h"

#include <spdlog/fmt/fmt.h>

#include <algorithm>

namespace innergs::cli {
namespace {

struct InterpolateOptions {
  std::string input, output, saveModel, report, motion, resume, sliceTimes;
  std::vector<double> times;
  std::optional<double> rate, at, motionFrom;
  TimeSeriesOptions reading;
  GridOptions grid;
  OutputType type = OutputType::Float32;
  Settings settings;
  bool quiet = false;
};

/// The requested times, checked against the time that the frames cover.
std::vector<double> outputTimes(const InterpolateOptions& o, const std::vector<double>& frames) {
  if (o.at) return checkedTimes({*o.at}, frames);
  return o.times.empty() ? timesAtRate(o.rate.value_or(0), frames) : checkedTimes(o.times, frames);
}

OutputFiles checkedOutputs(const InterpolateOptions& o) {
  if (o.output.empty() && o.saveModel.empty() && o.motion.empty())
    throw CLI::ValidationError("interpolate", "needs --output, --motion or --save-model");
  if (!o.motion.empty() && o.settings.kind == DynamicKind::Intensity)
    throw CLI::ValidationError("interpolate",
                               "--motion needs Gaussians that move: leave out --kind intensity");
  if (o.motionFrom && o.motion.empty())
    throw CLI::ValidationError("interpolate", "--motion-from needs --motion");
  if (!o.motion.empty()) motionFiles(o.motion, 1); // checks its extension
  if ((o.times.empty() ? 0 : 1) + (o.rate ? 1 : 0) + (o.at ? 1 : 0) > 1)
    throw CLI::ValidationError("interpolate", "takes one of --times, --rate and --at");
  if (o.rate && !(std::isfinite(*o.rate) && *o.rate > 0))
    throw Error(ErrorCode::InvalidArgument, "--rate must be above 0 frames per second.");
  checkSettings(o.settings);
  OutputFiles files;
  files.read(o.input);
  if (!std::filesystem::is_directory(o.input)) files.read(sidecarOf(o.input));
  files.read(o.sliceTimes);
  files.add(o.saveModel, OutputFiles::Kind::Model); // before read(): may be the resumed model itself
  files.read(o.resume);
  files.read(o.grid.reference);
  if (!o.output.empty()) {
    if (!o.at) checkTimeSeriesPath(o.output);
    files.add(o.output, o.at ? OutputFiles::Kind::Volume : OutputFiles::Kind::Any);
  }
  files.add(o.report);
  return files;
}

/// Adds the outputs that depend on the times.
void addTimed(const InterpolateOptions& o, const std::vector<double>& times, OutputFiles& files) {
  if (!o.output.empty() && !o.at && needsSidecar(o.output, times)) files.add(sidecarOf(o.output));
  if (!o.motion.empty())
    for (const auto& file : motionFiles(o.motion, times.size()))
      files.add(file);
}

MotionSequence motionOf(const DynamicField& field, const std::vector<double>& times, const GridGeometry& grid,
                        const InterpolateOptions& o, const std::stop_token& stop) {
  const double from = o.motionFrom.value_or(middleTime(field));
  const double slack = 1e-6 * std::max(1.0, field.times.back() - field.times.front());
  if (from < field.times.front() - slack || from > field.times.back() + slack)
    throw Error(ErrorCode::InvalidArgument, "--motion-from lies outside the time that the frames cover.");
  checkMemory(24 * grid.voxelCount() * static_cast<std::int64_t>(times.size()), "The motion");
  MotionSequence motion{grid, times, {}};
  for (const double time : times)
    motion.fields.push_back(motionField(field, from, time, grid, o.settings.threads, stop));
  return motion;
}

TimeSeries rendered(const DynamicField& field, const std::vector<double>& times, const GridGeometry& grid,
                    const InterpolateOptions& o, std::stop_token stop) {
  checkMemory(4 * grid.voxelCount() * static_cast<std::int64_t>(times.size()), "The frames");
  TimeSeries series{grid, {}, times, {}, {}};
  RenderOptions render;
  render.threads = o.settings.threads;
  render.instructionSet = o.settings.instructionSet;
  render.stop = std::move(stop);
  FrameRenderer renderer(field, grid, render, o.settings.device);
  for (const double time : times)
    series.frames.push_back(renderer.at(time));
  warn(renderer.problem());
  return series;
}

VoxelValues valuesOf(const std::vector<std::vector<float>>& frames) {
  VoxelValues values(frames.front());
  for (std::size_t f = 1; f < frames.size(); ++f)
    values.join(VoxelValues(frames[f]));
  values.notFinite = 0;
  return values;
}

nlohmann::ordered_json reportOf(const InterpolateOptions& o, const DynamicField& field,
                                const DynamicResult& result, const std::vector<double>& times) {
  nlohmann::ordered_json report;
  report["command"] = "interpolate";
  report["versions"] = versions();
  report["input"] = o.input;
  report["output"] = o.output;
  report["model"] = o.saveModel;
  report["motion"] = o.motion;
  if (!o.motion.empty()) report["motion_from_s"] = o.motionFrom.value_or(middleTime(field));
  report["kind"] = dynamicKindName(field.kind);
  report["choice"] = result.choice;
  report["gaussians"] = field.size();
  report["coefficients_in_time"] = coefficientsInTime(field);
  report["frame_times_s"] = field.times;
  report["output_times_s"] = times;
  report["training_psnr_db"] = result.seconds > 0 ? nlohmann::ordered_json(result.trainingPsnr) : nullptr;
  report["training_psnr_note"] = "on the frames that were fitted, not on held-out ones";
  report["slice_times_used"] = result.slicesTimed;
  report["notes"] = result.notes;
  report["settings"] = toJson(result.settings, true);
  report["seconds"] = result.seconds;
  report["device"] = result.seconds > 0 ? toJson(result.device) : nullptr;
  report["threads"] = result.threads;
  report["instruction_set"] = result.instructionSet;
  return report;
}

int interpolate(const InterpolateOptions& o) {
  OutputFiles files = checkedOutputs(o);
  ProgressDisplay display(o.quiet);
  Interrupt interrupt;
  DynamicResult result;
  ModelNotes notes;
  std::optional<VoxelValues> expected;
  std::optional<FeatureModel> features; // of the model that was read
  std::vector<double> times;
  if (isDynamicModel(o.input)) {
    if (!o.resume.empty()) throw CLI::ValidationError("--resume", "takes the scan as its input, not a model");
    if (!o.sliceTimes.empty())
      throw CLI::ValidationError("--slice-times", "takes the scan as its input, not a model");
    result.field =
        std::make_shared<const DynamicField>(readDynamicModel(o.input, &notes, &result.state, &features));
    times = outputTimes(o, result.field->times);
    addTimed(o, times, files);
  } else {
    TimeSeriesOptions reading = o.reading;
    reading.sliceTimes = o.sliceTimes;
    TimeSeries series = readTimeSeries(o.input, reading);
    warn(remarkOnPairs(series));
    times = outputTimes(o, series.times);
    addTimed(o, times, files);
    expected = valuesOf(series.frames);
    checkType(o.type, *expected, "the scan");
    DynamicJob job(std::move(series), o.settings);
    if (!o.resume.empty()) job.resume(readStoppedFit(o.resume));
    job.onProgress([&](const Progress& progress) { display.show(progress); });
    result = job.run(interrupt.token());
    display.finish();
    if (!result.field)
      throw Error(ErrorCode::Cancelled, "Interrupted before there was a model; nothing was written.");
    if (!result.choice.empty()) display.say(result.choice);
    for (const std::string& note : result.notes)
      warn(note);
    notes = notesOf(result, utf8(std::filesystem::path(o.input).filename()));
    if (!result.cancelled) result.state = {};
  }
  const DynamicField& field = *result.field;
  files.write(o.saveModel, [&](const auto& path) {
    writeDynamicModel(field, path, notes, result.state, features ? &*features : nullptr);
  });
  files.write(o.output, [&](const auto& path) {
    const GridGeometry grid = o.grid.choose(field.canonical.region(), field.canonical.region());
    // Writes the result so far even after a stop.
    TimeSeries frames =
        rendered(field, times, grid, o, result.cancelled ? std::stop_token{} : interrupt.token());
    warn(o.at ? writeVolume({grid, std::move(frames.frames.front())}, path, o.type, expected)
              : writeTimeSeries(frames, path, o.type, expected));
  });
  files.write(o.motion, [&](const auto& path) {
    const GridGeometry grid = o.grid.choose(field.canonical.region(), field.canonical.region());
    writeMotion(motionOf(field, times, grid, o, result.cancelled ? std::stop_token{} : interrupt.token()),
                path);
  });
  files.write(o.report, [&](const auto& path) {
    writeFileAtomically(path, reportOf(o, field, result, times).dump(2) + "\n");
  });
  files.check();
  if (result.cancelled) {
    fmt::print(stderr, "innergs: Interrupted; the result so far is in {}.\n", files.written());
    return Interrupted;
  }
  display.say(fmt::format("{} Gaussians ({}), {} frames from {} s to {} s. Wrote {}.", field.size(),
                          dynamicKindName(field.kind), times.size(), numberText(times.front()),
                          numberText(times.back()), files.written()));
  return Success;
}

} // namespace

Subcommand addInterpolate(CLI::App& app) {
  auto* command = app.add_subcommand("interpolate",
                                     "Interpolates a dynamic scan at any time and fits a continuous model");
  auto o = std::make_shared<InterpolateOptions>();
  addOption(*command, "input", o->input, "SCAN",
            "4D NIfTI or MINC2, .seq.nrrd, a folder with one image per frame and times.txt, or a\n"
            "model that --save-model wrote")
      ->required();
  addOption(*command, "-o,--output", o->output, "FILE",
            "Frames to write: .nii.gz, .nii or .seq.nrrd; with --at one volume, .mha and .nrrd too");
  addOption(*command, "--save-model", o->saveModel, "FILE", "Model of space and time to write (.innergs)");
  addOption(*command, "--report", o->report, "FILE", "JSON report to write");
  addOption(*command, "--motion", o->motion, "FILE",
            "Motion at the output's times to write, as ITK's displacement fields (mm, LPS): resampling\n"
            "the volume at a time through its field gives the one at --motion-from. One .seq.nrrd, or\n"
            "one .nrrd, .nii.gz, .nii or .mha per time, numbered");
  addOption(*command, "--motion-from", o->motionFrom, "S",
            "Time in s that --motion leads from [the middle frame's]");
  addNumbers(*command, "--times", o->times, {}, "S",
             "Times of the output's frames in s, as a,b,c [those of the input]");
  addOption(*command, "--rate", o->rate, "HZ",
            "Frames per second of the output, over all of the input's time");
  addOption(*command, "--at", o->at, "S", "One volume at this time in s");
  addNumbers(*command, "--frame-times", o->reading.times, {}, "S",
             "Times of the input's frames in s [from the file]");
  addOption(*command, "--frame-interval", o->reading.interval, "S",
            "Time from one frame of the input to the next in s [from the file]");
  addOption(*command, "--slice-times", o->sliceTimes, "FILE",
            "When the slices of a frame were acquired: BIDS's .json, or text with one time in s per\n"
            "slice [the .json beside the input, or its header]");
  addOption(*command, "--resume", o->resume, "MODEL",
            "Resume from a model that an interrupted run of the same scan and settings saved");
  o->grid.add(*command, "the frames' own grid");
  addOutputType(*command, o->type);
  for (const Setting& row : settingsTable())
    if (concernsDynamicScans(row)) addSetting(*command, o->settings, row.name);
  command->add_flag("-q,--quiet", o->quiet, "Print only errors");
  command->footer("Examples:\n  innergs interpolate wrist.nii.gz --rate 10 -o smooth.seq.nrrd\n  innergs "
                  "interpolate bold.nii.gz --kind intensity --times 1,3,5 -o between.nii.gz\n  innergs "
                  "interpolate bold.nii.gz --kind intensity --slice-times task.json -o even.nii.gz\n  "
                  "innergs interpolate frames/ --save-model wrist.innergs -o frames.nii.gz\n  innergs "
                  "interpolate wrist.innergs --motion motion.nii.gz --motion-from 0\n  innergs interpolate "
                  "wrist.innergs --at 4.25 --spacing 1 -o moment.nii.gz\nCtrl-C stops the fit; once frames "
                  "are refined together, it writes the model so far,\nand --resume continues from it.");
  return {command, [o] { return interpolate(*o); }};
}

} // namespace innergs::cli
