#include "ImageVoxels.h"

#include "Core/Base/Error.h"
#include "Core/Base/StopToken.h"
#include "Geometry.h"

#include "vtkDataArray.h"
#include "vtkFloatArray.h"
#include "vtkImageData.h"
#include "vtkInformation.h"
#include "vtkMatrix3x3.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkStreamingDemandDrivenPipeline.h"

#include <algorithm>
#include <limits>

namespace innergs::vtk {
namespace {

constexpr vtkIdType kBlock = vtkIdType{1} << 20; // voxels between checks of the stop token

vtkDataArray* arrayOf(vtkImageData* image, const std::string& what) {
  if (!image) throw Error(ErrorCode::NoData, what + " is missing: give an image.");
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  if (image->GetNumberOfPoints() == 0 || !scalars || scalars->GetNumberOfTuples() == 0)
    throw Error(ErrorCode::NoData,
                what + " has no voxels: choose an image that has been loaded or computed.");
  if (scalars->GetNumberOfTuples() != image->GetNumberOfPoints())
    throw Error(ErrorCode::FileFormat, what + " does not have one value per voxel: its data are damaged.");
  return scalars;
}

vtkDataArray* scalarsOf(vtkImageData* image, const std::string& what) {
  vtkDataArray* scalars = arrayOf(image, what);
  if (const int components = scalars->GetNumberOfComponents(); components != 1)
    throw Error(ErrorCode::UnsupportedImage,
                what + " has " + std::to_string(components) +
                    " values per voxel (a colour, vector or complex image): give a scalar image, for example "
                    "one of its components.");
  return scalars;
}

/// Calls `use` with the scalars in memory order, in their own type.
template <class Use>
void withScalars(vtkDataArray* scalars, const std::string& what, Use use) {
  switch (scalars->GetDataType()) {
    vtkTemplateMacro(use(static_cast<const VTK_TT*>(scalars->GetVoidPointer(0))));
  default:
    throw Error(ErrorCode::UnsupportedImage,
                what + " has voxels of a type that is not a number: convert it to a numeric type.");
  }
}

void throwIf(const std::stop_token& stop) {
  throwIfStopped(stop);
}

} // namespace

void checkVoxels(vtkImageData* image, const std::string& what) {
  scalarsOf(image, what);
}

std::vector<float> voxelsOf(vtkImageData* image, const VoxelBlock& block, const std::string& what,
                            const std::stop_token& stop) {
  vtkDataArray* scalars = scalarsOf(image, what);
  int dimensions[3];
  image->GetDimensions(dimensions);
  const std::array<std::int64_t, 3> strides{1, dimensions[0], std::int64_t{dimensions[0]} * dimensions[1]};
  const std::array<int, 3> from = axesWithSliceAxis(block.sliceAxis);
  std::array<std::int64_t, 3> n, step;
  std::int64_t start = 0, count = 1;
  for (int a = 0; a < 3; ++a) {
    n[a] = block.size[from[a]];
    step[a] = strides[from[a]];
    start += block.first[a] * strides[a];
    count *= n[a];
    if (block.first[a] < 0 || block.size[a] < 0 || block.first[a] + block.size[a] > dimensions[a])
      throw Error(ErrorCode::Internal, what + " was to be read beyond its voxels: please report this.");
  }
  std::vector<float> result(static_cast<std::size_t>(count));
  withScalars(scalars, what, [&](const auto* source) {
    float* out = result.data();
    for (std::int64_t k = 0; k < n[2]; ++k) {
      throwIf(stop);
      for (std::int64_t j = 0; j < n[1]; ++j) {
        const auto* in = source + start + j * step[1] + k * step[2];
        for (std::int64_t i = 0; i < n[0]; ++i)
          *out++ = static_cast<float>(in[i * step[0]]);
      }
    }
  });
  return result;
}

std::vector<std::vector<float>> componentsOf(vtkImageData* image, const std::string& what,
                                             const std::stop_token& stop) {
  vtkDataArray* scalars = arrayOf(image, what);
  const vtkIdType count = scalars->GetNumberOfTuples();
  const auto components = static_cast<std::size_t>(scalars->GetNumberOfComponents());
  std::vector<std::vector<float>> result(components, std::vector<float>(static_cast<std::size_t>(count)));
  withScalars(scalars, what, [&](const auto* source) {
    for (vtkIdType v = 0; v < count; ++v) {
      if (v % kBlock == 0) throwIf(stop);
      for (std::size_t c = 0; c < components; ++c)
        result[c][static_cast<std::size_t>(v)] = static_cast<float>(*source++);
    }
  });
  return result;
}

std::vector<std::uint8_t> maskOf(vtkImageData* image, const std::string& what, const std::stop_token& stop) {
  vtkDataArray* scalars = scalarsOf(image, what);
  const vtkIdType count = scalars->GetNumberOfTuples();
  std::vector<std::uint8_t> result(static_cast<std::size_t>(count));
  withScalars(scalars, what, [&](const auto* source) {
    for (vtkIdType first = 0; first < count; first += kBlock) {
      throwIf(stop);
      const vtkIdType last = std::min(count, first + kBlock);
      for (vtkIdType v = first; v < last; ++v)
        result[v] = source[v] != 0;
    }
  });
  return result;
}

float* allocateFloats(vtkImageData* image, const GridGeometry& geometry, bool withGeometry, int components) {
  for (const std::int64_t n : geometry.size)
    if (n > std::numeric_limits<int>::max())
      throw Error(ErrorCode::Geometry,
                  "The output grid has more voxels along an axis than an image can hold.");
  image->SetDimensions(static_cast<int>(geometry.size[0]), static_cast<int>(geometry.size[1]),
                       static_cast<int>(geometry.size[2]));
  placeImage(image, geometry, withGeometry);
  image->AllocateScalars(VTK_FLOAT, components);
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  scalars->SetName("Intensity");
  return static_cast<float*>(scalars->GetVoidPointer(0));
}

void announceImage(vtkInformation* output, const GridGeometry& geometry, bool withGeometry) {
  int extent[6];
  for (int a = 0; a < 3; ++a) {
    extent[2 * a] = 0;
    extent[2 * a + 1] =
        static_cast<int>(std::min<std::int64_t>(geometry.size[a], std::numeric_limits<int>::max())) - 1;
  }
  vtkNew<vtkImageData> placed;
  placeImage(placed, geometry, withGeometry);
  output->Set(vtkStreamingDemandDrivenPipeline::WHOLE_EXTENT(), extent, 6);
  output->Set(vtkDataObject::ORIGIN(), placed->GetOrigin(), 3);
  output->Set(vtkDataObject::SPACING(), placed->GetSpacing(), 3);
  output->Set(vtkDataObject::DIRECTION(), placed->GetDirectionMatrix()->GetData(), 9);
  vtkDataObject::SetPointDataActiveScalarInfo(output, VTK_FLOAT, 1);
}

} // namespace innergs::vtk
