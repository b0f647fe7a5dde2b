#include "qSlicerInnerGSSelector.h"

#include "Widgets/PanelTools.h"

#include <qMRMLNodeComboBox.h>
#include <vtkMRMLNode.h>

#include <QHBoxLayout>

using innergs::ui::Host;

qSlicerInnerGSSelector::qSlicerInnerGSSelector(Host::Role role, vtkMRMLScene* scene, QWidget* parent)
    : Selector(parent), combo_(new qMRMLNodeComboBox(this)) {
  struct Kind {
    QStringList types, hidden;
    QString none;
    bool add;
  };
  const QStringList notScans{"vtkMRMLLabelMapVolumeNode", "vtkMRMLTensorVolumeNode",
                             "vtkMRMLDiffusionWeightedVolumeNode"};
  const auto kind = [&]() -> Kind {
    switch (role) {
    case Host::Role::Input:
      return {{"vtkMRMLScalarVolumeNode"}, notScans, tr("Choose a volume"), false};
    case Host::Role::Mask:
      return {{"vtkMRMLSegmentationNode", "vtkMRMLLabelMapVolumeNode"}, {}, tr("None"), false};
    case Host::Role::Labels:
      return {{"vtkMRMLSegmentationNode", "vtkMRMLLabelMapVolumeNode"}, {}, tr("Choose labels"), false};
    case Host::Role::Region:
      return {{"vtkMRMLMarkupsROINode"}, {}, tr("None: everything"), true};
    case Host::Role::Reference:
      return {{"vtkMRMLVolumeNode"}, {}, tr("Choose a volume"), false};
    case Host::Role::OutputVolume:
      return {{"vtkMRMLScalarVolumeNode"}, notScans, tr("New volume"), false};
    case Host::Role::OutputModel:
      return {{"vtkMRMLInnerGSModelNode"}, {}, tr("New model"), false};
    case Host::Role::Series:
      return {{"vtkMRMLSequenceNode"}, {}, tr("Choose a sequence"), false};
    case Host::Role::SlicePoses:
      return {{"vtkMRMLSequenceNode"}, {}, tr("None"), false};
    case Host::Role::Model:
      break;
    }
    return {{"vtkMRMLInnerGSModelNode"}, {}, tr("None"), false};
  }();
  combo_->setNodeTypes(kind.types);
  combo_->setHideChildNodeTypes(kind.hidden);
  combo_->setNoneEnabled(true);
  combo_->setNoneDisplay(kind.none);
  combo_->setAddEnabled(kind.add);
  combo_->setRemoveEnabled(false);
  combo_->setRenameEnabled(role == Host::Role::Model);
  combo_->setBaseName(kind.add ? tr("InnerGS region") : QString());
  combo_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  combo_->setMRMLScene(scene);

  auto* layout = innergs::ui::layoutWithoutMargins<QHBoxLayout>(this);
  layout->addWidget(combo_);
  setFocusProxy(combo_);
  connect(combo_, &qMRMLNodeComboBox::currentNodeIDChanged, this, &Selector::currentIdChanged);
  connect(combo_, &qMRMLNodeComboBox::nodeAddedByUser, this, &qSlicerInnerGSSelector::nodeMade);
}

QString qSlicerInnerGSSelector::currentId() const {
  return combo_->currentNodeID();
}

void qSlicerInnerGSSelector::setCurrentId(const QString& id) {
  combo_->setCurrentNodeID(id);
}

void qSlicerInnerGSSelector::setMRMLScene(vtkMRMLScene* scene) {
  combo_->setMRMLScene(scene);
}
