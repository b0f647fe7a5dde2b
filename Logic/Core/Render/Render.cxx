#include "Core/Render/Render.h"

#include "Core/Acquisition/ProjectToStack.h"
#include "Core/Base/Error.h"
#include "Core/Image/Region.h"
#include "Core/Model/FieldValue.h"
#include "Core/Render/FieldDevice.h"
#include "Core/Render/GridRenderer.h"
#include "Core/Render/SliceComposition.h"

#include <algorithm>
#include <cmath>

namespace innergs {
namespace {

void checkValues(const GaussianField& field, const RenderOptions& options) {
  if (!options.values.empty() && static_cast<std::int64_t>(options.values.size()) != field.size())
    throw Error(ErrorCode::InvalidArgument,
                "A channel needs one value per Gaussian: " + std::to_string(field.size()) +
                    " are expected, " + std::to_string(options.values.size()) + " were given.");
}

FieldValue::Options valueOptions(const RenderOptions& options) {
  return {options.values.empty(), options.scannerUnits, options.bounded, options.instructionSet};
}

/// Renders I at the points of a grid, [plane][ny][nx], on the device of the options. Returns false if
/// there is none or it fails; a device that failed is not tried again.
bool renderedOnDevice(RenderOptions& options, const SampleGrid& grid, const ClosedFormPsf& psf, float* out) {
  if (!options.device) return false;
  try {
    options.device->renderGrid(grid, psf, options.values, out, options.stop);
    return true;
  } catch (const Error& error) {
    if (error.code() == ErrorCode::Cancelled) throw;
  } catch (const std::exception&) {
  }
  options.device = nullptr;
  return false;
}

/// composeSlice() from I, [plane][ny][nx].
void composeRendered(const Observation& o, int slice, const float* image, float* out) {
  std::fill_n(out, o.sliceSize(), 0.f);
  for (int q = 0; q < o.perSlice; ++q) {
    const auto [plane, share] = o.subPlanes[static_cast<std::size_t>(slice) * o.perSlice + q];
    const float* in = image + static_cast<std::size_t>(plane) * o.grid.nx * o.grid.ny;
    for (int y = 0; y < o.grid.ny; ++y, in += o.grid.nx)
      for (int x = 0; x < o.grid.nx; ++x)
        out[static_cast<std::size_t>(y) * o.grid.stride() + x] += share * in[x];
  }
}

/// How many samples to render at once. Every chunk projects all Gaussians; larger ones touch more fresh
/// memory.
std::size_t chunkOf(const GaussianField& field) {
  return std::clamp<std::size_t>(32 * field.gaussians.size(), std::size_t{1} << 21, std::size_t{1} << 23);
}

/// render() for one checked grid.
Volume renderGrid(const GaussianField& field, const GridGeometry& geometry, RenderOptions& options) {
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const KernelSet& kernels = kernelSet(options.instructionSet, options.selection);
  const FieldValue value(field, geometry.indexToWorld(), valueOptions(options));
  const bool normalised = field.blending == Blending::Normalised;
  const auto epsilon = static_cast<float>(field.epsilon);
  Volume volume{geometry, {}};
  volume.voxels.resize(geometry.voxelCount());
  SampleGrid grid = sampleGridOf(geometry, field.modelToWorld, 0, 0);
  const int chunk = static_cast<int>(std::clamp<std::int64_t>(
      chunkOf(field) / std::max<std::size_t>(1, grid.planeSize()), 1, geometry.size[2]));
  std::vector<float> weights, numerators;
  for (std::int64_t first = 0; first < geometry.size[2]; first += chunk) {
    const std::int64_t last = std::min(geometry.size[2], first + chunk);
    grid = sampleGridOf(geometry, field.modelToWorld, first, last);
    float* values = volume.voxels.data() + first * grid.ny * grid.nx;
    const bool ready = renderedOnDevice(options, grid, {}, values);
    if (!ready) {
      weights.resize(grid.planeSize() * chunk);
      numerators.resize(weights.size());
      GridRenderer renderer(grid, kernels, pool);
      renderer.forward(field, options.values, weights.data(), numerators.data());
    }
    pool.run((last - first) * grid.ny, [&](std::int64_t row) {
      const float* w = weights.data() + (ready ? 0 : row * grid.stride());
      const float* n = numerators.data() + (ready ? 0 : row * grid.stride());
      float* out = values + row * grid.nx;
      value.row(static_cast<double>(row % grid.ny), static_cast<double>(first + row / grid.ny), grid.nx, out,
                [&](int x) { return ready        ? out[x]
                                    : normalised ? n[x] / (w[x] + epsilon)
                                                 : n[x]; });
    });
  }
  return volume;
}

/// Which voxels of a stack have their centre inside the support.
std::vector<std::uint8_t> supportedVoxels(const FieldValue& value, const Stack& stack) {
  const GridGeometry& g = stack.image.geometry;
  std::vector<std::uint8_t> inside;
  inside.reserve(stack.image.voxels.size());
  for (std::int64_t k = 0; k < g.size[2]; ++k) {
    const Affine3 map = stack.poses.empty() ? g.indexToWorld() : stack.poses[k] * g.indexToWorld();
    for (std::int64_t j = 0; j < g.size[1]; ++j)
      for (std::int64_t i = 0; i < g.size[0]; ++i)
        inside.push_back(
            value.supported(map({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)})));
  }
  return inside;
}

/// Puts a block back into its grid and fills the rest.
Volume embedded(const Volume& part, const IndexBlock& block, const GridGeometry& geometry, float fill) {
  Volume whole{geometry, std::vector<float>(static_cast<std::size_t>(geometry.voxelCount()), fill)};
  const float* in = part.voxels.data();
  for (std::int64_t k = 0; k < block.size[2]; ++k)
    for (std::int64_t j = 0; j < block.size[1]; ++j, in += block.size[0])
      std::copy_n(in, block.size[0],
                  whole.voxels.begin() + block.first[0] +
                      geometry.size[0] * (block.first[1] + j + geometry.size[1] * (block.first[2] + k)));
  return whole;
}

} // namespace

Volume render(const GaussianField& field, const GridGeometry& geometry, const RenderOptions& given) {
  RenderOptions options = given;
  checkGeometry(geometry, "The output grid");
  checkValues(field, options);
  if (!options.bounded || field.support.voxels.empty()) return renderGrid(field, geometry, options);
  const auto block = blockOver(geometry, boxOf(field.support.geometry));
  const float fill = FieldValue(field, {}, valueOptions(options)).outside();
  if (!block) return embedded({}, {}, geometry, fill);
  if (block->size == geometry.size) return renderGrid(field, geometry, options);
  return embedded(renderGrid(field, cropped(geometry, block->first, block->size), options), *block, geometry,
                  fill);
}

Volume renderStack(const GaussianField& field, const Stack& stack, const RenderOptions& given) {
  RenderOptions options = given;
  checkValues(field, options);
  ThreadPool pool(options.threads);
  pool.setStop(options.stop);
  const KernelSet& kernels = kernelSet(options.instructionSet, options.selection);
  Stack blank = stack;
  std::fill(blank.image.voxels.begin(), blank.image.voxels.end(), 0.f);
  blank.image.voxels.resize(blank.image.geometry.voxelCount());
  blank.observed.clear();
  checkStack(blank);
  Volume volume = std::move(blank.image);
  blank.image = volume;
  const FieldValue value(field, {}, valueOptions(options));
  if (value.limited()) { // skips slices without a supported voxel
    std::fill(volume.voxels.begin(), volume.voxels.end(), value.outside());
    blank.observed = supportedVoxels(value, blank);
  }
  std::vector<float> weights, numerators, slice;
  const std::vector<float> residual =
      field.residual.voxels.empty() || !options.values.empty()
          ? std::vector<float>{}
          : projectToStack(field.residual, blank, pool, ResidualSampler::kKeys);
  const bool closedForm = field.blending == Blending::Additive && !field.linearIntensity;
  const GridGeometry region = field.region();
  const double resolution = region.voxelCount() > 0 ? region.finestSpacing() : 0;
  GaussianBlocks blocks;
  if (!blank.poses.empty()) blocks.measure(field, pool);
  for (const Observation& o : observe(blank, field.modelToWorld, {}, closedForm, false, resolution)) {
    weights.resize(o.bufferSize());
    slice.resize(o.sliceSize());
    bool ready = true; // by the device
    const std::size_t image = static_cast<std::size_t>(o.grid.nx) * o.grid.ny * o.grid.planes();
    for (std::size_t p = 0; p < o.points.size(); ++p)
      ready = ready && renderedOnDevice(options, o.gridOf(p), o.psf, weights.data() + p * image);
    if (!ready) {
      numerators.resize(o.bufferSize());
      for (std::size_t p = 0; p < o.points.size(); ++p) {
        const std::size_t part = p * o.grid.bufferSize();
        GridRenderer renderer(o.gridOf(p), kernels, pool, o.psf);
        renderer.forward(field, options.values, weights.data() + part, numerators.data() + part,
                         blank.poses.empty() ? nullptr : &blocks);
      }
    }
    for (int s = 0; s < o.slices; ++s) {
      if (ready)
        composeRendered(o, s, weights.data(), slice.data());
      else
        composeSlice(o, s, weights.data(), numerators.data(), field, slice.data());
      std::size_t at = static_cast<std::size_t>(o.sourceSlice[s]) * o.grid.nx * o.grid.ny;
      for (int y = 0; y < o.grid.ny; ++y)
        for (int x = 0; x < o.grid.nx; ++x, ++at) {
          const float fine = residual.empty() || !std::isfinite(residual[at]) ? 0.f : residual[at];
          if (blank.observed.empty() || blank.observed[at])
            volume.voxels[at] = value.final(slice[static_cast<std::size_t>(y) * o.grid.stride() + x] + fine);
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
