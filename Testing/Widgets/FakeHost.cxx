#include "FakeHost.h"

#include "Core/Job/ReconstructionJob.h"
#include "Core/Model/GaussianField.h"
#include "vtkInnerGSModel.h"

#include <QComboBox>
#include <QDir>
#include <QFileInfo>
#include <QHBoxLayout>
#include <QSignalBlocker>
#include <QTimer>

#include <vtkDoubleArray.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>
#include <random>

using innergs::ui::Estimate;
using innergs::ui::ModelInfo;
using innergs::ui::Report;
using innergs::ui::Request;
using innergs::ui::VolumeInfo;

FakeHost::FakeHost(QObject* parent) : Host(parent) {
  qRegisterMetaType<innergs::Progress>("innergs::Progress");
  qRegisterMetaType<Report>("innergs::ui::Report");
  roles = {Role::Input,        Role::Mask,  Role::Region,    Role::Reference,
           Role::OutputVolume, Role::Model, Role::SlicePoses};
  addVolume("head", {"Head axial", {256, 256, 30}, {0.9, 0.9, 4.0}, 2, "axial"});
  addVolume("side", {"Head sagittal", {256, 256, 28}, {0.9, 0.9, 5.0}, 2, "sagittal"});
  addVolume("thin", {"Thin", {64, 64, 64}, {1, 1, 1}, 2, "axial"});
  masks = {{"brain", "Brain"}};
  regions = {{"box", "Box"}};
  nextEstimate.memory = 850'000'000;
  nextEstimate.available = 16'000'000'000;
  nextEstimate.seconds = 95;
  nextEstimate.reason = "On the CPU. The CUDA backend is not installed.";
  folder_ = QDir::tempPath();
}

FakeHost::~FakeHost() = default;

void FakeHost::addVolume(const QString& id, const VolumeInfo& info) {
  volumes[id] = info;
  Q_EMIT volumesChanged();
}

void FakeHost::removeVolume(const QString& id) {
  volumes.remove(id);
  Q_EMIT volumesChanged();
}

QString FakeHost::addBallModel(const QString& name, int gaussians) {
  constexpr float radius = 40;
  auto core = std::make_shared<innergs::Model>();
  auto& field = core->field;
  field.intensityScale = 100;
  field.domain.size = {80, 80, 80};
  field.domain.origin = {-39.5, -39.5, -39.5};
  std::mt19937 random(1);
  std::uniform_real_distribution<float> uniform(-radius, radius);
  while (static_cast<int>(field.gaussians.size()) < gaussians) {
    const float x = uniform(random), y = uniform(random), z = uniform(random);
    const float r = std::sqrt(x * x + y * y + z * z);
    if (r > radius) continue;
    innergs::Gaussian g{};
    g.mean[0] = x, g.mean[1] = y, g.mean[2] = z;
    std::fill(g.logScale, g.logScale + 3, std::log(6.f));
    g.quaternion[0] = 1;
    g.intensity = 1 - r / radius;
    field.gaussians.push_back(g);
  }
  auto data = vtkSmartPointer<vtkInnerGSModel>::New();
  data->SetCoreModel(core);
  QString id = QString("model%1").arg(models.size() + 1);
  ModelInfo info;
  info.name = name;
  info.gaussians = gaussians;
  info.bytes = std::int64_t{64} * gaussians;
  info.description = QString::fromStdString(data->GetDescription());
  data->GetBounds(info.bounds.data());
  info.window = {0, 100};
  info.saved = false;
  models[id] = info;
  modelData[id] = data;
  Q_EMIT modelsChanged();
  return id;
}

void FakeHost::sendProgress(innergs::Phase phase, double fraction, int iteration, double loss, double psnr,
                            double remaining, const std::string& note) {
  innergs::Progress progress;
  progress.phase = phase;
  progress.fraction = fraction;
  progress.iteration = iteration;
  progress.iterations = 100;
  progress.loss = loss;
  progress.trainingPsnr = psnr;
  progress.members = members;
  progress.coarseIterations = coarseIterations;
  progress.gaussians = 20000;
  progress.remaining = remaining;
  progress.note = note;
  Q_EMIT progressed(progress);
}

void FakeHost::sendPreview(int n) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(n, n, n);
  image->AllocateScalars(VTK_FLOAT, 1);
  auto* voxel = static_cast<float*>(image->GetScalarPointer());
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const auto part = [n](int x) { return 2.2 * (x + 0.5) / n - 1.1; };
        const double r = std::sqrt(part(i) * part(i) + part(j) * part(j) * 1.5 + part(k) * part(k));
        *voxel++ = r < 1 ? static_cast<float>(60 + 40 * std::cos(12 * r)) : 0;
      }
  vtkNew<vtkMatrix4x4> matrix;
  Q_EMIT previewed(image, matrix);
}

void FakeHost::end() {
  running_ = false;
}

void FakeHost::sendFinished(const Report& report) {
  end();
  Q_EMIT finished(report);
}

void FakeHost::sendFailed(const QString& sentence) {
  end();
  Q_EMIT failed(sentence);
}

void FakeHost::sendCancelled() {
  if (!running_) return;
  end();
  Q_EMIT cancelled();
}

void FakeHost::sendEnded(const QString& why) {
  if (!running_) return;
  end();
  Q_EMIT ended(why);
}

Report FakeHost::exampleReport() {
  Report report;
  report.volumeId = "thin";
  report.warnings << "The slices are thicker than the gap between them: thickness was set to 4 mm.";
  report.trainingPsnr = 38.25;
  report.judging = innergs::Judging::Done;
  report.heldOutPsnr = 31.5;
  report.heldOutSlices = 12;
  report.quality = {{"gaussians", 31.62, 0.942}, {"linear", 30.11, 0.921}, {"cubic", 30.02, 0.919}};
  report.qualitySamples = "Every 4th slice of Head axial was kept; the others, inside the body, are scored.";
  report.seconds = 83;
  report.gaussians = 74088;
  report.device = "On the CPU. The CUDA backend is not installed.";
  report.settings = "preset=balanced; seed=1";
  return report;
}

bool FakeHost::offers(Role role) const {
  return roles.contains(role);
}

innergs::ui::Selector* FakeHost::createSelector(Role role, QWidget* parent) {
  return new FakeSelector(this, role, parent);
}

VolumeInfo FakeHost::volumeInfo(const QString& id) const {
  return volumes.value(id);
}

Estimate FakeHost::estimate(const Request& request) {
  estimated << request;
  return nextEstimate;
}

bool FakeHost::start(const Request& request) {
  requests << request;
  if (!refusal.isEmpty()) {
    Q_EMIT failed(refusal);
    return false;
  }
  running_ = true;
  Q_EMIT started();
  return true;
}

void FakeHost::cancel() {
  ++cancels;
  if (cancelsByItself) QTimer::singleShot(0, this, &FakeHost::sendCancelled);
}

vtkSmartPointer<vtkTable> FakeHost::exampleSlices() {
  auto table = vtkSmartPointer<vtkTable>::New();
  const auto add = [&](const char* name, const std::array<double, 6>& values) {
    vtkNew<vtkDoubleArray> column;
    column->SetName(name);
    for (const double value : values)
      column->InsertNextValue(value);
    table->AddColumn(column);
  };
  add("Scan", {1, 1, 1, 2, 2, 2});
  add("Slice", {0, 1, 2, 0, 1, 2});
  add("Weight", {1, 1, 0.81, 1, 1, 0});
  add("Gain", {1, 1.012, 0.99, 1, 1, 1});
  add("Displacement (mm)", {0.5, 3.25, 10.5, 1, 2, 0});
  add("Angle (degrees)", {0.1, 2.9, 1, 0, 0.25, 0});
  add("Residual", {12.5, 11, 30, 12, 13, NAN});
  return table;
}

QString FakeHost::createSliceTransforms(const QString& folder, QString* error) {
  transformFolders << folder;
  *error = slicesError;
  return slicesError.isEmpty() ? QStringLiteral("Made 6 transforms.") : QString();
}

QString FakeHost::saveSliceTable(const QString& file) {
  savedTables << file;
  return slicesError;
}

ModelInfo FakeHost::modelInfo(const QString& id) const {
  return models.value(id);
}

vtkInnerGSModel* FakeHost::model(const QString& id) const {
  return modelData.value(id);
}

QString FakeHost::loadModel(const QString& file, QString* error) {
  loadedFiles << file;
  if (error) *error = modelError;
  if (!modelError.isEmpty()) return {};
  return addBallModel(QFileInfo(file).completeBaseName());
}

QString FakeHost::saveModel(const QString& id, const QString& file) {
  savedFiles << file;
  if (!modelError.isEmpty()) return modelError;
  models[id].saved = true;
  Q_EMIT modelsChanged();
  return {};
}

QString FakeHost::showEllipsoids(const QString& id, bool shown) {
  if (!modelError.isEmpty()) return modelError;
  models[id].ellipsoidsShown = shown;
  Q_EMIT modelsChanged();
  return {};
}

QString FakeHost::addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                            QString* error) {
  if (error) *error = modelError;
  if (!modelError.isEmpty()) return {};
  lastAddedImage = vtkSmartPointer<vtkImageData>::New();
  lastAddedImage->DeepCopy(image);
  lastAddedMatrix = vtkSmartPointer<vtkMatrix4x4>::New();
  lastAddedMatrix->DeepCopy(ijkToRAS);
  addedVolumes << name;
  VolumeInfo info;
  info.name = name;
  image->GetDimensions(info.dimensions.data());
  image->GetSpacing(info.spacing.data());
  info.orientation = "oblique";
  QString id = QString("added%1").arg(addedVolumes.size());
  addVolume(id, info);
  return id;
}

QMap<QString, QString> FakeHost::choices(Role role) const {
  QMap<QString, QString> names;
  if (role == Role::Mask) return masks;
  if (role == Role::Series) return series;
  if (role == Role::SlicePoses) return slicePoses;
  if (role == Role::Region) return regions;
  if (role == Role::Model || role == Role::OutputModel) {
    for (auto it = models.begin(); it != models.end(); ++it)
      names[it.key()] = it->name;
    return names;
  }
  for (auto it = volumes.begin(); it != volumes.end(); ++it)
    names[it.key()] = it->name;
  return names;
}

FakeSelector::FakeSelector(FakeHost* host, innergs::ui::Host::Role role, QWidget* parent)
    : Selector(parent), host_(host), role_(role), combo_(new QComboBox(this)) {
  auto* layout = new QHBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  layout->addWidget(combo_);
  setFocusProxy(combo_);
  combo_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  refill();
  connect(combo_, QOverload<int>::of(&QComboBox::currentIndexChanged), this,
          [this] { Q_EMIT currentIdChanged(currentId()); });
  connect(host, &innergs::ui::Host::volumesChanged, this, &FakeSelector::refill);
  connect(host, &innergs::ui::Host::modelsChanged, this, &FakeSelector::refill);
}

QString FakeSelector::currentId() const {
  return combo_->currentData().toString();
}

void FakeSelector::setCurrentId(const QString& id) {
  combo_->setCurrentIndex(std::max(0, combo_->findData(id)));
}

void FakeSelector::refill() {
  using Role = innergs::ui::Host::Role;
  const QString before = currentId();
  {
    const QSignalBlocker blocker(combo_);
    combo_->clear();
    const bool output = role_ == Role::OutputVolume || role_ == Role::OutputModel;
    combo_->addItem(output ? QStringLiteral("New") : QStringLiteral("None"), QString());
    const auto names = host_->choices(role_);
    for (auto it = names.begin(); it != names.end(); ++it)
      combo_->addItem(it.value(), it.key());
    setCurrentId(before);
  }
  if (currentId() != before) Q_EMIT currentIdChanged(currentId());
}
