#include "SliceTable.h"

#include "Geometry.h"

#include <vtkDoubleArray.h>
#include <vtkIntArray.h>
#include <vtkTable.h>

namespace innergs::vtk {
namespace {

template <class Array>
Array* addColumn(vtkTable* table, const std::string& name) {
  vtkNew<Array> column;
  column->SetName(name.c_str());
  table->AddColumn(column);
  return column;
}

} // namespace

vtkSmartPointer<vtkTable> makeSliceTable(std::span<const FoundSlice> found) {
  auto table = vtkSmartPointer<vtkTable>::New();
  auto* scans = addColumn<vtkIntArray>(table, "Scan");
  auto* slices = addColumn<vtkIntArray>(table, "Slice");
  std::vector<vtkDoubleArray*> figures;
  for (const char* name : {"Weight", "Gain", "Displacement (mm)", "Angle (degrees)", "Residual"})
    figures.push_back(addColumn<vtkDoubleArray>(table, name));
  std::vector<vtkDoubleArray*> matrix;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 4; ++column)
      matrix.push_back(addColumn<vtkDoubleArray>(table, "M" + std::to_string(row) + std::to_string(column)));
  for (const auto& [scan, slice, pose, lps] : found) {
    scans->InsertNextValue(static_cast<int>(scan) + 1);
    slices->InsertNextValue(static_cast<int>(slice));
    const double values[] = {pose.weight, pose.gain, pose.displacement, pose.angle, pose.residual};
    for (std::size_t n = 0; n < figures.size(); ++n)
      figures[n]->InsertNextValue(values[n]);
    const Affine3 ras{flipped(lps).linear * diagonal({-1, -1, 1}), flipped(lps.offset)};
    auto entry = matrix.begin();
    for (int row = 0; row < 3; ++row)
      for (int column = 0; column < 4; ++column)
        (*entry++)->InsertNextValue(column < 3 ? ras.linear[row][column] : ras.offset[row]);
  }
  return table;
}

} // namespace innergs::vtk
