#include "Core/Render.h"

#include "Core/BackProjection.h"
#include "Core/DetailSampler.h"
#include "Core/DomainBox.h"
#include "Core/Error.h"
#include "Core/Loss.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

constexpr std::size_t kChunk = std::size_t{1} << 23; // samples rendered at once: bounds the scratch memory

void checkValues(const GaussianField& field, const RenderOptions& options) {
  if (!options.values.empty() && static_cast<std::int64_t>(options.values.size()) != field.size())
    throw Error(ErrorCode::InvalidArgument,
                "A channel needs one value per Gaussian: " + std::to_string(field.size()) +
                    " are expected, " + std::to_string(options.values.size()) + " were given.");
}

/// Final value of one point, in the units asked for.
struct Finish {
  explicit Finish(const GaussianField& field, const RenderOptions& options)
      : normalised(field.blending == Blending::Normalised), epsilon(static_cast<float>(field.epsilon)) {
    ownChannel = options.values.empty();
    if (options.scannerUnits && ownChannel) {
      scale = field.intensityScale;
      offset = field.intensityOffset;
    }
  }
  float operator()(float w, float n, const DetailSampler& detail, const Vec3& at) const {
    const float value = normalised ? n / (w + epsilon) : n;
    return units(ownChannel ? value + detail(at) : value);
  }
  float units(float value) const { return static_cast<float>(scale * value + offset); }
  bool normalised, ownChannel;
  float epsilon;
  double scale = 1, offset = 0;
};

} // namespace

Volume render(const GaussianField& field, const GridGeometry& geometry, const RenderOptions& options) {
  checkGeometry(geometry, "The output grid");
  checkValues(field, options);
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const KernelSet& kernels = kernelSet(options.instructionSet, options.selection);
  const Finish finish(field, options);
  const DetailSampler detail(field, geometry.indexToWorld());
  const DomainBox box(field.domain, geometry.indexToWorld());
  Volume volume{geometry, {}};
  volume.voxels.resize(geometry.voxelCount());
  Lattice lattice;
  lattice.indexToModel = inverse(field.modelToWorld) * geometry.indexToWorld();
  lattice.nx = static_cast<int>(geometry.size[0]);
  lattice.ny = static_cast<int>(geometry.size[1]);
  const int chunk = static_cast<int>(
      std::clamp<std::int64_t>(kChunk / std::max<std::size_t>(1, lattice.planeSize()), 1, geometry.size[2]));
  std::vector<float> weights(lattice.planeSize() * chunk), numerators(weights.size());
  for (std::int64_t first = 0; first < geometry.size[2]; first += chunk) {
    const std::int64_t last = std::min(geometry.size[2], first + chunk);
    lattice.z.clear();
    for (std::int64_t k = first; k < last; ++k)
      lattice.z.push_back(static_cast<double>(k));
    LatticeRenderer renderer(lattice, kernels, pool);
    renderer.forward(field, options.values, weights.data(), numerators.data());
    pool.run((last - first) * lattice.ny, [&](std::int64_t row) {
      const float* w = weights.data() + row * lattice.stride();
      const float* n = numerators.data() + row * lattice.stride();
      const double y = static_cast<double>(row % lattice.ny),
                   z = static_cast<double>(first + row / lattice.ny);
      float* out = volume.voxels.data() + (first * lattice.ny + row) * lattice.nx;
      int begin = 0, end = lattice.nx;
      box.clipRow(y, z, begin, end);
      std::fill_n(out, lattice.nx, finish.units(0));
      for (int x = begin; x < end; ++x)
        out[x] = finish(w[x], n[x], detail, {static_cast<double>(x), y, z});
    });
  }
  return volume;
}

Volume renderStack(const GaussianField& field, const Stack& stack, const RenderOptions& options) {
  checkValues(field, options);
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const KernelSet& kernels = kernelSet(options.instructionSet, options.selection);
  const Finish finish(field, options);
  Stack blank = stack;
  std::fill(blank.image.voxels.begin(), blank.image.voxels.end(), 0.f);
  blank.image.voxels.resize(blank.image.geometry.voxelCount());
  blank.observed.clear();
  checkStack(blank);
  Volume volume = std::move(blank.image);
  blank.image = volume;
  std::vector<float> weights, numerators, slice;
  const std::vector<float> detail = field.detail.voxels.empty() || !options.values.empty()
                                        ? std::vector<float>{}
                                        : projectToStack(field.detail, blank, pool);
  const bool closedForm = field.blending == Blending::Additive && !field.linearIntensity;
  for (const Observation& o : observe(blank, field.modelToWorld, {}, closedForm)) {
    LatticeRenderer renderer(o.lattice, kernels, pool, o.psf);
    weights.resize(o.lattice.bufferSize());
    numerators.resize(o.lattice.bufferSize());
    slice.resize(o.sliceSize());
    renderer.forward(field, options.values, weights.data(), numerators.data());
    for (int s = 0; s < o.slices; ++s) {
      composeSlice(o, s, weights.data(), numerators.data(), field, slice.data());
      std::size_t at = static_cast<std::size_t>(o.sourceSlice[s]) * o.lattice.nx * o.lattice.ny;
      for (int y = 0; y < o.lattice.ny; ++y)
        for (int x = 0; x < o.lattice.nx; ++x, ++at) {
          const float fine = detail.empty() || !std::isfinite(detail[at]) ? 0.f : detail[at];
          volume.voxels[at] =
              finish.units(slice[static_cast<std::size_t>(y) * o.lattice.stride() + x] + fine);
        }
    }
  }
  return volume;
}

std::vector<std::string> instructionSets() {
  std::vector<std::string> names;
  for (const KernelSet& set : kernelSets())
    names.push_back(set.name);
  return names;
}

} // namespace innergs
