#include "Widgets/App/DataItems.h"

#include "Core/Base/Error.h"
#include "Core/Image/SliceAxis.h"
#include "Core/Job/ReconstructionJob.h"
#include "Geometry.h"
#include "UncertaintyImage.h"
#include "Widgets/App/Translate.h"

#include <vtkCommand.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace innergs::app {
namespace {

/// Keeps a volume alive as long as the array that shows its voxels: the array owns its observers.
class KeepAlive : public vtkCommand {
public:
  static KeepAlive* New() { return new KeepAlive; }
  void Execute(vtkObject*, unsigned long, void*) override {}
  std::shared_ptr<const Volume> volume;
};

vtkSmartPointer<vtkImageData> imageOf(const std::shared_ptr<const Volume>& volume, const QString& name) {
  for (const std::int64_t n : volume->geometry.size)
    if (n > std::numeric_limits<int>::max())
      throw Error(
          ErrorCode::Geometry,
          tr("'%1' has more voxels along an axis than can be shown: crop it.").arg(name).toStdString());
  vtkNew<vtkFloatArray> voxels;
  voxels->SetName("Intensity");
  voxels->SetArray(const_cast<float*>(volume->voxels.data()), static_cast<vtkIdType>(volume->voxels.size()),
                   1); // 1: the array does not free them
  vtkNew<KeepAlive> keep;
  keep->volume = volume;
  voxels->AddObserver(vtkCommand::UserEvent, keep);
  auto image = vtkSmartPointer<vtkImageData>::New();
  image->SetDimensions(static_cast<int>(volume->geometry.size[0]), static_cast<int>(volume->geometry.size[1]),
                       static_cast<int>(volume->geometry.size[2]));
  image->GetPointData()->SetScalars(voxels);
  image->GetScalarRange(); // computed here, not when it is first drawn
  return image;
}

std::array<double, 2> finiteRange(const std::vector<float>& voxels) {
  float low = std::numeric_limits<float>::infinity(), high = -low;
  for (const float value : voxels)
    if (std::isfinite(value)) {
      low = std::min(low, value);
      high = std::max(high, value);
    }
  if (low > high) return {0, 0};
  return {low, high};
}

/// Black at the 1st, white a little above the 99.5th percentile of what is not background.
Window windowOf(const std::vector<float>& voxels, const std::array<double, 2>& range) {
  constexpr std::size_t enough = 200000;
  std::vector<float> sample;
  const std::size_t step = std::max<std::size_t>(1, voxels.size() / enough) | 1;
  for (std::size_t v = 0; v < voxels.size(); v += step)
    if (std::isfinite(voxels[v]) && voxels[v] > range[0]) sample.push_back(voxels[v]);
  Window window{range[0], range[1], range[0], range[1]};
  if (sample.size() > 100) {
    const auto at = [&](double share) {
      const auto position = sample.begin() + static_cast<std::ptrdiff_t>(share * double(sample.size() - 1));
      std::nth_element(sample.begin(), position, sample.end());
      return double(*position);
    };
    window.lower = std::min(at(0.01), range[0] + 0.1 * (range[1] - range[0]));
    window.upper = std::min(range[1], at(0.995) + 0.05 * (at(0.995) - window.lower));
  }
  if (!(window.upper > window.lower)) window.upper = window.lower + 1;
  window.firstLower = window.lower;
  window.firstUpper = window.upper;
  return window;
}

} // namespace

QString orientationOf(const GridGeometry& geometry, int sliceAxis) {
  static const char* const names[] = {QT_TRANSLATE_NOOP("innergs::app", "sagittal"),
                                      QT_TRANSLATE_NOOP("innergs::app", "coronal"),
                                      QT_TRANSLATE_NOOP("innergs::app", "axial")};
  for (int a = 0; a < 3; ++a)
    if (std::abs(geometry.direction[a][sliceAxis]) > 0.95) return tr(names[a]);
  return tr("oblique");
}

bool hasNoGrid(const VolumeItem& item) {
  return !item.poses.empty() || !item.unplaced.isEmpty();
}

Error noGridError(const VolumeItem& item) {
  return {ErrorCode::Geometry, tr("The slices of '%1' lie on no grid: reconstruct it and use the result.")
                                   .arg(item.name)
                                   .toStdString()};
}

VolumeItem makeItem(Volume volume, const QString& name, const QString& file, double thickness,
                    int sliceAxis) {
  checkGeometry(volume.geometry, "'" + name.toStdString() + "'");
  VolumeItem item;
  item.name = name;
  item.file = file;
  item.thickness = thickness;
  item.sliceAxis = sliceAxis >= 0 ? sliceAxis : sliceAxisOf(volume.geometry.spacing);
  item.range = finiteRange(volume.voxels);
  item.window = std::make_shared<Window>(windowOf(volume.voxels, item.range));
  item.volume = std::make_shared<const Volume>(std::move(volume));
  item.image = imageOf(item.volume, name);
  item.ijkToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
  vtk::toMatrix(item.volume->geometry, item.ijkToRAS);
  return item;
}

VolumeItem makeMeasuredItem(const Uncertainty& uncertainty, const QString& name) {
  VolumeItem item = makeItem(
      Volume{uncertainty.deviation.geometry, {uncertainty.measured.begin(), uncertainty.measured.end()}},
      name);
  item.role = VolumeRole::Made;
  item.saved = false;
  item.segments.push_back({{1, tr("Measured").toStdString()}, {}});
  *item.window = {0, 1, 0, 1};
  return item;
}

VolumeItem makeItem(Uncertainty uncertainty, const QString& name) {
  VolumeItem item = makeItem(std::move(uncertainty.deviation), name);
  item.role = VolumeRole::Made;
  item.saved = false;
  vtk::setMeasured(item.image, uncertainty.measured);
  const double upper = vtk::usualDeviation(item.image);
  *item.window = {0, upper, 0, upper};
  return item;
}

ModelItem makeItem(std::shared_ptr<const Model> model, const QString& name, const QString& file,
                   ModelNotes notes, std::shared_ptr<const FeatureModel> features) {
  ModelItem item;
  item.name = name;
  item.file = item.origin = file;
  item.notes = std::move(notes);
  item.window = {model->field.intensityOffset, model->field.intensityOffset + model->field.intensityScale};
  item.model = vtkSmartPointer<vtkInnerGSModel>::New();
  item.model->SetCoreModel(std::move(model), std::move(features));
  return item;
}

ModelItem makeItem(const std::shared_ptr<const DynamicField>& field, const QString& name, const QString& file,
                   ModelNotes notes, std::shared_ptr<const FeatureModel> features) {
  const auto dynamic = vtkSmartPointer<vtkInnerGSDynamicModel>::New();
  dynamic->SetField(field, std::move(features));
  const auto first = vtkSmartPointer<vtkInnerGSModel>::Take(dynamic->NewModelAt(field->times.front()));
  ModelItem item = makeItem(first->GetCoreModel(), name, file, std::move(notes));
  item.model = first; // which knows the scan's segments
  item.dynamic = dynamic;
  item.time = field->times.front();
  return item;
}

} // namespace innergs::app
