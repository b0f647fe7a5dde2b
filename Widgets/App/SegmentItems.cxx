#include "Widgets/App/SegmentItems.h"

#include "Geometry.h"

#include <QCoreApplication>

#include <algorithm>

namespace innergs::app {
namespace {

/// Calls each(voxel of the box, n) for the voxels of the n-th segment; box: a part of the grid from
/// `first` on, of `size` voxels.
template <class Each>
void forVoxels(const MadeSegments& made, const std::array<std::int64_t, 3>& first,
               const std::array<std::int64_t, 3>& size, Each&& each) {
  for (std::size_t n = 0; n < made.segments.size(); ++n) {
    const Segment& s = made.segments[n].second;
    std::size_t at = 0;
    for (std::int64_t k = 0; k < s.geometry.size[2]; ++k)
      for (std::int64_t j = 0; j < s.geometry.size[1]; ++j)
        for (std::int64_t i = 0; i < s.geometry.size[0]; ++i, ++at)
          if (s.mask[at])
            each(s.first[0] + i - first[0] +
                     size[0] * (s.first[1] + j - first[1] + size[1] * (s.first[2] + k - first[2])),
                 n);
  }
}

} // namespace

std::shared_ptr<const SegmentOverlay> overlayOf(const MadeSegments& made) {
  std::array<std::int64_t, 3> low = made.grid.size, high{0, 0, 0}, size;
  bool any = false;
  for (const auto& [terms, s] : made.segments)
    for (int a = 0; a < 3 && s.voxels > 0; ++a) {
      any = true;
      low[a] = std::min(low[a], s.first[a]);
      high[a] = std::max(high[a], s.first[a] + s.geometry.size[a]);
    }
  if (!any) return nullptr;
  for (int a = 0; a < 3; ++a)
    size[a] = high[a] - low[a];
  auto overlay = std::make_shared<SegmentOverlay>();
  overlay->labels = vtkSmartPointer<vtkImageData>::New();
  overlay->labels->SetDimensions(static_cast<int>(size[0]), static_cast<int>(size[1]),
                                 static_cast<int>(size[2]));
  overlay->labels->AllocateScalars(VTK_UNSIGNED_SHORT, 1);
  auto* labels = static_cast<unsigned short*>(overlay->labels->GetScalarPointer());
  std::fill_n(labels, size[0] * size[1] * size[2], static_cast<unsigned short>(0));
  forVoxels(made, low, size,
            [&](std::int64_t voxel, std::size_t n) { labels[voxel] = static_cast<unsigned short>(n + 1); });
  overlay->ijkToRAS = vtkSmartPointer<vtkMatrix4x4>::New();
  vtk::toMatrix(cropped(made.grid, low, size), overlay->ijkToRAS);
  for (const auto& [terms, s] : made.segments)
    overlay->colors.push_back(terms.color);
  return overlay;
}

QString nameOf(const MadeSegments& made) {
  if (made.segments.empty()) return {};
  const QString first = QString::fromStdString(made.segments[0].first.name);
  const int more = static_cast<int>(made.segments.size()) - 1;
  return more == 0 ? first
                   : QCoreApplication::translate("innergs::app", "%1 and %n more", nullptr, more).arg(first);
}

VolumeItem labelmapOf(const MadeSegments& made) {
  Volume volume{made.grid, {}};
  volume.voxels.assign(static_cast<std::size_t>(made.grid.voxelCount()), 0.f);
  forVoxels(made, {0, 0, 0}, made.grid.size, [&](std::int64_t voxel, std::size_t n) {
    volume.voxels[static_cast<std::size_t>(voxel)] = static_cast<float>(n + 1);
  });
  VolumeItem item = makeItem(std::move(volume), nameOf(made));
  item.role = VolumeRole::Made;
  item.saved = false;
  for (std::size_t n = 0; n < made.segments.size(); ++n) {
    const SegmentTerms& terms = made.segments[n].first;
    item.segments.push_back(
        {{static_cast<std::uint16_t>(n + 1), terms.name}, terminologyEntry(terms), terms.color});
  }
  return item;
}

} // namespace innergs::app
