#pragma once
#include "Core/Acquisition/Lattice.h"
#include "Core/Base/Parallel.h"
#include "Core/Model/GaussianField.h"

#include <memory>
#include <span>

namespace innergs {

class FieldDevice;

/// A field ready to be shown on one plane after the other, as a dragged slice needs it: threads, buffers and
/// each Gaussian's reach are kept, and a query looks only at the Gaussians near its rectangle. The values are
/// render()'s. On a device the field itself is kept there; where that fails the CPU takes over.
class PlaneSampler {
public:
  /// instructionSet: as in RenderOptions. device: one that holds the same field; null: the CPU. Throws as
  /// checkField and kernelSet do.
  explicit PlaneSampler(std::shared_ptr<const GaussianField> field, int threads = 0,
                        const std::string& instructionSet = {},
                        std::shared_ptr<FieldDevice> device = nullptr);
  ~PlaneSampler();

  const GaussianField& field() const { return *field_; }

  /// Scanner values of nx×ny pixels, rows of x, into `out` (nx·ny). pixelToWorld maps (x, y, 0) to LPS (mm);
  /// any columns that span a plane will do, the third one is not used. Throws Error(InvalidArgument |
  /// Geometry), Error(Cancelled) when stopped.
  void sample(const Affine3& pixelToWorld, int nx, int ny, std::span<float> out, std::stop_token stop = {});

private:
  bool sampledOnDevice(const Lattice& lattice, float* out, const std::stop_token& stop);
  void measureReach();
  void selectNear(const Affine3& pixelToModel, int nx, int ny);

  std::shared_ptr<const GaussianField> field_;
  std::string instructionSet_;
  std::shared_ptr<FieldDevice> device_; // null: the CPU
  ThreadPool pool_;
  std::vector<float> x_, y_, z_, reach_; // centres and radii of the Gaussians' support, mm, model frame
  std::vector<std::vector<std::uint32_t>> chosen_; // per block of Gaussians
  GaussianField near_;                             // those of the query in hand; no detail
  std::vector<float> weights_, numerators_;
};

} // namespace innergs
