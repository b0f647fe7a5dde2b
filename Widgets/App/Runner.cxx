#include "Widgets/App/Runner.h"

#include "Core/Base/Error.h"
#include "Core/Base/ThreadPriority.h"
#include "Core/Job/JobInput.h"
#include "Core/Settings/SettingsTable.h"
#include "Geometry.h"
#include "IO/ModelFile.h"
#include "IO/N4Correction.h"
#include "IO/RecoveredFit.h"
#include "ImageVoxels.h"
#include "SliceTable.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/Files.h"

#include <vtkNew.h>

#include <QMetaObject>

#include <algorithm>
#include <cmath>
#include <utility>

namespace innergs::app {
namespace {

int axisOf(const VolumeItem& item, const ui::InputChoice& choice) {
  return choice.sliceAxis >= 0 && choice.sliceAxis <= 2 ? choice.sliceAxis : item.sliceAxis;
}

Stack stackOf(const VolumeItem& item, const ui::InputChoice& choice, bool voxels) {
  Stack stack;
  stack.name = item.name.toStdString();
  stack.profile = static_cast<SliceProfile>(std::clamp(choice.sliceProfile, 0, 2));
  const int axis = axisOf(item, choice);
  stack.thickness = choice.sliceThickness;
  if (stack.thickness == 0 && axis == item.sliceAxis) stack.thickness = item.thickness;
  if (!item.unplaced.isEmpty())
    throw Error(ErrorCode::Geometry,
                Runner::tr("%1 Open it again to choose the file.").arg(item.unplaced).toStdString());
  if (!item.poses.empty() && axis != item.sliceAxis)
    throw Error(ErrorCode::InvalidArgument,
                Runner::tr("Each slice of '%1' lies at a place of its own: leave the axis of its slices at "
                           "auto.")
                    .arg(item.name)
                    .toStdString());
  stack.poses = item.poses;
  if (axis == item.sliceAxis) stack.times = item.times;
  if (!voxels)
    stack.image.geometry = withSliceAxis(item.volume->geometry, axis);
  else if (axis == 2)
    stack.image = *item.volume;
  else
    stack.image = withSliceAxis(*item.volume, axis);
  if (stack.image.geometry.size[2] < 2)
    throw Error(ErrorCode::UnsupportedImage,
                Runner::tr("'%1' has a single slice along the chosen axis; at least two are needed.")
                    .arg(item.name)
                    .toStdString());
  return stack;
}

GridGeometry outputGrid(const ReconstructionTask& task, std::span<const Stack> stacks) {
  switch (task.request.grid) {
  case ui::OutputGrid::Input:
    return task.inputs.front().volume->geometry;
  case ui::OutputGrid::Reference:
    return task.reference->volume->geometry;
  case ui::OutputGrid::Spacing: {
    const double s = task.request.spacing;
    return withSpacing(acquisitionGrid(stacks), {s, s, s});
  }
  default:
    return defaultOutputGrid(stacks);
  }
}

Mask maskOf(const Volume& volume) {
  std::vector<std::uint8_t> inside(volume.voxels.size());
  std::transform(volume.voxels.begin(), volume.voxels.end(), inside.begin(),
                 [](float v) { return static_cast<std::uint8_t>(v != 0 && !std::isnan(v)); });
  return {volume.geometry, std::move(inside)};
}

QStringList namesOf(const std::vector<VolumeItem>& items) {
  QStringList names;
  for (const VolumeItem& item : items)
    names << item.name;
  return names;
}

/// As in the notes of models.
std::string listed(const std::vector<VolumeItem>& items) {
  return namesOf(items).join(QStringLiteral("; ")).toStdString();
}

/// Without its file.
RecoveredFit recoveredFrom(const ReconstructionTask& task, const Model& model, int iterations) {
  RecoveredFit fit;
  fit.inputs = listed(task.inputs);
  fit.mask = listed(task.masks);
  fit.settings = task.request.settings;
  fit.iteration = model.iteration;
  fit.iterations = iterations;
  return fit;
}

} // namespace

ReconstructionInput makeInput(const ReconstructionTask& task, bool voxels) {
  ReconstructionInput input;
  for (std::size_t n = 0; n < task.inputs.size(); ++n)
    input.stacks.push_back(stackOf(task.inputs[n], task.request.inputs[static_cast<int>(n)], voxels));
  input.outputGrid = outputGrid(task, input.stacks);
  input.heldOutFraction = task.request.heldOutFraction;
  input.uncertainty = task.request.estimateUncertainty;
  input.n4 = correctByN4;
  input.cropToMask =
      task.request.grid == ui::OutputGrid::Automatic || task.request.grid == ui::OutputGrid::Spacing;
  for (const VolumeItem& mask : task.masks)
    input.masks.push_back(maskOf(*mask.volume));
  return input;
}

std::optional<int> keepEvery(const ReconstructionTask& task) {
  return task.request.evaluateQuality ? std::optional(task.request.qualityGap) : std::nullopt;
}

Runner::Runner(QObject* parent) : QObject(parent) {}

Runner::~Runner() {
  if (thread_.joinable()) {
    keep_ = true;
    thread_.request_stop();
    thread_.join();
  }
}

template <class Call>
void Runner::deliver(Call call) {
  QMetaObject::invokeMethod(this, std::move(call), Qt::QueuedConnection);
}

void Runner::start(ReconstructionTask task) {
  running_ = true;
  keep_ = false;
  latest_.clear();
  const QString problem = sentenceOf([&] {
    thread_ = std::jthread([this, task = std::move(task)](const std::stop_token& stop) { work(task, stop); });
  });
  if (problem.isEmpty()) return;
  deliver([this, problem] {
    running_ = false;
    Q_EMIT failed(problem);
  });
}

void Runner::cancel() {
  thread_.request_stop();
}

void Runner::stopAndKeep() {
  keep_ = true;
  cancel();
}

void Runner::post(const Progress& progress) {
  if (!latest_.put(progress)) return;
  deliver([this] {
    const auto progress = latest_.take();
    if (progress && running_) Q_EMIT progressed(*progress);
  });
}

void Runner::post(const Volume& preview) {
  vtkNew<vtkImageData> made;
  std::copy(preview.voxels.begin(), preview.voxels.end(), vtk::allocateFloats(made, preview.geometry, false));
  made->GetScalarRange();
  vtkNew<vtkMatrix4x4> matrix;
  vtk::toMatrix(preview.geometry, matrix);
  deliver([this, image = vtkSmartPointer<vtkImageData>(made), toRAS = vtkSmartPointer<vtkMatrix4x4>(matrix)] {
    if (running_) Q_EMIT previewed(image, toRAS);
  });
}

void Runner::work(const ReconstructionTask& task, const std::stop_token& stop) {
  lowerThreadPriority(); // the windows have priority
  std::shared_ptr<Outcome> outcome;
  bool stopped = false;
  const QString error = sentenceOf([&] {
    try {
      outcome = reconstruct(task, stop);
    } catch (const Error& caught) {
      if (caught.code() != ErrorCode::Cancelled) throw;
      stopped = true;
    }
  });
  deliver([this, outcome, stopped, error] {
    thread_.join(); // at its end
    running_ = false;
    if (stopped)
      Q_EMIT cancelled();
    else if (!error.isEmpty())
      Q_EMIT failed(error);
    else
      Q_EMIT finished(outcome);
  });
}

std::shared_ptr<Outcome> Runner::reconstruct(const ReconstructionTask& task, const std::stop_token& stop) {
  ReconstructionInput input = makeInput(task, true);
  const std::filesystem::path resumed = pathOf(task.request.resumeFile);
  if (!resumed.empty()) input.resume = std::make_shared<const Model>(readModel(resumed));
  JudgedReconstruction job(std::move(input), task.request.settings, keepEvery(task));
  int iterations = 0;
  job.onProgress([&](const Progress& progress) {
    iterations = progress.iterations;
    post(progress);
  });
  job.onPreview([&](const Volume& volume) { post(volume); });
  auto [result, quality] = job.run(stop);
  const std::filesystem::path recovery = pathOf(task.recoveryFolder);
  if (result.cancelled) {
    if (keep_ && !result.model->field.gaussians.empty()) {
      writeRecoveredFit(*result.model, recoveredFrom(task, *result.model, iterations), recovery);
      dropRecoveredFit(resumed, recovery);
    }
    throw Error(ErrorCode::Cancelled, "Stopped on request.");
  }
  dropRecoveredFit(resumed, recovery);

  const VolumeItem& first = task.inputs.front();
  auto outcome = std::make_shared<Outcome>();
  ui::Report& report = outcome->report;
  for (const std::string& warning : result.warnings)
    report.warnings << QString::fromStdString(warning);
  report.trainingPsnr = result.trainingPsnr;
  report.judging = result.judging;
  report.heldOutPsnr = result.heldOutPsnr;
  report.heldOutSlices = static_cast<int>(result.heldOutSlices);
  report.gaussians = result.model->field.size();
  report.profile = QString::fromStdString(result.profiles.sentence);
  report.agreement = QString::fromStdString(agreementSentence(result.agreement));
  report.prediction = QString::fromStdString(result.prediction);
  report.device =
      QString::fromStdString(result.device.reason.empty() ? result.device.name : result.device.reason);
  report.settings = QString::fromStdString(settingsText(result.settings, task.request.heldOutFraction));
  report.scans = static_cast<int>(task.inputs.size());
  if (quality) {
    for (const VolumeItem& item : task.inputs)
      if (!item.caveat.isEmpty() && !report.prediction.isEmpty()) report.warnings << item.caveat;
    for (const MethodScore& score : quality->methods)
      report.quality.push_back({QString::fromStdString(score.name), score.psnr, score.ssim});
    report.qualitySamples = QString::fromStdString(quality->samples);
  }
  report.seconds = result.seconds;
  outcome->model =
      makeItem(result.model, tr("%1 model").arg(first.name), {},
               notesOf(result, listed(task.inputs), listed(task.masks), report.settings.toStdString()));
  outcome->model.window = task.window;
  outcome->model.origin = namesOf(task.inputs).join(QStringLiteral(", "));
  outcome->model.saved = false;
  if (result.sliceMotion.moved) {
    outcome->model.slices = foundSlices(result);
    outcome->model.sliceTable = vtk::makeSliceTable(outcome->model.slices);
  }
  outcome->volume = makeItem(std::move(result.volume), tr("%1 reconstructed").arg(first.name));
  outcome->volume.role = VolumeRole::Made;
  outcome->volume.window = first.window;
  outcome->volume.saved = false;
  if (auto& u = result.uncertainty) {
    report.uncertainty = QString::fromStdString(uncertaintySentence(*u));
    outcome->measured = makeMeasuredItem(*u, tr("%1 measured").arg(first.name));
    outcome->uncertainty = makeItem(std::move(*u), tr("%1 standard deviation").arg(first.name));
  }
  return outcome;
}

} // namespace innergs::app
