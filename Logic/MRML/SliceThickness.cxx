#include "SliceThickness.h"

#include "Core/Image/GridGeometry.h"
#include "IO/BidsSidecar.h"
#include "IO/FilePath.h"

#include <vtkMRMLStorageNode.h>
#include <vtkMRMLVolumeNode.h>

#include <vtkImageData.h>

#include <cmath>
#include <iterator>
#include <locale>
#include <sstream>
#include <vector>

namespace innergs::mrml {

double dicomSliceThickness(vtkMRMLVolumeNode* volume, const vtkSlicerInnerGSLogic::DicomLookup& lookup) {
  const char* attribute = volume ? volume->GetAttribute("DICOM.instanceUIDs") : nullptr;
  if (!lookup || !attribute || !volume->GetImageData()) return 0;
  std::istringstream words(attribute);
  const std::vector<std::string> instances{std::istream_iterator<std::string>(words), {}};
  // A copy with other slices has the same attribute.
  if (std::ssize(instances) != volume->GetImageData()->GetDimensions()[2]) return 0;
  std::istringstream value(lookup(instances.front(), "0018,0050"));
  value.imbue(std::locale::classic());
  double thickness = 0;
  return value >> thickness && std::isfinite(thickness) && thickness > 0 ? thickness : 0;
}

double bidsSliceThickness(vtkMRMLVolumeNode* volume) {
  vtkMRMLStorageNode* storage = volume && volume->GetImageData() ? volume->GetStorageNode() : nullptr;
  const std::string name = storage ? storage->GetFullNameFromFileName() : std::string();
  if (name.empty()) return 0;
  const std::filesystem::path file = pathOf(name);
  if (const std::string ending = fullExtension(file); ending != ".nii" && ending != ".nii.gz") return 0;
  const int* size = volume->GetImageData()->GetDimensions();
  const BidsSlices slices =
      readBidsSlices(sidecarOf(file), 2, {{size[0], size[1], size[2]}, {0, 0, 0}, {1, 1, 1}, {}});
  return slices.axis == 2 ? slices.thickness : 0;
}

} // namespace innergs::mrml
