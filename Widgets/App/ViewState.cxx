#include "Widgets/App/ViewState.h"

#include "Geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace innergs::app {
namespace {

/// The voxel centre nearest to the middle: planes through it need no interpolation.
Vec3 middleVoxel(const GridGeometry& geometry) {
  Vec3 index;
  for (int a = 0; a < 3; ++a)
    index[a] = static_cast<double>(geometry.size[a] / 2);
  return vtk::flipped(geometry.indexToWorld()(index));
}

} // namespace

ViewState::ViewState(Document* document, QObject* parent) : QObject(parent), document_(document) {
  connect(document, &Document::volumesChanged, this, &ViewState::refresh);
}

void ViewState::refresh() {
  auto item = volume();
  if (!item && !document_->volumes().empty()) {
    setVolumeId(document_->volumes().back()->id);
    return;
  }
  if (item) {
    if (item->volume != shown_) show(item);
    return;
  }
  volumeId_.clear();
  if (!std::exchange(shown_, nullptr)) return;
  Q_EMIT volumeChanged();
}

void ViewState::setVolumeId(const QString& id) {
  const auto item = document_->volume(id);
  if (!item || (id == volumeId_ && shown_ == item->volume)) return;
  volumeId_ = id;
  show(item);
}

void ViewState::show(const std::shared_ptr<VolumeItem>& item) {
  const bool first = !shown_;
  shown_ = item->volume;
  const std::array<double, 6> box = bounds();
  bool inside = !first;
  for (int a = 0; a < 3; ++a)
    inside = inside && crosshair_[a] >= box[2 * a] && crosshair_[a] <= box[2 * a + 1];
  if (!inside) crosshair_ = middleVoxel(item->volume->geometry);
  Q_EMIT volumeChanged();
  if (inside) return;
  Q_EMIT crosshairChanged();
  Q_EMIT placeChanged();
}

void ViewState::setOverlay(std::shared_ptr<const SegmentOverlay> overlay) {
  overlay_ = std::move(overlay);
  Q_EMIT overlayChanged();
}

void ViewState::step(int by) {
  const auto& all = document_->volumes();
  if (all.empty()) return;
  const auto here =
      std::find_if(all.begin(), all.end(), [&](const auto& item) { return item->id == volumeId_; });
  const int count = static_cast<int>(all.size());
  const int at = here == all.end() ? 0 : static_cast<int>(here - all.begin());
  setVolumeId(all[static_cast<std::size_t>(((at + by) % count + count) % count)]->id);
}

void ViewState::setCrosshair(const Vec3& ras) {
  Vec3 inside = ras;
  if (const auto item = volume()) {
    const std::array<double, 6> box = bounds();
    for (int a = 0; a < 3; ++a)
      inside[a] = std::clamp(ras[a], box[2 * a], box[2 * a + 1]);
  }
  if (inside == crosshair_) return;
  crosshair_ = inside;
  Q_EMIT crosshairChanged();
}

void ViewState::setWindow(double lower, double upper) {
  const auto item = volume();
  if (!item || !std::isfinite(lower) || !std::isfinite(upper)) return;
  item->window->lower = lower;
  item->window->upper = std::max(upper, std::nextafter(lower, std::numeric_limits<double>::max()));
  Q_EMIT windowChanged();
}

void ViewState::resetWindow() {
  if (const auto item = volume()) setWindow(item->window->firstLower, item->window->firstUpper);
}

std::array<double, 6> ViewState::bounds() const {
  const auto item = volume();
  if (!item) return {};
  std::array<double, 6> box{INFINITY, -INFINITY, INFINITY, -INFINITY, INFINITY, -INFINITY};
  for (const Vec3& corner : item->volume->geometry.corners()) {
    const Vec3 ras = vtk::flipped(corner);
    for (int a = 0; a < 3; ++a) {
      box[2 * a] = std::min(box[2 * a], ras[a]);
      box[2 * a + 1] = std::max(box[2 * a + 1], ras[a]);
    }
  }
  return box;
}

bool ViewState::valueAt(const Vec3& ras, double& value) const {
  const auto item = volume();
  if (!item) return false;
  const Vec3 index = inverse(item->volume->geometry.indexToWorld())(vtk::flipped(ras));
  float found = 0;
  if (!sampleInside(item->volume->geometry, item->volume->voxels.data(), index, found)) return false;
  value = found;
  return true;
}

double ViewState::stepAlong(int axis) const {
  const auto item = volume();
  if (!item) return 1;
  const GridGeometry& geometry = item->volume->geometry;
  int along = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(geometry.direction[axis][a]) > std::abs(geometry.direction[axis][along])) along = a;
  return geometry.spacing[along];
}

QString ViewState::describe(const Vec3& ras) const {
  static const char* const letters[] = {"RL", "AP", "SI"};
  QString text;
  for (int a = 0; a < 3; ++a)
    text +=
        QStringLiteral("%1 %2  ").arg(QLatin1Char(letters[a][ras[a] < 0])).arg(std::abs(ras[a]), 0, 'f', 1);
  text = text.trimmed() + tr(" mm");
  double value = 0;
  if (valueAt(ras, value)) text += tr(": %1 scanner units").arg(value, 0, 'g', 5);
  return text;
}

} // namespace innergs::app
