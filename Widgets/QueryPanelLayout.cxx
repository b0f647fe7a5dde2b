// What the panel looks like; QueryPanel.cxx says what it does.
#include "Widgets/MessageLine.h"
#include "Widgets/PanelTools.h"
#include "Widgets/PlaneView.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ValueSlider.h"

#include <QCheckBox>
#include <QDoubleSpinBox>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QPushButton>
#include <QToolButton>

namespace innergs::ui {

namespace {

QDoubleSpinBox* numberBox(const QString& name, const QString& suffix, int decimals, const QString& toolTip) {
  auto* box = new QDoubleSpinBox;
  box->setObjectName(name);
  box->setSuffix(suffix);
  box->setDecimals(decimals);
  box->setAlignment(Qt::AlignRight);
  box->setKeyboardTracking(false);
  box->setToolTip(toolTip);
  return box;
}

QLabel* labelFor(QWidget* buddy, const QString& text) {
  auto* label = new QLabel(text);
  label->setBuddy(buddy);
  label->setToolTip(buddy->toolTip());
  return label;
}

} // namespace

void QueryPanel::build() {
  auto* all = new QVBoxLayout(this);
  all->setContentsMargins(0, 0, 0, 0);

  selector_ = host_->createSelector(Host::Role::Model, this);
  selector_->setObjectName(QStringLiteral("queryModel"));
  selector_->setToolTip(tr("The model to look at"));
  auto* choice = new QHBoxLayout;
  choice->addWidget(labelFor(selector_, tr("&Model")));
  choice->addWidget(selector_, 1);
  all->addLayout(choice);

  controls_ = new QWidget;
  auto* rows = new QVBoxLayout(controls_);
  rows->setContentsMargins(0, 0, 0, 0);

  auto* buttons = new QHBoxLayout;
  const struct {
    const char* name;
    QString text, toolTip;
  } kinds[3] = {
      {"queryAxial", tr("&Axial"), tr("From the feet: the patient's right on the left, anterior up")},
      {"queryCoronal", tr("&Coronal"), tr("From the front: the patient's right on the left, superior up")},
      {"querySagittal", tr("&Sagittal"), tr("From the side: anterior on the left, superior up")}};
  for (int i = 0; i < 3; ++i) {
    auto* button = orientations_[i] = new QToolButton;
    button->setObjectName(QString::fromLatin1(kinds[i].name));
    button->setText(kinds[i].text);
    button->setToolTip(kinds[i].toolTip);
    button->setCheckable(true);
    button->setFocusPolicy(Qt::StrongFocus);
    button->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    buttons->addWidget(button, 1);
  }
  home_ = new QPushButton(tr("C&entre"));
  home_->setObjectName(QStringLiteral("queryCentre"));
  home_->setToolTip(tr("Show the middle of the model and all of it; the orientation stays"));
  buttons->addWidget(home_);
  rows->addLayout(buttons);

  position_ = new ValueSlider(tr(" mm"), 1);
  position_->describe(
      QStringLiteral("queryPosition"), tr("Position along the normal"),
      tr("Distance of the plane from the origin of the patient's coordinates (RAS mm), along its normal: "
         "to the right (R), left (L), front (A), back (P), head (S) or feet (I)"));
  tiltUp_ = new ValueSlider(tr("°"), 1);
  tiltUp_->describe(
      QStringLiteral("queryTiltHorizontal"), tr("Tilt about the horizontal axis"),
      tr("Angle (degrees) about the view's horizontal axis, from the orientation chosen above"));
  tiltSide_ = new ValueSlider(tr("°"), 1);
  tiltSide_->describe(
      QStringLiteral("queryTiltVertical"), tr("Tilt about the vertical axis"),
      tr("Angle (degrees) about the view's vertical axis, from the orientation chosen above"));
  inPlane_ = new ValueSlider(tr("°"), 1);
  inPlane_->describe(QStringLiteral("queryInPlane"), tr("Rotation in the plane"),
                     tr("Angle (degrees) about the plane's own normal: the picture turns clockwise"));
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
  pixelSize_ = numberBox(QStringLiteral("queryPixelSize"), tr(" mm"), 3,
                         tr("Distance (mm) between the plane's pixels: as shown and as exported"));
  pixelSize_->setRange(0.01, 100);
  pixelSize_->setSingleStep(0.1);
  pixelSize_->setValue(1);
  size_ = new QLabel;
  size_->setObjectName(QStringLiteral("querySize"));
  size_->setToolTip(tr("Columns and rows of the plane across the whole model"));
  auto* pixels = new QHBoxLayout;
  pixels->addWidget(pixelSize_);
  pixels->addWidget(size_);
  pixels->addStretch(1);
  grid->addWidget(labelFor(pixelSize_, tr("Pi&xel size")), row, 0);
  grid->addLayout(pixels, row, 1);
  grid->setColumnStretch(1, 1);
  rows->addLayout(grid);

  view_ = new PlaneView;
  view_->setObjectName(QStringLiteral("queryView"));
  view_->setAccessibleName(tr("The plane"));
  view_->setWhatsThis(tr("Left drag: window and level. Middle drag, or Shift and left drag: pan. Right drag, "
                         "or Ctrl and wheel: zoom. Wheel: "
                         "along the normal. Handles tilt, turn and move the plane. Keys: arrows tilt, "
                         "Ctrl+Left and Ctrl+Right turn, Shift and arrows pan, Page Up "
                         "and Page Down move along the normal, + and − zoom, Home centres."));
  view_->setToolTip(tr("Keys: arrows tilt, Ctrl+Left and Ctrl+Right turn, Shift+arrows pan,\n"
                       "Page Up and Page Down move, + and − zoom, Home centres.\n"
                       "The value in the middle is told while the keyboard is here."));
  rows->addWidget(view_, 1);

  readout_ = new QLabel;
  readout_->setObjectName(QStringLiteral("queryReadout"));
  readout_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  readout_->setToolTip(
      tr("Place under the cursor, or in the middle while the keyboard is in the view (RAS mm; "
         "R, A, S: to the patient's right, anterior, superior) and the model's "
         "value there, in the scanner's units"));
  readout_->setMinimumWidth(1); // its text never widens the panel
  copyCommand_ = new QToolButton;
  copyCommand_->setObjectName(QStringLiteral("queryCopyCommand"));
  copyCommand_->setText(tr("Cop&y"));
  copyCommand_->setFocusPolicy(Qt::StrongFocus);
  copyCommand_->setToolTip(tr("Copy the plane as a command line of innergs, with its place in RAS mm"));
  auto* place = new QHBoxLayout;
  place->addWidget(readout_, 1);
  place->addWidget(copyCommand_);
  rows->addLayout(place);

  window_ = numberBox(QStringLiteral("queryWindow"), {}, 1,
                      tr("Range of values (scanner units) from black to white"));
  level_ = numberBox(QStringLiteral("queryLevel"), {}, 1,
                     tr("Value (scanner units) that is shown in middle grey"));
  window_->setRange(0.001, 1e9);
  level_->setRange(-1e9, 1e9);
  for (QDoubleSpinBox* box : {window_, level_}) {
    box->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    box->setMinimumWidth(fontMetrics().horizontalAdvance(QStringLiteral("-000000.0")) +
                         2 * fontMetrics().height());
  }
  autoWindow_ = new QPushButton(tr("A&uto"));
  autoWindow_->setObjectName(QStringLiteral("queryAutoWindow"));
  autoWindow_->setToolTip(tr("Window and level that suit the model"));
  handles_ = new QCheckBox(tr("Ha&ndles"));
  handles_->setObjectName(QStringLiteral("queryHandles"));
  handles_->setToolTip(tr("Show the handles that tilt, turn and move the plane"));
  handles_->setChecked(true);
  auto* shades = new QHBoxLayout;
  shades->addWidget(labelFor(window_, tr("&Window")));
  shades->addWidget(window_, 1);
  shades->addWidget(labelFor(level_, tr("&Level")));
  shades->addWidget(level_, 1);
  shades->addWidget(autoWindow_);
  rows->addLayout(shades);

  exportVolume_ = new QPushButton(tr("Exp&ort as a volume"));
  exportVolume_->setObjectName(QStringLiteral("queryExportVolume"));
  exportVolume_->setToolTip(tr("Put the plane, at its pixel size and in its place in the patient, among the "
                               "volumes, from where it can be saved"));
  savePicture_ = new QPushButton(tr("Save pictu&re…"));
  savePicture_->setObjectName(QStringLiteral("querySavePicture"));
  savePicture_->setToolTip(tr("Save the plane as a PNG picture with this window and level"));
  auto* exports = new QHBoxLayout;
  exports->addWidget(handles_);
  exports->addStretch(1);
  exports->addWidget(exportVolume_);
  exports->addWidget(savePicture_);
  rows->addLayout(exports);
  all->addWidget(controls_, 1);

  message_ = new MessageLine;
  message_->setObjectName(QStringLiteral("queryMessage"));
  all->addWidget(message_);
  guardWheel(this);
}

} // namespace innergs::ui
