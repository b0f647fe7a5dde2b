#include "ImageVoxels.h"

#include "Core/Error.h"
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

constexpr vtkIdType kBlock = vtkIdType{1} << 20; // voxels between two looks at the stop token

vtkDataArray* scalarsOf(vtkImageData* image, const std::string& what) {
  if (!image) throw Error(ErrorCode::NoData, what + " is missing: give an image.");
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  if (image->GetNumberOfPoints() == 0 || !scalars || scalars->GetNumberOfTuples() == 0)
    throw Error(ErrorCode::NoData,
                what + " has no voxels: choose an image that has been loaded or computed.");
  if (const int components = scalars->GetNumberOfComponents(); components != 1)
    throw Error(ErrorCode::UnsupportedImage,
                what + " has " + std::to_string(components) +
                    " values per voxel (a colour, vector or complex image): give a scalar image, for example "
                    "one of its components.");
  if (scalars->GetNumberOfTuples() != image->GetNumberOfPoints())
    throw Error(ErrorCode::FileFormat, what + " does not have one value per voxel: its data are damaged.");
  return scalars;
}

template <class Out, class Convert>
std::vector<Out> converted(vtkImageData* image, const std::string& what, const std::stop_token& stop,
                           Convert convert) {
  vtkDataArray* scalars = scalarsOf(image, what);
  const vtkIdType count = scalars->GetNumberOfTuples();
  std::vector<Out> result(static_cast<std::size_t>(count));
  const auto copy = [&](const auto* source) {
    for (vtkIdType first = 0; first < count; first += kBlock) {
      if (stop.stop_requested()) throw Error(ErrorCode::Cancelled, "Stopped on request.");
      const vtkIdType last = std::min(count, first + kBlock);
      for (vtkIdType v = first; v < last; ++v)
        result[v] = convert(source[v]);
    }
  };
  switch (scalars->GetDataType()) {
    vtkTemplateMacro(copy(static_cast<const VTK_TT*>(scalars->GetVoidPointer(0))));
  default:
    throw Error(ErrorCode::UnsupportedImage,
                what + " has voxels of a type that is not a number: convert it to a numeric type.");
  }
  return result;
}

} // namespace

std::vector<float> voxelsOf(vtkImageData* image, const std::string& what, const std::stop_token& stop) {
  return converted<float>(image, what, stop, [](auto x) { return static_cast<float>(x); });
}

std::vector<std::uint8_t> maskOf(vtkImageData* image, const std::string& what, const std::stop_token& stop) {
  return converted<std::uint8_t>(image, what, stop, [](auto x) { return static_cast<std::uint8_t>(x != 0); });
}

float* allocateFloats(vtkImageData* image, const GridGeometry& geometry, bool withGeometry) {
  for (const std::int64_t n : geometry.size)
    if (n > std::numeric_limits<int>::max())
      throw Error(ErrorCode::Geometry,
                  "The output grid has more voxels along an axis than an image can hold.");
  image->SetDimensions(static_cast<int>(geometry.size[0]), static_cast<int>(geometry.size[1]),
                       static_cast<int>(geometry.size[2]));
  placeImage(image, geometry, withGeometry);
  image->AllocateScalars(VTK_FLOAT, 1);
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
