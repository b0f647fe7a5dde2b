#include "IO/N4Correction.h"

#include "Core/Base/Error.h"
#include "Core/Base/NumberText.h"
#include "Core/Base/StopToken.h"
#include "Core/Image/Otsu.h"

#include <itkBSplineControlPointImageFilter.h>
#include <itkCommand.h>
#include <itkN4BiasFieldCorrectionImageFilter.h>
#include <itkShrinkImageFilter.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

namespace innergs {
namespace {

constexpr double kFinest = 4;            // mm between the voxels that N4 sees
constexpr double kMostVoxels = 1e5;      // that N4 sees: an iteration must not outlast a cancel for long
constexpr unsigned kLevels = 2;          // each halves the distance of the control points
constexpr unsigned kIterations = 50;     // per level
constexpr double kConverged = 1e-3;      // change of the field
constexpr float kNoise = 0.1f;           // of the maximum: how far noise and interpolation go below zero
constexpr double kMesh = 200;            // mm between the control points of the first level
constexpr std::ptrdiff_t kFewest = 1000; // voxels to find a field in

using Image = itk::Image<float, 3>;
using MaskImage = itk::Image<unsigned char, 3>;
using N4 = itk::N4BiasFieldCorrectionImageFilter<Image, MaskImage, Image>;
using Field = itk::Image<N4::ScalarType, 3>;

/// In the scan's own axes: N4 needs distances only.
template <class ImageType>
typename ImageType::Pointer imageOf(const GridGeometry& g) {
  auto image = ImageType::New();
  typename ImageType::RegionType region;
  typename ImageType::SpacingType spacing;
  for (unsigned a = 0; a < 3; ++a) {
    region.SetSize(a, static_cast<itk::SizeValueType>(g.size[a]));
    spacing[a] = g.spacing[a];
  }
  image->SetRegions(region);
  image->SetSpacing(spacing);
  image->Allocate();
  return image;
}

std::array<unsigned, 3> shrinkFactors(const GridGeometry& g) {
  std::array<unsigned, 3> factors{1, 1, 1};
  double voxels = static_cast<double>(g.voxelCount());
  for (int a = 0; a < 3; ++a) {
    const double most = std::max(1.0, static_cast<double>(g.size[a]) / 4);
    factors[a] = static_cast<unsigned>(std::clamp(std::floor(kFinest / g.spacing[a]), 1.0, most));
    voxels /= factors[a];
  }
  while (voxels > kMostVoxels) {
    int finest = -1;
    for (int a = 0; a < 3; ++a)
      if (8 * factors[a] <= g.size[a] &&
          (finest < 0 || factors[a] * g.spacing[a] < factors[finest] * g.spacing[finest]))
        finest = a;
    if (finest < 0) break;
    voxels *= static_cast<double>(factors[finest]) / (factors[finest] + 1);
    ++factors[finest];
  }
  return factors;
}

template <class ImageType>
typename ImageType::Pointer shrunk(const ImageType* image, const std::array<unsigned, 3>& factors) {
  auto shrink = itk::ShrinkImageFilter<ImageType, ImageType>::New();
  shrink->SetInput(image);
  for (unsigned a = 0; a < 3; ++a)
    shrink->SetShrinkFactor(a, factors[a]);
  shrink->Update();
  return shrink->GetOutput();
}

/// The logarithm of the shading at every voxel of the grid.
Field::Pointer logField(const Image* image, const MaskImage* mask, const GridGeometry& g,
                        const std::stop_token& stop) {
  const std::array<unsigned, 3> factors = shrinkFactors(g);
  const Image::Pointer small = shrunk(image, factors);
  const MaskImage::Pointer smallMask = shrunk(mask, factors);
  auto n4 = N4::New();
  n4->SetInput(small);
  n4->SetMaskImage(smallMask);
  N4::VariableSizeArrayType iterations(kLevels);
  iterations.Fill(kIterations);
  n4->SetMaximumNumberOfIterations(iterations);
  n4->SetNumberOfFittingLevels(kLevels);
  n4->SetConvergenceThreshold(kConverged);
  N4::ArrayType controlPoints;
  for (unsigned a = 0; a < 3; ++a)
    controlPoints[a] =
        n4->GetSplineOrder() + std::max(1u, static_cast<unsigned>(std::ceil(g.extent()[a] / kMesh)));
  n4->SetNumberOfControlPoints(controlPoints);
  auto watch = itk::CStyleCommand::New();
  watch->SetClientData(const_cast<std::stop_token*>(&stop));
  watch->SetCallback([](itk::Object*, const itk::EventObject&, void* token) {
    throwIfStopped(*static_cast<const std::stop_token*>(token));
  });
  n4->AddObserver(itk::IterationEvent(), watch);
  n4->Update();
  auto evaluate = itk::BSplineControlPointImageFilter<N4::BiasFieldControlPointLatticeType, Field>::New();
  evaluate->SetInput(n4->GetLogBiasFieldControlPointLattice());
  evaluate->SetSplineOrder(n4->GetSplineOrder());
  evaluate->SetSize(image->GetLargestPossibleRegion().GetSize());
  evaluate->SetSpacing(image->GetSpacing());
  evaluate->SetOrigin(image->GetOrigin());
  evaluate->SetDirection(image->GetDirection());
  evaluate->Update();
  return evaluate->GetOutput();
}

} // namespace

std::string correctByN4(Stack& stack, bool masked, const std::stop_token& stop) {
  const std::string name = stack.name.empty() ? "The scan" : stack.name;
  const auto unchanged = [&](const char* why) { return "N4 left " + name + " as it is: " + why + "."; };
  if (!stack.poses.empty()) return unchanged("its slices are at poses of their own");
  const GridGeometry& g = stack.image.geometry;
  std::vector<float> seen;
  for (std::size_t v = 0; v < stack.image.voxels.size(); ++v)
    if ((stack.observed.empty() || stack.observed[v]) && std::isfinite(stack.image.voxels[v]))
      seen.push_back(stack.image.voxels[v]);
  const auto [lowest, highest] = std::minmax_element(seen.begin(), seen.end());
  if (!seen.empty() && *lowest < -kNoise * *highest) return unchanged("it has values far below zero");
  // Without a mask, the background must not be taken for a dark part of the body.
  const float least = masked ? 0.f : static_cast<float>(std::max(0.0, otsuThreshold(seen)));
  try {
    const Image::Pointer image = imageOf<Image>(g);
    const MaskImage::Pointer mask = imageOf<MaskImage>(g);
    std::vector<std::size_t> body;
    for (std::size_t v = 0; v < stack.image.voxels.size(); ++v) {
      const float value = stack.image.voxels[v];
      const bool inside =
          std::isfinite(value) && value > least && (stack.observed.empty() || stack.observed[v]);
      image->GetBufferPointer()[v] = std::isfinite(value) ? std::max(value, 0.f) : 0.f;
      mask->GetBufferPointer()[v] = inside;
      if (inside) body.push_back(v);
    }
    if (std::ssize(body) < kFewest) return unchanged("too few voxels show anything");
    throwIfStopped(stop);
    const Field::Pointer field = logField(image, mask, g, stop);
    const N4::ScalarType* logs = field->GetBufferPointer();
    float low = std::numeric_limits<float>::max(), high = std::numeric_limits<float>::lowest();
    double before = 0, after = 0;
    for (const std::size_t v : body) {
      low = std::min(low, logs[v][0]);
      high = std::max(high, logs[v][0]);
      before += stack.image.voxels[v];
      after += stack.image.voxels[v] * std::exp(-static_cast<double>(logs[v][0]));
    }
    const double gain = before / after;
    // Clamped, as nothing constrains the spline far from the body.
    for (std::size_t v = 0; v < stack.image.voxels.size(); ++v)
      stack.image.voxels[v] = static_cast<float>(
          stack.image.voxels[v] * gain * std::exp(-static_cast<double>(std::clamp(logs[v][0], low, high))));
    return formatted("N4 corrected %s: its shading was between %.2f and %.2f of its mean.", name.c_str(),
                     std::exp(static_cast<double>(low)) / gain, std::exp(static_cast<double>(high)) / gain);
  } catch (const itk::ExceptionObject& exception) {
    throw Error(ErrorCode::UnsupportedImage, "N4 failed on " + name + ": " + exception.GetDescription());
  }
}

} // namespace innergs
