#include "Widgets/QueryPanel.h"

#include "Core/Job/ReconstructionJob.h"
#include "Widgets/MessageLine.h"
#include "Widgets/PanelTools.h"
#include "Widgets/PlaneExport.h"
#include "Widgets/PlaneView.h"
#include "Widgets/ValueSlider.h"
#include "vtkInnerGSModel.h"

#include <QCheckBox>
#include <QCursor>
#include <QDoubleSpinBox>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLocale>
#include <QPushButton>
#include <QSignalBlocker>
#include <QToolButton>

#include <vtkDataArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cmath>

namespace innergs::ui {

namespace {

constexpr double mostShown = 1.5e6; // pixels; more than a screen shows
constexpr int settleAfter = 150;    // ms without movement

const PlaneOrientation kinds[] = {PlaneOrientation::Axial, PlaneOrientation::Coronal,
                                  PlaneOrientation::Sagittal};

Vec3 middleOf(const std::array<double, 6>& b) {
  return {0.5 * (b[0] + b[1]), 0.5 * (b[2] + b[3]), 0.5 * (b[4] + b[5])};
}

QDoubleSpinBox* numberBox(const char* name, const QString& suffix, int decimals, const QString& toolTip) {
  auto* box = named(new QDoubleSpinBox, name, toolTip);
  box->setSuffix(suffix);
  box->setDecimals(decimals);
  box->setAlignment(Qt::AlignRight);
  box->setKeyboardTracking(false);
  return box;
}

} // namespace

QueryPanel::QueryPanel(Host* host, QWidget* parent) : QWidget(parent), host_(host) {
  worker_ = new PlaneWorker(this);
  export_ = new PlaneExport(
      host_, worker_, [this] { return shownPlane(); }, this);
  settle_.setObjectName(QStringLiteral("settleTimer"));
  settle_.setSingleShot(true);
  settle_.setInterval(settleAfter);
  build();
  connectAll();
  showPose();
  updateModel();
}

// Its children outlive it, so their signals must no longer reach it.
QueryPanel::~QueryPanel() {
  for (QObject* part : findChildren<QObject*>())
    part->disconnect(this);
}

void QueryPanel::connectAll() {
  connect(selector_, &Selector::currentIdChanged, this, &QueryPanel::updateModel);
  connect(host_, &Host::modelsChanged, this, &QueryPanel::updateModel);
  connect(host_, &Host::volumesChanged, this, &QueryPanel::updateModel); // its uncertainty is one of them
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
  connect(autoWindow_, &QPushButton::clicked, this, &QueryPanel::resetWindow);
  connect(showUncertainty_, &QCheckBox::toggled, this, [this] {
    resetWindow();
    query(false);
    probeShown();
  });
  connect(handles_, &QCheckBox::toggled, view_, &PlaneView::setHandlesShown);
  connect(exportVolume_, &QPushButton::clicked, export_, &PlaneExport::addToVolumes);
  connect(savePicture_, &QPushButton::clicked, export_, &PlaneExport::savePicture);
  connect(copyCommand_, &QToolButton::clicked, export_, &PlaneExport::copyCommand);
  connect(export_, &PlaneExport::said, message_, &MessageLine::say);
  connect(&settle_, &QTimer::timeout, this, &QueryPanel::settle);
  connect(worker_, &PlaneWorker::shown, this, &QueryPanel::showImage);
  connect(worker_, &PlaneWorker::probed, this, &QueryPanel::showProbe);
}

void QueryPanel::setModelId(const QString& id) {
  selector_->setCurrentId(id);
  updateModel();
}

void QueryPanel::updateModel() {
  const QString id = selector_->currentId();
  vtkInnerGSModel* data = id.isEmpty() ? nullptr : host_->model(id);
  const auto model = data ? data->GetCoreModel() : nullptr;
  const auto toModel = model ? host_->toModel(id) : nullptr;
  const bool otherId = id != modelId_, otherModel = model != model_, moved = toModel != toModel_;
  modelId_ = id;
  model_ = model;
  toModel_ = toModel;
  info_ = model ? host_->modelInfo(id) : ModelInfo();
  if (info_.bounds[0] > info_.bounds[1]) info_.bounds = {};
  controls_->setEnabled(model != nullptr);
  const bool shownBefore = showsUncertainty();
  auto uncertainty = model ? host_->uncertaintyOf(id) : nullptr;
  const bool otherUncertainty =
      (uncertainty ? uncertainty->image : nullptr) != (uncertainty_ ? uncertainty_->image : nullptr);
  if (otherUncertainty) uncertainty_ = std::move(uncertainty);
  showUncertainty_->setVisible(uncertainty_ != nullptr);
  view_->setMessage(model ? QString() : tr("Choose a model above, or reconstruct or load one first."));
  if (otherModel) {
    worker_->clear();
    budget_.restart();
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
      }
      if (otherId || shownBefore != showsUncertainty()) resetWindow();
      bool away = !placed_;
      for (int a = 0; a < 3 && !linked_; ++a) // a linked view keeps its position
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
  } else if (otherUncertainty && (shownBefore || showsUncertainty())) {
    resetWindow();
    query(false);
  } else if (moved) { // under the plane, which stays
    showPose();
    query(true);
  }
  if (otherId) {
    message_->say({});
    Q_EMIT modelIdChanged(id);
  }
}

void QueryPanel::setPlane(vtkMatrix4x4* planeToRAS) {
  const auto pose = poseOf(planeToRAS);
  if (!pose) {
    message_->say(tr("This plane cannot be shown: its axes must be finite and span a plane."), true);
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
  position_->spinBox()->setPrefix(pose_.isStraight() ? direction + QLatin1Char(' ') : QString());
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

bool QueryPanel::showsUncertainty() const {
  return uncertainty_ && showUncertainty_->isChecked();
}

void QueryPanel::resetWindow() {
  if (showsUncertainty())
    view_->setWindow(0, uncertainty_->usual);
  else
    view_->setWindow(info_.window[0], info_.window[1]);
  showWindow();
}

PlaneTask QueryPanel::taskWithoutPixels() const {
  PlaneTask task;
  task.model = model_;
  task.toModel = toModel_;
  if (showsUncertainty()) task.uncertainty = uncertainty_;
  task.pose = pose_;
  return task;
}

// The pixels cover the model's whole box as seen along the normal, so that neighbouring planes have the same
// grid.
PlaneTask QueryPanel::taskFor(double pixelSize) const {
  PlaneTask task = taskWithoutPixels();
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

ModelPlane QueryPanel::shownPlane() const {
  ModelPlane plane{taskFor(pixelSize_->value()), modelId_, info_};
  plane.task.lower = view_->lower();
  plane.task.upper = view_->upper();
  return plane;
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
  const double inTime = budget_.pixelSize(pixels);
  const bool wasFull = !coarse_;
  coarse_ = moving && inTime > coarser;
  if (coarse_) coarser = std::clamp(std::ceil(inTime), coarser, 6 * coarser);
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
  if (image.task.uncertainty != (showsUncertainty() ? uncertainty_ : nullptr)) return; // others follow
  if (image.error.empty()) {
    budget_.took(image.milliseconds, static_cast<double>(image.task.columns) * image.task.rows);
    view_->setImage(image);
  } else {
    view_->clearImage();
    message_->say(QString::fromStdString(image.error), true);
  }
  Q_EMIT pictureChanged(image); // none after an error
}

void QueryPanel::probe(const QPointF& planePoint) {
  if (!model_) return;
  PlaneTask task = taskWithoutPixels();
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
    QString number = QLocale().toString(value, 'f', decimals);
    vtkImageData* deviation = point.deviation;
    if (deviation)
      number += QString::fromUtf8(" ± ") +
                QLocale().toString(deviation->GetScalarComponentAsDouble(0, 0, 0, 0), 'f', decimals);
    vtkDataArray* measured = deviation ? deviation->GetPointData()->GetArray("Measured") : nullptr;
    readout_->setText(measured && measured->GetTuple1(0) == 0
                          ? tr("%1: %2 scanner units, not measured").arg(place, number)
                          : tr("%1: %2 scanner units").arg(place, number));
  }
}

void QueryPanel::clearReadout() {
  readout_->setText(model_ ? tr("Wheel: move. Middle drag: pan. Right drag: zoom.") : QString());
}

void QueryPanel::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  if (!waiting_) return;
  waiting_ = false;
  query(false);
}

void QueryPanel::build() {
  auto* all = layoutWithoutMargins<QVBoxLayout>(this);

  selector_ =
      named(host_->createSelector(Host::Role::Model, this), "queryModel", tr("The model to look at."));
  auto* choice = new QHBoxLayout;
  choice->addWidget(labelFor(selector_, tr("&Model")));
  choice->addWidget(selector_, 1);
  all->addLayout(choice);

  controls_ = new QWidget;
  auto* rows = layoutWithoutMargins<QVBoxLayout>(controls_);

  auto* buttons = new QHBoxLayout;
  const struct {
    const char* name;
    QString text, toolTip;
  } kinds[3] = {
      {"queryAxial", tr("&Axial"), tr("From the feet: the patient's right on the left, anterior up.")},
      {"queryCoronal", tr("&Coronal"), tr("From the front: the patient's right on the left, superior up.")},
      {"querySagittal", tr("&Sagittal"), tr("From the side: anterior on the left, superior up.")}};
  for (int i = 0; i < 3; ++i) {
    auto* button = orientations_[i] = named(new QToolButton, kinds[i].name, kinds[i].toolTip);
    button->setText(kinds[i].text);
    button->setCheckable(true);
    button->setFocusPolicy(Qt::StrongFocus);
    button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    buttons->addWidget(button, 1);
  }
  home_ = named(new QPushButton(tr("C&entre")), "queryCentre",
                tr("Centre the plane and show the whole model; the orientation stays."));
  buttons->addWidget(home_);
  rows->addLayout(buttons);

  position_ = new ValueSlider(tr(" mm"), 1);
  position_->describe(
      QStringLiteral("queryPosition"), tr("Position along the normal"),
      tr("Distance (mm) of the plane from the origin of the patient's coordinates, along its normal: "
         "to the right (R), left (L), front (A), back (P), head (S) or feet (I)."));
  tiltUp_ = new ValueSlider(tr("°"), 1);
  tiltUp_->describe(
      QStringLiteral("queryTiltHorizontal"), tr("Tilt about the horizontal axis"),
      tr("Angle (degrees) about the view's horizontal axis, from the orientation chosen above."));
  tiltSide_ = new ValueSlider(tr("°"), 1);
  tiltSide_->describe(
      QStringLiteral("queryTiltVertical"), tr("Tilt about the vertical axis"),
      tr("Angle (degrees) about the view's vertical axis, from the orientation chosen above."));
  inPlane_ = new ValueSlider(tr("°"), 1);
  inPlane_->describe(QStringLiteral("queryInPlane"), tr("Rotation in the plane"),
                     tr("Angle (degrees) about the plane's own normal: the picture turns clockwise."));
  for (ValueSlider* angle : {tiltUp_, tiltSide_, inPlane_}) {
    angle->setRange(-180, 180);
    angle->setSingleStep(1);
    angle->setWrapping(true);
  }
  auto* grid = new QGridLayout;
  const std::pair<ValueSlider*, QString> sliders[] = {{position_, tr("&Position")},
                                                      {tiltUp_, tr("Tilt up and &down")},
                                                      {tiltSide_, tr("T&ilt left and right")},
                                                      {inPlane_, tr("&Turn in plane")}};
  int row = 0;
  for (const auto& [slider, text] : sliders) {
    grid->addWidget(labelFor(slider->spinBox(), text), row, 0);
    grid->addWidget(slider, row++, 1);
  }
  pixelSize_ = numberBox("queryPixelSize", tr(" mm"), 3,
                         tr("Distance (mm) between the plane's pixels: as shown and as exported."));
  pixelSize_->setRange(0.01, 100);
  pixelSize_->setSingleStep(0.1);
  pixelSize_->setValue(1);
  size_ = named(new QLabel, "querySize", tr("Columns and rows of the plane across the whole model."));
  auto* pixels = new QHBoxLayout;
  pixels->addWidget(pixelSize_);
  pixels->addWidget(size_);
  pixels->addStretch(1);
  grid->addWidget(labelFor(pixelSize_, tr("Pi&xel size")), row, 0);
  grid->addLayout(pixels, row, 1);
  grid->setColumnStretch(1, 1);
  rows->addLayout(grid);

  view_ = named(new PlaneView, "queryView",
                tr("Keys: arrows tilt, Ctrl+Left and Ctrl+Right turn, Shift+arrows pan,\n"
                   "Page Up and Page Down move, + and − zoom, Home centres.\n"
                   "While this view has the keyboard focus, the value in the middle is shown."));
  view_->setAccessibleName(tr("The plane"));
  view_->setWhatsThis(tr("Left drag: window and level. Middle drag, or Shift and left drag: pan. Right drag, "
                         "or Ctrl and wheel: zoom. Wheel: "
                         "along the normal. Handles tilt, turn and move the plane. Keys: arrows tilt, "
                         "Ctrl+Left and Ctrl+Right turn, Shift and arrows pan, Page Up "
                         "and Page Down move along the normal, + and − zoom, Home centres."));
  rows->addWidget(view_, 1);

  readout_ =
      named(new QLabel, "queryReadout",
            tr("Position under the mouse, or in the middle while the view has the keyboard focus (RAS mm; "
               "R, A, S: to the patient's right, anterior, superior) and the model's "
               "value there, in the scanner's units."));
  readout_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  readout_->setMinimumWidth(1); // its text must not widen the panel
  copyCommand_ = named(new QToolButton, "queryCopyCommand",
                       tr("Copy the plane as a command line of innergs, with its place in RAS mm."));
  copyCommand_->setText(tr("Cop&y"));
  copyCommand_->setFocusPolicy(Qt::StrongFocus);
  auto* place = new QHBoxLayout;
  place->addWidget(readout_, 1);
  place->addWidget(copyCommand_);
  rows->addLayout(place);

  window_ = numberBox("queryWindow", {}, 1, tr("Range of values from black to white (scanner units)."));
  level_ = numberBox("queryLevel", {}, 1, tr("Value shown as middle grey (scanner units)."));
  window_->setRange(0.001, 1e9);
  level_->setRange(-1e9, 1e9);
  for (QDoubleSpinBox* box : {window_, level_}) {
    box->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    box->setMinimumWidth(fontMetrics().horizontalAdvance(QStringLiteral("-000000.0")) +
                         2 * fontMetrics().height());
  }
  autoWindow_ =
      named(new QPushButton(tr("A&uto")), "queryAutoWindow", tr("Set window and level to suit the model."));
  handles_ = named(new QCheckBox(tr("Ha&ndles")), "queryHandles",
                   tr("Show the handles that tilt, turn and move the plane."));
  handles_->setChecked(true);
  auto* grey = new QHBoxLayout;
  grey->addWidget(labelFor(window_, tr("&Window")));
  grey->addWidget(window_, 1);
  grey->addWidget(labelFor(level_, tr("&Level")));
  grey->addWidget(level_, 1);
  grey->addWidget(autoWindow_);
  rows->addLayout(grey);

  exportVolume_ = named(new QPushButton(tr("Exp&ort as a volume")), "queryExportVolume",
                        tr("Add the plane to the volumes, at its pixel size and its place in the patient; "
                           "save it from there."));
  savePicture_ = named(new QPushButton(tr("Save pictu&re…")), "querySavePicture",
                       tr("Save the plane as a PNG picture with this window and level."));
  showUncertainty_ = named(new QCheckBox(tr("Show how far it may &be off")), "queryUncertainty",
                           tr("The standard deviation of the model's volume on the plane, in scanner units;\n"
                              "striped where no slice measured anything."));
  showUncertainty_->hide();
  rows->addWidget(showUncertainty_);
  auto* exports = new QHBoxLayout;
  exports->addWidget(handles_);
  exports->addStretch(1);
  exports->addWidget(exportVolume_);
  exports->addWidget(savePicture_);
  rows->addLayout(exports);
  all->addWidget(controls_, 1);

  message_ = named(new MessageLine, "queryMessage");
  all->addWidget(message_);
  guardWheel(this);
}

} // namespace innergs::ui
