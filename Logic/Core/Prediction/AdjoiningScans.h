#pragma once
#include "Core/Base/Parallel.h"
#include "Core/Image/Stack.h"

namespace innergs {

/// scans[which], with up to `most` slices of its own grid beyond each end, as far as scans with nearly
/// parallel slices show at least half of them: these are interpolated trilinearly from the observed voxels
/// there, the rest of them is NaN. Throws Error(Cancelled).
Stack continued(std::span<const Stack> scans, std::size_t which, int most, ThreadPool& pool);

/// Volumes between the slices of scans that lie beside each other, joined on one grid.
class JoinedVolumes {
public:
  explicit JoinedVolumes(const GridGeometry& grid);

  /// `volume`: a scan's, possibly beyond its ends. It counts by the depth inside the scan, up to two slice
  /// distances; where the scan is not observed, and beyond it, only if no other is there. Resampled by cubic
  /// convolution. Throws Error(Cancelled).
  void add(const Volume& volume, const Stack& scan, ThreadPool& pool);
  /// NaN where there was no volume.
  Volume take();

private:
  Volume sum_;
  std::vector<float> weights_;
};

} // namespace innergs
