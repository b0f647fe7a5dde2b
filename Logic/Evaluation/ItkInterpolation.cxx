#include "Evaluation/ItkInterpolation.h"

#include <algorithm>
#include <itkBSplineInterpolateImageFunction.h>
#include <itkImage.h>
#include <itkLinearInterpolateImageFunction.h>
#include <itkWindowedSincInterpolateImageFunction.h>

namespace innergs {
namespace {

using Image = itk::Image<float, 3>;

// A unit grid: positions are computed with our own index maps, so ITK only sees indices.
Image::Pointer indexImage(const std::array<std::int64_t, 3>& size, const float* voxels) {
  auto image = Image::New();
  Image::RegionType region;
  for (unsigned axis = 0; axis < 3; ++axis)
    region.SetSize(axis, static_cast<itk::SizeValueType>(size[axis]));
  image->SetRegions(region);
  image->Allocate();
  std::copy_n(voxels, region.GetNumberOfPixels(), image->GetBufferPointer());
  return image;
}

template <typename Interpolator>
std::vector<float> evaluate(const Interpolator& interpolator, const GridGeometry& image,
                            const GridGeometry& grid, ThreadPool& pool) {
  const Affine3 toImage = inverse(image.indexToWorld()) * grid.indexToWorld();
  std::vector<float> out(static_cast<std::size_t>(grid.voxelCount()));
  pool.run(grid.size[2] * grid.size[1], [&](std::int64_t row) {
    const std::int64_t j = row % grid.size[1], k = row / grid.size[1];
    for (std::int64_t i = 0; i < grid.size[0]; ++i) {
      const Vec3 x = toImage({double(i), double(j), double(k)});
      typename Interpolator::ContinuousIndexType index;
      for (unsigned axis = 0; axis < 3; ++axis)
        index[axis] = std::clamp(x[axis], 0.0, double(image.size[axis] - 1));
      out[static_cast<std::size_t>(row * grid.size[0] + i)] =
          static_cast<float>(interpolator.EvaluateAtContinuousIndex(index));
    }
  });
  return out;
}

} // namespace

std::vector<float> resampleWithItk(const Volume& image, const GridGeometry& grid, Interpolation kind,
                                   ThreadPool& pool) {
  const auto input = indexImage(image.geometry.size, image.voxels.data());
  const auto run = [&](auto interpolator) {
    interpolator->SetInputImage(input);
    return evaluate(*interpolator, image.geometry, grid, pool);
  };
  // ITK's cubic B-splines read beyond an image of fewer than three voxels along an axis.
  const auto& size = image.geometry.size;
  const bool thin = kind == Interpolation::Cubic && *std::min_element(size.begin(), size.end()) < 3;
  if (kind == Interpolation::Linear || thin)
    return run(itk::LinearInterpolateImageFunction<Image, double>::New());
  if (kind == Interpolation::Cubic) {
    auto interpolator = itk::BSplineInterpolateImageFunction<Image, double, double>::New();
    interpolator->SetSplineOrder(3);
    return run(interpolator);
  }
  using Sinc = itk::WindowedSincInterpolateImageFunction<Image, 4, itk::Function::LanczosWindowFunction<4>>;
  std::vector<float> out = run(Sinc::New());
  // ITK's weights do not sum to 1, so this divides by the result for a constant image.
  const std::vector<float> constant(image.voxels.size(), 1.0f);
  auto unit = Sinc::New();
  unit->SetInputImage(indexImage(image.geometry.size, constant.data()));
  const std::vector<float> sums = evaluate(*unit, image.geometry, grid, pool);
  for (std::size_t p = 0; p < out.size(); ++p)
    out[p] /= sums[p];
  return out;
}

struct ItkCubic::Impl {
  GridGeometry geometry;
  itk::BSplineInterpolateImageFunction<Image, double, double>::Pointer interpolator =
      itk::BSplineInterpolateImageFunction<Image, double, double>::New();
};

ItkCubic::ItkCubic(const Volume& image) : impl_(std::make_unique<Impl>()) {
  impl_->geometry = image.geometry;
  impl_->interpolator->SetSplineOrder(3);
  impl_->interpolator->SetInputImage(indexImage(image.geometry.size, image.voxels.data()));
}

ItkCubic::~ItkCubic() = default;

std::vector<float> ItkCubic::on(const GridGeometry& grid, ThreadPool& pool) const {
  return evaluate(*impl_->interpolator, impl_->geometry, grid, pool);
}

} // namespace innergs
