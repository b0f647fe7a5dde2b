#include "Widgets/App/VolumeSelector.h"

#include "Widgets/PanelTools.h"

#include <QComboBox>
#include <QHBoxLayout>
#include <QSignalBlocker>

namespace innergs::app {

using Role = ui::Host::Role;

VolumeSelector::VolumeSelector(Document* document, Role role, QWidget* parent)
    : Selector(parent), document_(document), role_(role), box_(new QComboBox(this)) {
  box_->setObjectName(QStringLiteral("box"));
  box_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  box_->setMinimumContentsLength(8);
  box_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  auto* layout = ui::layoutWithoutMargins<QHBoxLayout>(this);
  layout->addWidget(box_);
  setFocusProxy(box_);
  const bool models = role == Role::Model || role == Role::OutputModel;
  connect(document, models ? &Document::modelsChanged : &Document::volumesChanged, this,
          &VolumeSelector::fill);
  connect(box_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
          [this] { Q_EMIT currentIdChanged(currentId()); });
  fill();
}

void VolumeSelector::fill() {
  const QString before = currentId();
  {
    const QSignalBlocker blocker(box_);
    box_->clear();
    if (role_ == Role::Series)
      box_->addItem(tr("Choose a dynamic scan"), QString());
    else if (role_ == Role::Input)
      box_->addItem(document_->volumes().empty() ? tr("No volume yet") : tr("Choose a scan"), QString());
    else if (role_ == Role::Mask)
      box_->addItem(tr("None"), QString());
    else if (role_ == Role::Labels)
      box_->addItem(document_->volumes().empty() ? tr("No labelmap yet") : tr("Choose a labelmap"),
                    QString());
    else if (role_ == Role::OutputVolume)
      box_->addItem(tr("New volume"), QString());
    else if (role_ == Role::OutputModel)
      box_->addItem(tr("New model"), QString());
    if (role_ == Role::Model || role_ == Role::OutputModel)
      for (const auto& item : document_->models())
        box_->addItem(item->name, item->id);
    else
      for (const auto& item : document_->volumes())
        if (role_ != Role::Series || item->frames.count > 1) box_->addItem(item->name, item->id);
    const int index = box_->findData(before);
    box_->setCurrentIndex(index >= 0 ? index : box_->count() > 0 ? 0 : -1);
    if (box_->count() == 0)
      box_->setPlaceholderText(role_ == Role::Model ? tr("No model yet") : tr("No volume yet"));
  }
  if (currentId() != before) Q_EMIT currentIdChanged(currentId());
}

QString VolumeSelector::currentId() const {
  return box_->currentData().toString();
}

void VolumeSelector::setCurrentId(const QString& id) {
  const int index = box_->findData(id.isNull() ? QString() : id);
  if (index >= 0) box_->setCurrentIndex(index);
}

} // namespace innergs::app
