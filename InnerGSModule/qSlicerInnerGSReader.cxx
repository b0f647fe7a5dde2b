#include "qSlicerInnerGSReader.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLMessageCollection.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkCallbackCommand.h>
#include <vtkNew.h>

#include <QFile>
#include <QFileInfo>

qSlicerInnerGSReader::qSlicerInnerGSReader(vtkSlicerInnerGSLogic* logic, QObject* parent)
    : Superclass(parent), logic_(logic) {}

qSlicerInnerGSReader::~qSlicerInnerGSReader() = default;

QString qSlicerInnerGSReader::description() const {
  return tr("InnerGS model");
}

qSlicerIO::IOFileType qSlicerInnerGSReader::fileType() const {
  return "InnerGSModelFile";
}

QStringList qSlicerInnerGSReader::extensions() const {
  return {tr("InnerGS model (*.innergs)"), tr("Gaussians (*.ply)")};
}

bool qSlicerInnerGSReader::canLoadFile(const QString& file) const {
  if (!Superclass::canLoadFile(file)) return false;
  if (!file.endsWith(".ply", Qt::CaseInsensitive)) return true;
  QFile ply(file); // surfaces have the same extension
  return ply.open(QIODevice::ReadOnly) && ply.read(4096).contains("property float rot_0");
}

bool qSlicerInnerGSReader::load(const IOProperties& properties) {
  this->setLoadedNodes({});
  this->userMessages()->ClearMessages();
  if (!logic_) return false;
  vtkNew<vtkCallbackCommand> quiet; // the dialog shows the sentence
  const unsigned long tag = logic_->AddObserver(vtkCommand::ErrorEvent, quiet);
  vtkMRMLInnerGSModelNode* node = logic_->LoadModel(properties["fileName"].toString().toStdString());
  logic_->RemoveObserver(tag);
  if (!node) {
    this->userMessages()->AddMessage(vtkCommand::ErrorEvent, logic_->GetLastError());
    return false;
  }
  if (properties.contains("name")) node->SetName(properties["name"].toString().toUtf8().constData());
  this->setLoadedNodes({QString::fromUtf8(node->GetID())});
  return true;
}
