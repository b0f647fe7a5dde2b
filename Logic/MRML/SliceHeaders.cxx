#include "SliceHeaders.h"

#include "Core/Image/GridGeometry.h"
#include "IO/BidsSidecar.h"
#include "IO/DicomTimes.h"
#include "IO/FilePath.h"

#include <vtkMRMLStorageNode.h>
#include <vtkMRMLVolumeNode.h>

#include <vtkImageData.h>

#include <cmath>
#include <iterator>
#include <locale>
#include <optional>
#include <sstream>
#include <utility>

namespace innergs::mrml {
namespace {

/// UIDs of the files, one per slice along K; empty if there are none.
std::vector<std::string> instancesOf(vtkMRMLVolumeNode* volume) {
  const char* attribute = volume ? volume->GetAttribute("DICOM.instanceUIDs") : nullptr;
  if (!attribute || !volume->GetImageData()) return {};
  std::istringstream words(attribute);
  std::vector<std::string> instances{std::istream_iterator<std::string>(words), {}};
  // A copy with other slices has the same attribute.
  if (std::ssize(instances) != volume->GetImageData()->GetDimensions()[2]) instances.clear();
  return instances;
}

std::optional<std::filesystem::path> niftiOf(vtkMRMLVolumeNode* volume) {
  vtkMRMLStorageNode* storage = volume && volume->GetImageData() ? volume->GetStorageNode() : nullptr;
  const std::string name = storage ? storage->GetFullNameFromFileName() : std::string();
  if (name.empty()) return std::nullopt;
  const std::filesystem::path file = pathOf(name);
  if (const std::string ending = fullExtension(file); ending != ".nii" && ending != ".nii.gz")
    return std::nullopt;
  return file;
}

BidsSlices bidsSlicesOf(vtkMRMLVolumeNode* volume, const std::filesystem::path& nifti) {
  const int* size = volume->GetImageData()->GetDimensions();
  return readBidsSlices(sidecarOf(nifti), 2, {{size[0], size[1], size[2]}, {0, 0, 0}, {1, 1, 1}, {}});
}

} // namespace

double dicomSliceThickness(vtkMRMLVolumeNode* volume, const vtkSlicerInnerGSLogic::DicomLookup& lookup) {
  const std::vector<std::string> instances = lookup ? instancesOf(volume) : std::vector<std::string>();
  if (instances.empty()) return 0;
  std::istringstream value(lookup(instances.front(), "0018,0050"));
  value.imbue(std::locale::classic());
  double thickness = 0;
  return value >> thickness && std::isfinite(thickness) && thickness > 0 ? thickness : 0;
}

double bidsSliceThickness(vtkMRMLVolumeNode* volume) {
  const auto file = niftiOf(volume);
  if (!file) return 0;
  const BidsSlices slices = bidsSlicesOf(volume, *file);
  return slices.axis == 2 ? slices.thickness : 0;
}

std::vector<double> dicomSliceTimes(vtkMRMLVolumeNode* volume,
                                    const vtkSlicerInnerGSLogic::DicomLookup& lookup) {
  if (!lookup) return {};
  const std::vector<std::string> instances = instancesOf(volume);
  const auto said = [&](const char* tag) {
    std::vector<std::string> values;
    for (const std::string& instance : instances) {
      values.push_back(lookup(instance, tag));
      if (values.back().empty()) return std::vector<std::string>(); // the others need not be opened
    }
    return values;
  };
  std::vector<double> times = innergs::dicomSliceTimes(said("0008,0032"), {});
  return times.empty() ? innergs::dicomSliceTimes({}, said("0018,1060")) : times;
}

std::vector<double> bidsSliceTimes(vtkMRMLVolumeNode* volume) {
  const auto file = niftiOf(volume);
  if (!file) return {};
  BidsSlices slices = bidsSlicesOf(volume, *file);
  // Their number differs where the volume was cropped since.
  if (slices.axis != 2 || std::ssize(slices.times) != volume->GetImageData()->GetDimensions()[2]) return {};
  return std::move(slices.times);
}

} // namespace innergs::mrml
