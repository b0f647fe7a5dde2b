#include "NodeInfo.h"

#include "Core/Base/Error.h"
#include "NodeGeometry.h"
#include "vtkInnerGSModel.h"
#include "vtkInnerGSResample.h"

#include <vtkMRMLInnerGSModelNode.h>
#include <vtkMRMLInnerGSModelStorageNode.h>
#include <vtkMRMLInnerGSParameterNode.h>
#include <vtkMRMLModelNode.h>
#include <vtkMRMLScalarVolumeDisplayNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLSubjectHierarchyNode.h>
#include <vtkMRMLTableNode.h>
#include <vtkMRMLTransformNode.h>
#include <vtkSlicerInnerGSJob.h>
#include <vtkSlicerInnerGSLogic.h>

#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkTable.h>

#include <QCoreApplication>
#include <QDir>
#include <QFileInfo>

#include <algorithm>
#include <deque>
#include <memory>

namespace innergs::ui {
namespace {

double lengthOfColumn(vtkMatrix4x4* matrix, int column) {
  return std::hypot(matrix->GetElement(0, column), matrix->GetElement(1, column),
                    matrix->GetElement(2, column));
}

QString orientationOf(vtkMatrix4x4* ijkToRAS, int sliceAxis) {
  const double length = lengthOfColumn(ijkToRAS, sliceAxis);
  const char* names[] = {QT_TRANSLATE_NOOP("innergs", "sagittal"), QT_TRANSLATE_NOOP("innergs", "coronal"),
                         QT_TRANSLATE_NOOP("innergs", "axial")};
  for (int a = 0; a < 3; ++a)
    if (std::abs(ijkToRAS->GetElement(a, sliceAxis)) > 0.9 * length)
      return QCoreApplication::translate("innergs", names[a]);
  return QCoreApplication::translate("innergs", "oblique");
}

constexpr const char* kEllipsoids = "InnerGSEllipsoids"; // distinguishes them from scripts' point nodes

/// A node made from the model; if an attribute is given, one that has it.
template <class Node>
Node* madeFrom(vtkMRMLInnerGSModelNode* model, const char* className, const char* attribute = nullptr) {
  vtkMRMLScene* scene = model->GetScene();
  const int count = scene ? scene->GetNumberOfNodesByClass(className) : 0;
  for (int i = 0; i < count; ++i) {
    auto* node = Node::SafeDownCast(scene->GetNthNodeByClass(i, className));
    if (node && node->GetNodeReference("InnerGSModel") == model &&
        (!attribute || node->GetAttribute(attribute)))
      return node;
  }
  return nullptr;
}

/// 1 % to 99 % of the values on a coarse grid.
std::array<double, 2> sampledValuesOf(vtkInnerGSModel* model) {
  double bounds[6];
  model->GetBounds(bounds);
  constexpr int n = 24;
  vtkNew<vtkMatrix4x4> grid;
  for (int a = 0; a < 3; ++a) {
    grid->SetElement(a, a, std::max(1e-3, bounds[2 * a + 1] - bounds[2 * a]) / n);
    grid->SetElement(a, 3, bounds[2 * a] + grid->GetElement(a, a) / 2);
  }
  vtkNew<vtkInnerGSResample> sample;
  sample->SetModel(model);
  sample->SetDevice("cpu"); // looking for others takes longer than these few points
  sample->SetReferenceGrid(grid, n, n, n);
  sample->Update();
  vtkImageData* image = sample->GetOutput();
  const auto* values = image ? static_cast<const float*>(image->GetScalarPointer()) : nullptr;
  if (!values || image->GetScalarType() != VTK_FLOAT) return {0, 1};
  std::vector<float> sorted(values, values + image->GetNumberOfPoints());
  std::sort(sorted.begin(), sorted.end());
  return {sorted[sorted.size() / 100], sorted[sorted.size() * 99 / 100]};
}

/// The same, cached for the last few models.
std::array<double, 2> valuesOf(vtkInnerGSModel* model) {
  struct Known {
    std::weak_ptr<const Model> of;
    std::array<double, 2> values;
  };
  static std::deque<Known> known;
  const auto core = model->GetCoreModel();
  for (const Known& one : known)
    if (one.of.lock() == core) return one.values;
  known.push_front({core, sampledValuesOf(model)});
  if (known.size() > 16) known.pop_back();
  return known.front().values;
}

} // namespace

QString idOf(vtkMRMLNode* node) {
  return node && node->GetID() ? QString::fromUtf8(node->GetID()) : QString();
}

VolumeInfo infoOf(vtkMRMLVolumeNode* node) {
  VolumeInfo info;
  if (!node) return info;
  info.name = QString::fromUtf8(node->GetName());
  vtkImageData* image = node->GetImageData();
  if (!image) return info;
  image->GetDimensions(info.dimensions.data());
  vtkNew<vtkMatrix4x4> ijkToRAS;
  try {
    mrml::ijkToWorld(node, ijkToRAS);
  } catch (const Error&) { // under a transform that will be rejected
    node->GetIJKToRASMatrix(ijkToRAS);
  }
  for (int a = 0; a < 3; ++a)
    info.spacing[a] = lengthOfColumn(ijkToRAS, a);
  info.sliceAxis = mrml::sliceAxis(ijkToRAS);
  info.orientation = orientationOf(ijkToRAS, info.sliceAxis);
  return info;
}

vtkMRMLModelNode* ellipsoidsOf(vtkMRMLInnerGSModelNode* node) {
  return madeFrom<vtkMRMLModelNode>(node, "vtkMRMLModelNode", kEllipsoids);
}

void setEllipsoidsOf(vtkMRMLInnerGSModelNode* model, vtkMRMLModelNode* ellipsoids) {
  ellipsoids->SetAttribute(kEllipsoids, "1");
  ellipsoids->SetNodeReferenceID("InnerGSModel", model->GetID());
}

bool isMade(vtkMRMLNode* node) {
  return node && (node->GetNodeReferenceID("InnerGSModel") || node->GetAttribute("InnerGS.Version"));
}

bool isScan(vtkMRMLNode* node) {
  auto* volume = vtkMRMLScalarVolumeNode::SafeDownCast(node);
  if (!volume || !volume->GetImageData() || volume->GetHideFromEditors() || isMade(volume)) return false;
  for (const char* other :
       {"vtkMRMLLabelMapVolumeNode", "vtkMRMLTensorVolumeNode", "vtkMRMLDiffusionWeightedVolumeNode"})
    if (volume->IsA(other)) return false;
  return true;
}

void setMadeFrom(vtkMRMLNode* node, vtkMRMLInnerGSModelNode* model) {
  MRMLNodeModifyBlocker blocker(node);
  for (const std::string& name : model->GetAttributeNames())
    if (name.rfind("InnerGS.", 0) == 0) node->SetAttribute(name.c_str(), model->GetAttribute(name.c_str()));
  if (!node->GetAttribute("InnerGS.Version"))
    node->SetAttribute("InnerGS.Version", vtkSlicerInnerGSLogic::GetVersion().c_str());
  node->SetNodeReferenceID("InnerGSModel", model->GetID());
}

void placeBeside(vtkMRMLNode* node, vtkMRMLNode* sibling) {
  auto* tree = vtkMRMLSubjectHierarchyNode::GetSubjectHierarchyNode(sibling->GetScene());
  const vtkIdType beside = tree->GetItemByDataNode(sibling), item = tree->GetItemByDataNode(node);
  if (beside && item) tree->SetItemParent(item, tree->GetItemParent(beside));
}

vtkMRMLScalarVolumeNode* volumeOf(vtkMRMLInnerGSModelNode* node) {
  return madeFrom<vtkMRMLScalarVolumeNode>(node, "vtkMRMLScalarVolumeNode");
}

ModelInfo infoOf(vtkMRMLInnerGSModelNode* node) {
  ModelInfo info;
  if (!node) return info;
  info.name = QString::fromUtf8(node->GetName());
  if (node->IsEmpty()) return info;
  vtkInnerGSModel* model = node->GetModel();
  info.gaussians = model->GetNumberOfGaussians();
  info.bytes = static_cast<std::int64_t>(model->GetActualMemorySize()) * 1024;
  info.description = QString::fromStdString(model->GetDescription());
  node->GetRASBounds(info.bounds.data());

  vtkMRMLScalarVolumeNode* volume = volumeOf(node);
  if (vtkMRMLScalarVolumeDisplayNode* display = volume ? volume->GetScalarVolumeDisplayNode() : nullptr)
    info.window = {display->GetLevel() - display->GetWindow() / 2,
                   display->GetLevel() + display->GetWindow() / 2};
  else
    info.window = valuesOf(model);

  vtkNew<vtkMatrix4x4> domain;
  int dimensions[3];
  info.finestSpacing = std::max({info.bounds[1] - info.bounds[0], info.bounds[3] - info.bounds[2],
                                 info.bounds[5] - info.bounds[4]}) /
                       256;
  if (model->GetDomain(domain, dimensions)) {
    vtkMRMLTransformNode* parent = node->GetParentTransformNode();
    vtkNew<vtkMatrix4x4> toWorld; // the identity under a nonlinear transform
    if (parent && parent->IsTransformToWorldLinear()) parent->GetMatrixTransformToWorld(toWorld);
    vtkMatrix4x4::Multiply4x4(toWorld, domain, domain);
    info.finestSpacing =
        std::min({lengthOfColumn(domain, 0), lengthOfColumn(domain, 1), lengthOfColumn(domain, 2)});
  }

  auto* storage = vtkMRMLInnerGSModelStorageNode::SafeDownCast(node->GetStorageNode());
  if (storage && storage->GetFileName()) info.file = QString::fromUtf8(storage->GetFileName());
  if (!QFileInfo(info.file).isAbsolute() || !QFileInfo::exists(info.file)) { // unpacked from the scene bundle
    const char* url = node->GetScene() ? node->GetScene()->GetURL() : nullptr;
    const QString bundle = QString::fromUtf8(url ? url : "");
    if (bundle.endsWith(QLatin1String(".mrb"), Qt::CaseInsensitive))
      info.file = bundle;
    else if (QDir::isRelativePath(info.file))
      info.file.clear();
  }
  info.saved = storage && storage->Holds(node);
  const char* inputs = node->GetAttribute("InnerGS.Inputs");
  info.origin = inputs ? QString::fromUtf8(inputs) : info.file;
  vtkMRMLModelNode* ellipsoids = ellipsoidsOf(node);
  info.ellipsoidsShown = ellipsoids && ellipsoids->GetDisplayVisibility();
  vtkPolyData* surfaces = ellipsoids ? ellipsoids->GetPolyData() : nullptr;
  if (vtkDataArray* count = surfaces ? surfaces->GetFieldData()->GetArray("Gaussians") : nullptr)
    info.ellipsoids = static_cast<std::int64_t>(count->GetComponent(0, 0));
  return info;
}

Report reportOf(vtkSlicerInnerGSJob* job) {
  Report report;
  report.volumeId = idOf(job->GetVolumeNode());
  report.modelId = idOf(job->GetModelNode());
  report.tableId = idOf(job->GetTableNode());
  report.uncertaintyId = idOf(job->GetUncertaintyNode());
  report.uncertainty = QString::fromStdString(job->GetUncertaintyNote());
  for (int i = 0; i < job->GetNumberOfWarnings(); ++i)
    report.warnings << QString::fromStdString(job->GetWarning(i));
  report.trainingPsnr = job->GetTrainingPSNR();
  report.heldOutPsnr = job->GetHeldOutPSNR();
  report.heldOutSlices = job->GetNumberOfHeldOutSlices();
  report.judging = static_cast<Judging>(job->GetQualityState());
  report.seconds = job->GetElapsedSeconds();
  if (vtkMRMLInnerGSModelNode* model = job->GetModelNode())
    report.gaussians = model->IsEmpty() ? 0 : model->GetModel()->GetNumberOfGaussians();
  report.profile = QString::fromStdString(job->GetProfileNote());
  report.agreement = QString::fromStdString(job->GetAgreementNote());
  report.prediction = QString::fromStdString(job->GetPredictionNote());
  report.device = QString::fromStdString(job->GetDeviceNote());
  report.settings = QString::fromStdString(job->GetUsedSettings());
  if (vtkMRMLInnerGSParameterNode* parameters = job->GetParameterNode())
    report.scans = parameters->GetNumberOfInputVolumeNodes();
  report.quality = qualityOf(job->GetTableNode(), report.qualitySamples);
  return report;
}

QVector<QualityRow> qualityOf(vtkMRMLTableNode* node, QString& samples) {
  QVector<QualityRow> rows;
  vtkTable* table = node ? node->GetTable() : nullptr;
  for (vtkIdType row = 0; table && row < table->GetNumberOfRows(); ++row)
    rows.append({QString::fromStdString(table->GetValueByName(row, "Method").ToString()),
                 table->GetValueByName(row, "PSNR (dB)").ToDouble(),
                 table->GetValueByName(row, "SSIM").ToDouble()});
  if (node) samples = QString::fromUtf8(node->GetAttribute("InnerGS.Samples"));
  return rows;
}

} // namespace innergs::ui
