#include "Widgets/QueryPanel.h"

#include "Core/Job/ReconstructionJob.h"
#include "Widgets/MessageLine.h"
#include "Widgets/PlaneView.h"
#include "Widgets/ValueSlider.h"

#include "vtkInnerGSModel.h"

#include <QCheckBox>
#include <QCursor>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLocale>
#include <QPushButton>
#include <QSignalBlocker>
#include <QToolButton>

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>

#include <algorithm>
#include <cmath>

namespace innergs::ui {

namespace {

constexpr double budget = 16;       // ms that a plane may take while it moves
constexpr double mostShown = 1.5e6; // pixels; more than a screen shows
constexpr int settleAfter = 150;    // ms without movement

const PlaneOrientation kinds[] = {PlaneOrientation::Axial, PlaneOrientation::Coronal,
                                  PlaneOrientation::Sagittal};

Vec3 middleOf(const std::array<double, 6>& b) {
  return {0.5 * (b[0] + b[1]), 0.5 * (b[2] + b[3]), 0.5 * (b[4] + b[5])};
}

} // namespace

QueryPanel::QueryPanel(Host* host, QWidget* parent) : QWidget(parent), host_(host) {
  worker_ = new PlaneWorker(this);
  settle_.setObjectName(QStringLiteral("settleTimer"));
  settle_.setSingleShot(true);
  settle_.setInterval(settleAfter);
  build();
  connectAll();
  showPose();
  updateModel();
}

// Its parts go after it: what they still say is for nobody.
QueryPanel::~QueryPanel() {
  for (QObject* part : findChildren<QObject*>())
    part->disconnect(this);
}

void QueryPanel::connectAll() {
  connect(selector_, &Selector::currentIdChanged, this, &QueryPanel::updateModel);
  connect(host_, &Host::modelsChanged, this, &QueryPanel::updateModel);
  for (int i = 0; i < 3; ++i)
    connect(orientations_[i], &QToolButton::clicked, this, [this, i] {
      PlanePose pose = pose_;
      pose.orientation = kinds[i];
      pose.reversed = false;
      pose.angles = {};
      setPose(pose, true);
      home();
    });
  connect(home_, &QPushButton::clicked, this, [this] {
    PlanePose pose = pose_;
    pose.origin = middleOf(info_.bounds);
    setPose(pose, true);
    home();
  });
  connect(position_, &ValueSlider::valueEdited, this, [this](double value) {
    PlanePose pose = pose_;
    pose.setPosition(value);
    edited(pose);
  });
  const std::pair<ValueSlider*, double PlaneAngles::*> angles[] = {{tiltUp_, &PlaneAngles::aboutHorizontal},
                                                                   {tiltSide_, &PlaneAngles::aboutVertical},
                                                                   {inPlane_, &PlaneAngles::inPlane}};
  for (const auto& [slider, angle] : angles)
    connect(slider, &ValueSlider::valueEdited, this, [this, angle = angle](double value) {
      PlanePose pose = pose_;
      pose.angles.*angle = value;
      edited(pose);
    });
  for (ValueSlider* slider : {position_, tiltUp_, tiltSide_, inPlane_})
    connect(slider, &ValueSlider::draggingChanged, this, [this](bool dragging) {
      dragging_ = dragging;
      if (!dragging) settle();
    });
  connect(pixelSize_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, [this] {
    showPose();
    query(true);
  });
  connect(view_, &PlaneView::poseEdited, this, &QueryPanel::edited);
  connect(view_, &PlaneView::draggingChanged, this, [this](bool dragging) {
    dragging_ = dragging;
    if (!dragging) settle();
  });
  connect(view_, &PlaneView::homeAsked, home_, &QPushButton::click);
  connect(view_, &PlaneView::windowEdited, this, &QueryPanel::showWindow);
  connect(view_, &PlaneView::hovered, this, &QueryPanel::probe);
  connect(view_, &PlaneView::left, this, &QueryPanel::probeShown);
  connect(view_, &PlaneView::focusChanged, this, &QueryPanel::probeShown);
  for (QDoubleSpinBox* box : {window_, level_})
    connect(box, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, [this] {
      view_->setWindow(level_->value() - 0.5 * window_->value(), level_->value() + 0.5 * window_->value());
      Q_EMIT windowChanged(view_->lower(), view_->upper());
    });
  connect(autoWindow_, &QPushButton::clicked, this, [this] {
    view_->setWindow(info_.window[0], info_.window[1]);
    showWindow();
  });
  connect(handles_, &QCheckBox::toggled, view_, &PlaneView::setHandlesShown);
  connect(exportVolume_, &QPushButton::clicked, this, [this] { keep({}); });
  connect(savePicture_, &QPushButton::clicked, this, &QueryPanel::choosePictureFile);
  connect(copyCommand_, &QToolButton::clicked, this, &QueryPanel::copyCommand);
  connect(&settle_, &QTimer::timeout, this, &QueryPanel::settle);
  connect(worker_, &PlaneWorker::shown, this, &QueryPanel::showImage);
  connect(worker_, &PlaneWorker::probed, this, &QueryPanel::showProbe);
  connect(worker_, &PlaneWorker::kept, this, &QueryPanel::kept);
}

void QueryPanel::setModelId(const QString& id) {
  selector_->setCurrentId(id);
  updateModel();
}

void QueryPanel::updateModel() {
  const QString id = selector_->currentId();
  vtkInnerGSModel* data = id.isEmpty() ? nullptr : host_->model(id);
  const auto model = data ? data->GetCheckpoint() : nullptr;
  const auto toModel = model ? host_->toModel(id) : nullptr;
  const bool otherId = id != modelId_, otherModel = model != model_, moved = toModel != toModel_;
  modelId_ = id;
  model_ = model;
  toModel_ = toModel;
  info_ = model ? host_->modelInfo(id) : ModelInfo();
  if (info_.bounds[0] > info_.bounds[1]) info_.bounds = {};
  controls_->setEnabled(model != nullptr);
  view_->setMessage(model ? QString() : tr("Choose a model above, or reconstruct or load one first."));
  if (otherModel) {
    worker_->clear();
    msPerPixel_ = 0;
    clearReadout();
    Q_EMIT pictureChanged({});
    if (!model) {
      view_->clearImage();
      size_->clear();
    } else {
      if (!(info_.window[1] > info_.window[0])) info_.window[1] = info_.window[0] + 1;
      if (otherId) {
        const QSignalBlocker block(pixelSize_);
        pixelSize_->setValue(info_.finestSpacing > 0 ? info_.finestSpacing : 1);
        view_->setWindow(info_.window[0], info_.window[1]);
        showWindow();
      }
      bool away = !placed_;
      for (int a = 0; a < 3 && !linked_; ++a) // a linked view stays where it is
        away = away || pose_.origin[a] < info_.bounds[2 * a] || pose_.origin[a] > info_.bounds[2 * a + 1];
      PlanePose pose = pose_;
      if (away) pose.origin = middleOf(info_.bounds);
      placed_ = true;
      setPose(pose, true);
      if (otherId) home();
      showPose();
      query(false);
      probeShown();
    }
  } else if (moved) { // under the plane, which stays
    showPose();
    query(true);
  }
  if (otherId) {
    say({});
    Q_EMIT modelIdChanged(id);
  }
}

void QueryPanel::setPlane(vtkMatrix4x4* planeToRAS) {
  const auto pose = poseOf(planeToRAS);
  if (!pose) {
    say(tr("The plane was not taken over: its axes must be finite and span a plane."), true);
    return;
  }
  placed_ = linked_ = true;
  vtkNew<vtkMatrix4x4> matrix;
  toMatrix(*pose, matrix);
  bool same = true;
  for (int i = 0; i < 16; ++i)
    same = same && std::abs(matrix->GetElement(i / 4, i % 4) - matrix_->GetElement(i / 4, i % 4)) < 1e-6;
  if (!same) setPose(*pose);
}

vtkMatrix4x4* QueryPanel::planeToRAS() const {
  return matrix_;
}

void QueryPanel::setPose(const PlanePose& pose, bool settled) {
  if (pose == pose_) return;
  pose_ = pose;
  view_->setPose(pose);
  showPose();
  query(!settled);
  probeShown();
  Q_EMIT planeChanged(matrix_);
}

void QueryPanel::edited(const PlanePose& pose) {
  placed_ = true;
  setPose(pose);
}

void QueryPanel::showPose() {
  toMatrix(pose_, matrix_);
  for (int i = 0; i < 3; ++i)
    orientations_[i]->setChecked(pose_.orientation == kinds[i] && pose_.isStraight());
  tiltUp_->setValue(pose_.angles.aboutHorizontal);
  tiltSide_->setValue(pose_.angles.aboutVertical);
  inPlane_->setValue(pose_.angles.inPlane);
  view_->setStep(pixelSize_->value());
  if (!model_) return;
  const auto extent = extentOf(pose_, info_.bounds);
  const double position = pose_.position();
  position_->setRange(std::min(position, position + extent[4]), std::max(position, position + extent[5]));
  position_->setSingleStep(std::max(0.1, pixelSize_->value()));
  position_->setValue(position);
  const QString direction = directionLetters(pose_.normal());
  position_->spinBox()->setSuffix(pose_.isStraight() ? tr(" mm %1").arg(direction) : tr(" mm"));
  const PlaneTask task = taskFor(pixelSize_->value());
  size_->setText(tr("%1 × %2 pixels").arg(task.columns).arg(task.rows));
  view_->setNote(extent[4] > 1e-6 || extent[5] < -1e-6 ? tr("The plane lies beside the model.") : QString());
}

void QueryPanel::home() {
  const auto extent = extentOf(pose_, info_.bounds);
  view_->fit(extent[0], extent[1], extent[2], extent[3]);
}

void QueryPanel::showWindow() {
  const QSignalBlocker blockWindow(window_), blockLevel(level_);
  const double width = view_->upper() - view_->lower();
  const int decimals = width >= 100 ? 1 : width >= 1 ? 2 : 4;
  for (QDoubleSpinBox* box : {window_, level_}) {
    box->setDecimals(decimals);
    box->setSingleStep(width / 50);
  }
  window_->setValue(width);
  level_->setValue(0.5 * (view_->lower() + view_->upper()));
  Q_EMIT windowChanged(view_->lower(), view_->upper());
}

// The pixels cover the model's whole box as it is seen along the normal, so that neighbouring planes have the
// same grid.
PlaneTask QueryPanel::taskFor(double pixelSize) const {
  PlaneTask task;
  task.model = model_;
  task.toModel = toModel_;
  task.pose = pose_;
  task.pixelSize = pixelSize;
  const auto extent = extentOf(pose_, info_.bounds);
  const auto count = [pixelSize](double length) {
    return static_cast<int>(std::clamp(std::ceil(length / pixelSize - 1e-6), 1., 1e6));
  };
  task.columns = count(extent[1] - extent[0]);
  task.rows = count(extent[3] - extent[2]);
  task.left = 0.5 * (extent[0] + extent[1]) - 0.5 * (task.columns - 1) * pixelSize;
  task.bottom = 0.5 * (extent[2] + extent[3]) - 0.5 * (task.rows - 1) * pixelSize;
  return task;
}

void QueryPanel::query(bool moving) {
  if (!model_) return;
  if (!isVisible()) {
    waiting_ = true;
    return;
  }
  const PlaneTask full = taskFor(pixelSize_->value());
  const double pixels = static_cast<double>(full.columns) * full.rows;
  double coarser = std::max(1., std::sqrt(pixels / mostShown));
  const double needed = msPerPixel_ * pixels / budget;
  const bool wasFull = !coarse_;
  coarse_ = moving && needed > coarser * coarser;
  if (coarse_) coarser = std::clamp(std::ceil(std::sqrt(needed)), coarser, 6 * coarser);
  worker_->show(coarser > 1 ? taskFor(coarser * pixelSize_->value()) : full, coarse_ && wasFull);
  if (coarse_)
    settle_.start();
  else
    settle_.stop();
}

void QueryPanel::settle() {
  if (coarse_ && !dragging_) query(false);
}

void QueryPanel::showImage(const PlaneImage& image) {
  if (image.task.model != model_) return;
  if (image.error.isEmpty()) {
    msPerPixel_ = image.milliseconds / (static_cast<double>(image.task.columns) * image.task.rows);
    view_->setImage(image);
  } else {
    view_->clearImage();
    say(image.error, true);
  }
  Q_EMIT pictureChanged(image); // none after an error
}

void QueryPanel::probe(const QPointF& planePoint) {
  if (!model_) return;
  PlaneTask task;
  task.model = model_;
  task.toModel = toModel_;
  task.pose = pose_;
  task.left = planePoint.x();
  task.bottom = planePoint.y();
  worker_->probe(task);
}

void QueryPanel::probeShown() {
  if (view_->underMouse())
    probe(view_->planeAt(view_->mapFromGlobal(QCursor::pos())));
  else if (view_->hasFocus())
    probe({0, 0});
  else
    clearReadout();
}

void QueryPanel::showProbe(const PlaneImage& point) {
  if (point.task.model != model_ || point.task.toModel != toModel_) return;
  if (!view_->underMouse() && !view_->hasFocus()) return;
  const Vec3 ras = point.task.pose.toRAS(point.task.left, point.task.bottom);
  const QString place = (view_->underMouse() ? tr("%1 mm") : tr("Middle: %1 mm")).arg(positionText(ras));
  if (!point.image) {
    readout_->setText(place);
  } else if (!point.inside) {
    readout_->setText(tr("%1: outside the model").arg(place));
  } else {
    const int decimals = window_->decimals();
    double value = point.image->GetScalarComponentAsDouble(0, 0, 0, 0);
    if (std::abs(value) < 0.5 * std::pow(10., -decimals)) value = 0; // not −0.0
    readout_->setText(tr("%1: %2 scanner units").arg(place, QLocale().toString(value, 'f', decimals)));
  }
}

void QueryPanel::clearReadout() {
  readout_->setText(model_ ? tr("Wheel: move. Middle drag: pan. Right drag: zoom.") : QString());
}

void QueryPanel::say(const QString& message, bool error) {
  message_->setMessage(error ? MessageLine::Kind::Error : MessageLine::Kind::Information, message);
}

void QueryPanel::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  if (!waiting_) return;
  waiting_ = false;
  query(false);
}

} // namespace innergs::ui
