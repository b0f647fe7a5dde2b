#include "Widgets/InputRow.h"

#include "Core/Image/SliceOverlap.h"
#include "Widgets/NumberSpin.h"
#include "Widgets/PanelTools.h"
#include "Widgets/TextFormat.h"

#include <QComboBox>
#include <QEvent>
#include <QGridLayout>
#include <QLabel>
#include <QSignalBlocker>
#include <QToolButton>
#include <QVBoxLayout>

#include <algorithm>
#include <utility>

namespace innergs::ui {
namespace {

constexpr const char* kAxisNames[3] = {"I", "J", "K"};

/// "30 axial slices of 256 × 256; 0.9 × 0.9 × 4 mm", in the order slices, pixels; thickness last.
QString slicesText(const VolumeInfo& info, int axis) {
  const int u = axis == 0 ? 1 : 0, v = axis == 2 ? 1 : 2;
  const auto& n = info.dimensions;
  const auto& d = info.spacing;
  const QString slices =
      axis == info.sliceAxis && !info.orientation.isEmpty()
          ? InputRow::tr("%n %1 slices", "1: axial, ...", n[axis]).arg(info.orientation)
          : InputRow::tr("%n slices along %1", "1: I, J or K", n[axis]).arg(kAxisNames[axis]);
  return InputRow::tr("%1 of %2 × %3; %4 × %5 × %6 mm")
      .arg(slices)
      .arg(n[u])
      .arg(n[v])
      .arg(lengthText(d[u]), lengthText(d[v]), lengthText(d[axis]));
}

} // namespace

InputRow::InputRow(Host* host, QWidget* parent)
    : QWidget(parent), host_(host), selector_(host->createSelector(Host::Role::Input, this)),
      title_(new QLabel(this)), description_(makeWrappedLabel("inputDescription", this)),
      maskRow_(new QWidget(this)), posesRow_(new QWidget(this)), thickness_(new NumberSpin({0, 1e9}, this)),
      profile_(new QComboBox(this)), axis_(new QComboBox(this)), remove_(new QToolButton(this)) {
  setObjectName("inputRow");
  named(selector_, "inputSelector", tr("The scan to reconstruct: one stack of slices."));
  title_->setBuddy(selector_);

  named(thickness_, "sliceThickness",
        tr("Thickness of one slice in mm, from the scan's protocol.\n"
           "auto (0): from the file if it says so (DICOM, NRRD), else the distance\n"
           "between slices; the line above says which. Enter it if slices overlap or\n"
           "leave gaps and the file does not say."));
  thickness_->setSuffix(tr(" mm"));

  named(profile_, "sliceProfile",
        tr("How a slice averages the tissue across its thickness:\n"
           "box: evenly (the usual choice); Gaussian: most in the middle; point: not at all."));
  profile_->addItem(tr("point"), 0);
  profile_->addItem(tr("box"), 1);
  profile_->addItem(tr("Gaussian"), 2);
  profile_->setCurrentIndex(1);

  named(axis_, "sliceAxis",
        tr("The voxel axis that counts the slices.\n"
           "auto: the one with clearly the coarsest spacing, else K."));
  axis_->addItem(tr("auto"), -1);
  for (int a = 0; a < 3; ++a)
    axis_->addItem(kAxisNames[a], a);

  named(remove_, "removeInput", tr("Remove this scan from the list."));
  remove_->setText(QString::fromUtf8("−"));
  remove_->setFocusPolicy(Qt::StrongFocus);
  remove_->setAccessibleName(tr("Remove scan"));

  for (QComboBox* combo : {profile_, axis_})
    combo->setSizeAdjustPolicy(QComboBox::AdjustToContents);
  thickness_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  selector_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);

  const auto label = [this](const QString& text, QWidget* buddy) {
    auto* made = new QLabel(text, this);
    made->setBuddy(buddy);
    return made;
  };
  auto* head = new QHBoxLayout;
  head->setSpacing(fontMetrics().averageCharWidth());
  head->addWidget(title_);
  head->addWidget(selector_, 1);
  head->addWidget(remove_);
  auto* grid = layoutWithoutMargins<QGridLayout>(this);
  grid->setVerticalSpacing(2);
  grid->addLayout(head, 0, 0, 1, 3);
  grid->addWidget(description_, 1, 0, 1, 3);
  grid->addWidget(label(tr("Slice thickness"), thickness_), 2, 0);
  grid->addWidget(label(tr("Slice profile"), profile_), 2, 1);
  grid->addWidget(label(tr("Slices along"), axis_), 2, 2);
  grid->addWidget(thickness_, 3, 0);
  grid->addWidget(profile_, 3, 1);
  grid->addWidget(axis_, 3, 2);
  const auto addOptional = [&](QWidget* row, Host::Role role, const char* name, const QString& text,
                               const QString& tip) -> Selector* {
    auto* layout = layoutWithoutMargins<QHBoxLayout>(row);
    if (!host->offers(role)) return nullptr;
    Selector* made = named(host->createSelector(role, row), name, tip);
    made->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
    layout->addWidget(label(text, made));
    layout->addWidget(made, 1);
    return made;
  };
  mask_ = addOptional(maskRow_, Host::Role::Mask, "ownMaskSelector", tr("Own mask"),
                      tr("A mask for this scan alone, where it was scanned.\n"
                         "None: the mask for all scans, below."));
  poses_ = addOptional(posesRow_, Host::Role::SlicePoses, "slicePosesSelector", tr("Slice places"),
                       tr("A sequence of linear transforms, one for each slice, as of a tracked\n"
                          "ultrasound probe: each moves its slice from where the volume puts it.\n"
                          "None: the slices lie where the volume puts them."));
  grid->addWidget(maskRow_, 4, 0, 1, 3);
  grid->addWidget(posesRow_, 5, 0, 1, 3);
  grid->setColumnStretch(0, 4);
  grid->setColumnStretch(1, 3);
  grid->setColumnStretch(2, 3);
  for (QWidget* field : fields()) // else setTabOrder() skips selectors, whose proxies take the keyboard
    field->setFocusPolicy(Qt::StrongFocus);
  setFocusProxy(selector_);
  guardWheel(this);

  const auto edited = [this] {
    refresh();
    Q_EMIT changed();
  };
  connect(selector_, &Selector::currentIdChanged, this, edited);
  for (Selector* optional : {mask_, poses_})
    if (optional) connect(optional, &Selector::currentIdChanged, this, edited);
  connect(thickness_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, [this, edited](double mm) {
    choice_.sliceThickness = mm;
    edited();
  });
  connect(profile_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this, edited] {
    choice_.sliceProfile = profile_->currentData().toInt();
    edited();
  });
  connect(axis_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this, edited] {
    choice_.sliceAxis = axis_->currentData().toInt();
    edited();
  });
  connect(remove_, &QToolButton::clicked, this, &InputRow::removeRequested);
  refresh();
}

InputChoice InputRow::choice() const {
  InputChoice choice = choice_;
  choice.id = selector_->currentId();
  if (mask_) choice.maskId = mask_->currentId();
  if (poses_) choice.posesId = poses_->currentId();
  return choice;
}

void InputRow::setChoice(const InputChoice& choice) {
  if (choice == this->choice()) return;
  {
    const QSignalBlocker quiet(this);
    selector_->setCurrentId(choice.id);
    thickness_->setValue(choice.sliceThickness);
    profile_->setCurrentIndex(std::max(0, profile_->findData(choice.sliceProfile)));
    axis_->setCurrentIndex(std::max(0, axis_->findData(choice.sliceAxis)));
    if (mask_) mask_->setCurrentId(choice.maskId);
    if (poses_) poses_->setCurrentId(choice.posesId);
    choice_ = choice;
    refresh();
  }
  Q_EMIT changed();
}

void InputRow::setPlace(int number, bool alone) {
  title_->setText(alone ? tr("Sca&n:") : tr("Scan &%1:").arg(number));
  remove_->setVisible(!alone);
  alone_ = alone;
  showOptional();
}

/// A single scan uses the panel's mask, unless it was given one of its own.
void InputRow::showOptional() {
  maskRow_->setVisible(mask_ && (!alone_ || !mask_->currentId().isEmpty()));
  posesRow_->setVisible(poses_ && (host_->hasSlicePoses() || !poses_->currentId().isEmpty()));
}

void InputRow::changeEvent(QEvent* event) {
  QWidget::changeEvent(event);
  if (event->type() == QEvent::FontChange || event->type() == QEvent::StyleChange) refresh(); // its widths
}

QVector<QWidget*> InputRow::fields() const {
  QVector<QWidget*> all{selector_, remove_, thickness_, profile_, axis_};
  for (QWidget* optional : {mask_, poses_})
    if (optional) all << optional;
  return all;
}

void InputRow::refresh() {
  showOptional();
  const VolumeInfo info = host_->volumeInfo(selector_->currentId());
  const bool known = !info.name.isEmpty();
  const int chosen = axis_->currentData().toInt();
  const int axis = std::clamp(chosen < 0 ? info.sliceAxis : chosen, 0, 2);
  const bool said = info.sliceThickness > 0 && axis == info.sliceAxis;
  thickness_->setSpecialValueText(
      known ? tr("auto (%1 mm)").arg(lengthText(said ? info.sliceThickness : info.spacing[axis]))
            : tr("auto"));
  if (known) thickness_->setHighest(kMostOverlap * info.spacing[axis]);
  thickness_->setMinimumWidth(thickness_->sizeHint().width()); // the minimum size hint omits the unit
  axis_->setItemText(0,
                     known ? tr("auto (%1)").arg(kAxisNames[std::clamp(info.sliceAxis, 0, 2)]) : tr("auto"));
  axis_->setMinimumWidth(axis_->sizeHint().width()); // Qt keeps the minimum of the old text
  if (!known) {
    description_->setText(tr("Choose a scan."));
    return;
  }
  QString text = slicesText(info, axis);
  if (choice_.sliceThickness == 0)
    text = said ? tr("%1; slice thickness %2 mm, as the file says").arg(text, lengthText(info.sliceThickness))
                : tr("%1; slice thickness not given: the slice distance").arg(text);
  if (info.passes > 1 && axis == info.sliceAxis)
    text = tr("%1; acquired in %n interleaved passes", nullptr, info.passes).arg(text);
  if (info.hasPoses) text = tr("%1; each slice at a place of its own").arg(text);
  description_->setText(text);
}

} // namespace innergs::ui
