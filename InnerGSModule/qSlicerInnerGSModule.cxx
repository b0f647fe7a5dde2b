#include "qSlicerInnerGSModule.h"

#include "qSlicerInnerGSModelPlugin.h"
#include "qSlicerInnerGSModuleWidget.h"
#include "qSlicerInnerGSReader.h"

#include <qSlicerCoreApplication.h>
#include <qSlicerCoreIOManager.h>
#include <qSlicerNodeWriter.h>
#include <qSlicerSubjectHierarchyPluginHandler.h>

#ifdef Slicer_USE_PYTHONQT
#include <qSlicerCorePythonManager.h>
#endif

#include <vtkSlicerInnerGSLogic.h>

#include <vtkSlicerConfigure.h> // Slicer_BUILD_DICOM_SUPPORT

#ifdef Slicer_BUILD_DICOM_SUPPORT
#include <ctkDICOMDatabase.h>
#endif

#include <QFileInfo>
#include <QHash>
#include <QStandardPaths>

#ifdef Slicer_BUILD_DICOM_SUPPORT
namespace {

/// Found once: the database may have to read the file.
std::string dicomValue(const std::string& instanceUID, const std::string& tag) {
  static QHash<QString, QString> known;
  const QString uid = QString::fromStdString(instanceUID), name = QString::fromStdString(tag);
  const auto found = known.constFind(uid + name);
  if (found != known.constEnd()) return found->toStdString();
  ctkDICOMDatabase* database = qSlicerCoreApplication::application()->dicomDatabase();
  const QString value = database && database->isOpen() ? database->instanceValue(uid, name) : QString();
  if (!value.isEmpty()) known.insert(uid + name, value); // else it may be imported later
  return value.toStdString();
}

} // namespace
#endif

qSlicerInnerGSModule::qSlicerInnerGSModule(QObject* parent) : Superclass(parent) {}

qSlicerInnerGSModule::~qSlicerInnerGSModule() = default;

QString qSlicerInnerGSModule::helpText() const {
  return tr("Turns medical image slices into a continuous volume made of 3D Gaussians. Choose one scan, or "
            "several scans of the same anatomy in any orientation, press <b>Reconstruct</b>, and get a "
            "volume "
            "at any spacing and a model to cut at any plane. The "
            "<a href=\"%1/blob/main/Docs/tutorial.md\">tutorial</a> takes ten minutes; "
            "<a href=\"%1\">the project's page</a> has the method and its measurements.<br>"
            "<b>Research software: not a medical device, not for diagnosis or treatment.</b>")
      .arg("https://github.com/InnerGS/SlicerInnerGS");
}

QString qSlicerInnerGSModule::acknowledgementText() const {
  return tr("InnerGS follows the method of S. Liang, Y. Xiao, W. Tang: <i>InnerGS: Internal Scenes Rendering "
            "via Factorized 3D Gaussian Splatting</i>, <a href=\"%1\">arXiv:2508.13287</a>, 2025; please "
            "cite this paper. This module is an independent implementation: name it as InnerGS %2 beside the "
            "paper.<br>It builds on 3D Slicer, ITK, VTK, Qt, Highway and nlohmann-json.")
      .arg("https://arxiv.org/abs/2508.13287")
      .arg(QString::fromStdString(vtkSlicerInnerGSLogic::GetVersion()));
}

QStringList qSlicerInnerGSModule::contributors() const {
  return {tr("The InnerGS contributors")};
}

QIcon qSlicerInnerGSModule::icon() const {
  return QIcon(":/Icons/InnerGS.png");
}

QStringList qSlicerInnerGSModule::categories() const {
  return {"Tomographic Reconstruction"};
}

QStringList qSlicerInnerGSModule::dependencies() const {
  return {"Volumes", "VolumeRendering", "Markups", "Segmentations", "Sequences", "SubjectHierarchy"};
}

QStringList qSlicerInnerGSModule::associatedNodeTypes() const {
  return {"vtkMRMLInnerGSParameterNode", "vtkMRMLInnerGSModelNode"};
}

void qSlicerInnerGSModule::setup() {
  this->Superclass::setup();
#ifdef Slicer_USE_PYTHONQT // `import innergs`, also where no launcher has set the path
  if (qSlicerCorePythonManager* python = qSlicerCoreApplication::application()->corePythonManager())
    python->appendPythonPath(QFileInfo(this->path()).absolutePath() + "/Python");
#endif
  auto* logic = vtkSlicerInnerGSLogic::SafeDownCast(this->logic());
#ifdef Slicer_BUILD_DICOM_SUPPORT
  if (logic) logic->SetDicomLookup(dicomValue);
#endif
  if (logic) // shared with the desktop app; not all systems keep a temporary folder over a restart
    logic->SetRecoveryFolder((QStandardPaths::writableLocation(QStandardPaths::GenericDataLocation) +
                              QStringLiteral("/InnerGS/recovery"))
                                 .toStdString());
  qSlicerCoreIOManager* files = qSlicerCoreApplication::application()->coreIOManager();
  files->registerIO(new qSlicerInnerGSReader(logic, this));
  files->registerIO(new qSlicerNodeWriter(tr("InnerGS model"), QString("InnerGSModelFile"),
                                          QStringList() << "vtkMRMLInnerGSModelNode", false, this));
  qSlicerSubjectHierarchyPluginHandler::instance()->registerPlugin(new qSlicerInnerGSModelPlugin);
}

qSlicerAbstractModuleRepresentation* qSlicerInnerGSModule::createWidgetRepresentation() {
  return new qSlicerInnerGSModuleWidget;
}

vtkMRMLAbstractLogic* qSlicerInnerGSModule::createLogic() {
  return vtkSlicerInnerGSLogic::New();
}
