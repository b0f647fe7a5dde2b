#pragma once
#include "Core/Acquisition/SampleGrid.h"
#include "Core/Base/Parallel.h"
#include "Core/Model/GaussianField.h"

#include <memory>
#include <span>

namespace innergs {

class FieldDevice;

/// Shows a field on one plane after another, as for a dragged slice: keeps threads, buffers and each
/// Gaussian's reach, and a query visits only the Gaussians near its rectangle. Values are the same as
/// render()'s. With a device, the field stays on it; if the device fails, the CPU takes over.
class PlaneSampler {
public:
  /// instructionSet: as in RenderOptions. device: one that holds the same field; null: the CPU. Throws like
  /// checkField and kernelSet.
  explicit PlaneSampler(std::shared_ptr<const GaussianField> field, int threads = 0,
                        const std::string& instructionSet = {},
                        std::shared_ptr<FieldDevice> device = nullptr);
  ~PlaneSampler();

  const GaussianField& field() const { return *field_; }

  /// Writes the scanner values of nx×ny pixels, rows of x, to `out` (nx·ny). pixelToWorld maps (x, y, 0) to
  /// LPS (mm); its first two columns must span a plane, the third is ignored. Throws Error(InvalidArgument |
  /// Geometry), Error(Cancelled) when stopped.
  void sample(const Affine3& pixelToWorld, int nx, int ny, std::span<float> out, std::stop_token stop = {});

private:
  bool sampledOnDevice(const SampleGrid& grid, float* out, const std::stop_token& stop);
  void measureReach();
  void selectNear(const Affine3& pixelToModel, int nx, int ny);

  std::shared_ptr<const GaussianField> field_;
  std::string instructionSet_;
  std::shared_ptr<FieldDevice> device_; // null: the CPU
  ThreadPool pool_;
  std::vector<float> x_, y_, z_, reach_; // centres and support radii of the Gaussians, mm, model frame
  std::vector<std::vector<std::uint32_t>> chosen_; // per block of Gaussians
  GaussianField near_;                             // the Gaussians of the current query; no residual grid
  std::vector<float> weights_, numerators_;
};

} // namespace innergs
