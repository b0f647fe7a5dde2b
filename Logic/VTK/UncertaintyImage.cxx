#include "UncertaintyImage.h"

#include "Core/Base/Error.h"
#include "Core/Uncertainty/ErrorCurve.h"
#include "Geometry.h"
#include "ImageVoxels.h"

#include "vtkDataArray.h"
#include "vtkImageData.h"
#include "vtkNew.h"
#include "vtkPointData.h"
#include "vtkUnsignedCharArray.h"

#include <algorithm>
#include <cmath>

namespace innergs::vtk {
namespace {

constexpr const char* kDeviation = "StandardDeviation";
constexpr const char* kMeasured = "Measured";

/// Uninitialised, one per voxel.
std::uint8_t* addMeasured(vtkImageData* image) {
  vtkNew<vtkUnsignedCharArray> measured;
  measured->SetName(kMeasured);
  measured->SetNumberOfTuples(image->GetNumberOfPoints());
  image->GetPointData()->AddArray(measured);
  return measured->GetPointer(0);
}

} // namespace

void setUncertainty(vtkImageData* image, const Uncertainty& uncertainty, bool withGeometry) {
  const Volume& deviation = uncertainty.deviation;
  std::copy(deviation.voxels.begin(), deviation.voxels.end(),
            allocateFloats(image, deviation.geometry, withGeometry));
  image->GetPointData()->GetScalars()->SetName(kDeviation);
  setMeasured(image, uncertainty.measured);
}

void setMeasured(vtkImageData* image, std::span<const std::uint8_t> measured) {
  std::copy(measured.begin(), measured.end(), addMeasured(image));
}

vtkSmartPointer<vtkImageData> measuredLabelmap(vtkImageData* image) {
  vtkDataArray* measured = image->GetPointData()->GetArray(kMeasured);
  if (!measured) throw Error(ErrorCode::NoData, "The standard deviation does not say what was measured.");
  auto labelmap = vtkSmartPointer<vtkImageData>::New();
  labelmap->CopyStructure(image);
  labelmap->GetPointData()->SetScalars(measured);
  return labelmap;
}

void restoreMeasured(vtkImageData* image, vtkImageData* labelmap) {
  vtkDataArray* labels = labelmap ? labelmap->GetPointData()->GetScalars() : nullptr;
  if (image->GetPointData()->GetArray(kMeasured) || !labels ||
      labels->GetNumberOfTuples() != image->GetNumberOfPoints())
    return;
  std::uint8_t* measured = addMeasured(image);
  for (vtkIdType n = 0; n < labels->GetNumberOfTuples(); ++n)
    measured[n] = labels->GetComponent(n, 0) != 0;
}

double usualDeviation(vtkImageData* image) {
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  const vtkIdType count = scalars ? scalars->GetNumberOfTuples() : 0;
  constexpr vtkIdType kMost = 200'000; // voxels looked at
  std::vector<float> values;
  for (vtkIdType n = 0; n < count; n += 1 + count / kMost)
    values.push_back(static_cast<float>(scalars->GetComponent(n, 0)));
  const double usual = quantile(values, 0.99);
  return usual > 0 ? usual : 1;
}

void sampleUncertainty(vtkImageData* image, vtkMatrix4x4* ijkToRAS, std::span<const Vec3> points,
                       const GridGeometry& plane, bool withGeometry, ThreadPool& pool, vtkImageData* out) {
  const std::string what = "The standard deviation";
  checkVoxels(image, what);
  const GridGeometry grid = gridOf(image, ijkToRAS, what);
  vtkDataArray* scalars = image->GetPointData()->GetScalars();
  std::vector<float> converted;
  if (scalars->GetDataType() != VTK_FLOAT) converted = voxelsOf(image, {{0, 0, 0}, grid.size}, what);
  const float* deviation =
      converted.empty() ? static_cast<const float*>(scalars->GetVoidPointer(0)) : converted.data();
  auto* known = vtkUnsignedCharArray::SafeDownCast(image->GetPointData()->GetArray(kMeasured));
  const bool whole = known && known->GetNumberOfValues() == image->GetNumberOfPoints();
  const std::uint8_t* measured = whole ? known->GetPointer(0) : nullptr;
  const auto unknown = static_cast<float>(scalars->GetRange(0)[1]);
  float* values = allocateFloats(out, plane, withGeometry);
  out->GetPointData()->GetScalars()->SetName(kDeviation);
  std::uint8_t* marks = addMeasured(out);
  const Affine3 toIndex = inverse(grid.indexToWorld());
  pool.blocks(static_cast<std::int64_t>(points.size()), 1 << 12, [&](std::int64_t from, std::int64_t to) {
    for (std::int64_t n = from; n < to; ++n) {
      const Vec3 index = toIndex(points[n]);
      values[n] = unknown;
      marks[n] = 0;
      if (!sampleInside(grid, deviation, index, values[n])) continue;
      std::int64_t voxel = 0;
      for (int a = 2; a >= 0; --a)
        voxel = voxel * grid.size[a] + std::clamp<std::int64_t>(std::llround(index[a]), 0, grid.size[a] - 1);
      marks[n] = measured ? measured[voxel] : 1;
    }
  });
}

} // namespace innergs::vtk
