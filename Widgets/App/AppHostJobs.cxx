// Reconstructions, and volumes that panels make.
#include "Widgets/App/AppHost.h"

#include "Core/Base/Error.h"
#include "Core/Base/SystemMemory.h"
#include "Core/Device/Devices.h"
#include "Core/Job/MemoryEstimate.h"
#include "Core/Job/TimeEstimate.h"
#include "Core/Settings/SettingsText.h"
#include "Geometry.h"
#include "ImageVoxels.h"
#include "Widgets/App/Background.h"

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

#include <algorithm>

namespace innergs::app {
namespace {

/// Everything that the time and the device depend on.
QString keyOf(const Order& order, const ReconstructionInput& input) {
  const Settings& s = order.request.settings;
  QString key = QString::fromStdString(settingsText(s, input.heldOutFraction) + "|" + s.instructionSet);
  key += QStringLiteral("|%1|%2").arg(s.threads).arg(order.request.evaluateQuality ? order.request.qualityGap
                                                                                   : -1);
  const auto add = [&](const GridGeometry& grid) {
    for (int a = 0; a < 3; ++a)
      key += QStringLiteral("|%1x%2").arg(grid.size[a]).arg(grid.spacing[a]);
  };
  for (const Stack& stack : input.stacks) {
    add(stack.image.geometry);
    key += QStringLiteral("/%1/%2").arg(stack.thickness).arg(static_cast<int>(stack.profile));
  }
  add(*input.outputGrid);
  return key;
}

[[noreturn]] void refuse(const QString& sentence) {
  throw Error(ErrorCode::InvalidArgument, sentence.toStdString());
}

} // namespace

Order AppHost::orderFor(const ui::Request& request) const {
  Order order;
  order.request = request;
  const auto find = [&](const QString& id, const QString& what) {
    const auto item = document_.volume(id);
    if (!item) refuse(tr("%1 is no longer open: choose another.").arg(what));
    return *item;
  };
  for (const ui::InputChoice& choice : request.inputs)
    order.inputs.push_back(find(choice.id, tr("An input")));
  if (order.inputs.empty()) refuse(tr("There is no input volume: open a scan and choose it."));
  order.window = {order.inputs.front().window->lower, order.inputs.front().window->upper};
  if (!request.maskId.isEmpty()) order.mask = find(request.maskId, tr("The mask"));
  if (request.grid == ui::OutputGrid::Reference) {
    if (request.referenceId.isEmpty())
      refuse(tr("There is no reference volume to take the output grid from: choose one."));
    order.reference = find(request.referenceId, tr("The reference volume"));
  }
  if (request.evaluateQuality) checkKeepEvery(request.qualityGap);
  if (!request.outputVolumeId.isEmpty()) {
    const VolumeItem output = find(request.outputVolumeId, tr("The output volume"));
    for (const ui::InputChoice& choice : request.inputs)
      if (choice.id == output.id)
        refuse(tr("The output '%1' is an input as well: choose another, inputs are never changed.")
                   .arg(output.name));
    if (output.id == request.maskId ||
        (request.grid == ui::OutputGrid::Reference && output.id == request.referenceId))
      refuse(
          tr("The output '%1' is the mask or the reference as well: choose another, these are never changed.")
              .arg(output.name));
  }
  if (!request.outputModelId.isEmpty() && !document_.model(request.outputModelId))
    refuse(tr("The output model is no longer open: choose another."));
  checkSettings(request.settings);
  return order;
}

void AppHost::fillSlowly(const Order& order, const std::vector<ReconstructionInput>& fits,
                         ui::Estimate& estimate) {
  const QString key = keyOf(order, fits.front());
  const auto found = slow_.constFind(key);
  if (found != slow_.constEnd()) {
    estimate.refusal = found->refusal;
    estimate.device = found->device;
    estimate.reason = found->reason;
    estimate.seconds = found->seconds;
    return;
  }
  if (isRunning()) return; // all processors are at work: a time measured now says nothing
  slow_.insert(key, {});   // asked for
  estimates_->run({}, [this, key, settings = order.request.settings, fits, run = runs_] {
    auto slow = std::make_shared<Slow>();
    slow->refusal = sentenceOf([&] {
      const DeviceChoice choice(settings.device, settings.instructionSet, settings.selection);
      slow->device = QString::fromStdString(choice.use.name);
      slow->reason = QString::fromStdString(choice.use.reason);
    });
    sentenceOf([&] { // without it the time is unknown
      double sum = 0;
      for (const ReconstructionInput& fit : fits) {
        const double seconds = estimateSeconds(fit, settings);
        if (seconds == 0) return;
        sum += seconds;
      }
      slow->seconds = sum;
    });
    return [this, key, slow, run] {
      if (run == runs_)
        slow_.insert(key, *slow);
      else
        slow_.remove(key); // measured beside a reconstruction: again
      Q_EMIT estimateChanged();
    };
  });
}

ui::Estimate AppHost::estimate(const ui::Request& request) {
  ui::Estimate estimate;
  estimate.available = availableMemory();
  const QString refusal = sentenceOf([&] {
    const Order order = orderFor(request);
    const std::vector<ReconstructionInput> fits = fitOutlines(makeInput(order, false), keepEvery(order));
    const MemoryNeed need = memoryNeed(fits, request.settings, estimate.available);
    estimate.memory = need.bytes;
    fillSlowly(order, fits, estimate);
    if (!need.refusal.empty() && !isRunning()) throw Error(ErrorCode::Memory, need.refusal);
  });
  if (!refusal.isEmpty()) estimate.refusal = refusal;
  return estimate;
}

bool AppHost::start(const ui::Request& request) {
  QString refusal;
  if (isRunning()) refusal = tr("A reconstruction is running: wait for it or cancel it.");
  Order order;
  if (refusal.isEmpty())
    refusal = sentenceOf([&] {
      order = orderFor(request);
      makeInput(order, false);
    });
  if (!refusal.isEmpty()) {
    Q_EMIT failed(refusal);
    return false;
  }
  request_ = request;
  ++runs_;
  runner_->start(std::move(order));
  Q_EMIT started();
  return true;
}

void AppHost::deliver(Outcome outcome) {
  ui::Report report = std::move(outcome.report);
  // A chosen output that was closed meanwhile becomes a new one: a result is never lost.
  if (!request_.outputVolumeId.isEmpty() && document_.volume(request_.outputVolumeId)) {
    report.volumeId = request_.outputVolumeId;
    document_.replace(report.volumeId, std::move(outcome.volume));
  } else {
    report.volumeId = document_.add(std::move(outcome.volume));
  }
  if (!request_.outputModelId.isEmpty() && document_.model(request_.outputModelId)) {
    report.modelId = request_.outputModelId;
    document_.replace(report.modelId, std::move(outcome.model));
  } else {
    report.modelId = document_.add(std::move(outcome.model));
  }
  Q_EMIT finished(report);
}

void AppHost::cancel() {
  if (isRunning()) runner_->cancel();
}

bool AppHost::isRunning() const {
  return runner_->isRunning();
}

QString AppHost::addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name, QString* error) {
  std::optional<VolumeItem> item;
  QString sentence;
  const auto copy = [&] {
    const std::string what = "'" + name.toStdString() + "'";
    vtk::checkVoxels(image, what);
    Volume volume{vtk::gridOf(image, ijkToRAS, what), {}};
    volume.voxels = vtk::voxelsOf(image, {{0, 0, 0}, volume.geometry.size}, what);
    item = makeItem(std::move(volume), name);
    item->role = VolumeRole::Made;
    item->saved = false;
  };
  background_->runAndWait(tr("Copying %1").arg(name), [&] { sentence = sentenceOf(copy); });
  if (error) *error = sentence;
  if (!sentence.isEmpty()) {
    Q_EMIT logged(sentence);
    return {};
  }
  return document_.add(std::move(*item));
}

} // namespace innergs::app
