// Slice thickness and times from the DICOM files that a volume was read from, or from the BIDS file beside
// it.
#include "MrmlFixture.h"

#include <vtkMRMLVolumeArchetypeStorageNode.h>

#include <fstream>
#include <map>

namespace {

class SliceHeadersTest : public MrmlFixture {
protected:
  /// As left by Slicer's DICOM module: one file per slice.
  static void setInstances(vtkMRMLVolumeNode* volume, int count) {
    std::string uids;
    for (int n = 0; n < count; ++n)
      uids += (n ? " 1.2.826.0.1." : "1.2.826.0.1.") + std::to_string(n);
    volume->SetAttribute("DICOM.instanceUIDs", uids.c_str());
  }
  vtkMRMLStorageNode* addStorage(vtkMRMLVolumeNode* volume) {
    auto* storage =
        vtkMRMLStorageNode::SafeDownCast(scene->AddNewNodeByClass("vtkMRMLVolumeArchetypeStorageNode"));
    volume->SetAndObserveStorageNodeID(storage->GetID());
    return storage;
  }
  /// The input of a fit, including the thickness.
  std::string key(vtkMRMLInnerGSParameterNode* parameters) {
    std::string key;
    EXPECT_TRUE(logic->EstimateLater(parameters, &key)) << logic->CheckParameters(parameters);
    return key;
  }
};

TEST_F(SliceHeadersTest, ThicknessOfDicomFilesIsTheDefault) {
  auto* scan = addThickVolume(); // 10 slices, 5 mm apart
  auto* parameters = addParameters(scan);
  const std::string distance = key(parameters);
  std::string value = "3.5 ", asked;
  logic->SetDicomLookup([&](const std::string& uid, const std::string& tag) {
    asked = uid + " " + tag;
    return value;
  });
  EXPECT_EQ(logic->GetDicomSliceThickness(scan), 0); // no files
  EXPECT_EQ(key(parameters), distance);
  setInstances(scan, 10);
  EXPECT_EQ(logic->GetDicomSliceThickness(scan), 3.5);
  EXPECT_EQ(asked, "1.2.826.0.1.0 0018,0050");
  const std::string said = key(parameters);
  EXPECT_NE(said, distance);
  // The user's value takes precedence.
  parameters->SetInputSliceThickness(scan, 3.5);
  EXPECT_EQ(key(parameters), said);
  parameters->SetInputSliceThickness(scan, 5);
  EXPECT_NE(key(parameters), said);
  // Slices along another axis do not match the files'.
  parameters->SetInputSliceThickness(scan, 0);
  parameters->SetInputSliceAxis(scan, 0);
  const std::string along = key(parameters);
  logic->SetDicomLookup({});
  EXPECT_EQ(key(parameters), along);
}

TEST_F(SliceHeadersTest, WhatIsNoThicknessIsNotBelieved) {
  auto* scan = addThickVolume();
  setInstances(scan, 10);
  std::string value;
  logic->SetDicomLookup([&](const std::string&, const std::string&) { return value; });
  for (const char* wrong : {"", "thick", "0", "-4", "nan", "inf"}) {
    value = wrong;
    EXPECT_EQ(logic->GetDicomSliceThickness(scan), 0) << wrong;
  }
  value = "4.5";
  EXPECT_EQ(logic->GetDicomSliceThickness(scan), 4.5);
  setInstances(scan, 9); // a copy that was cropped
  EXPECT_EQ(logic->GetDicomSliceThickness(scan), 0);
  EXPECT_EQ(logic->GetDicomSliceThickness(nullptr), 0);
}

TEST_F(SliceHeadersTest, PassesByTheTimesOfDicomFiles) {
  auto* scan = addThickVolume(); // 10 slices
  std::map<std::string, std::string> said;
  int lookups = 0;
  logic->SetDicomLookup([&](const std::string& uid, const std::string& tag) {
    ++lookups;
    return said[tag + uid.substr(uid.rfind('.'))];
  });
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 0) << "no files";
  setInstances(scan, 10);
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 0) << "no times";
  EXPECT_EQ(lookups, 2) << "one file of each kind is enough to see that they do not say it";
  for (int k = 0; k < 10; ++k) // even slices, then odd ones
    said["0018,1060." + std::to_string(k)] = std::to_string(100 * (k / 2 + 5 * (k % 2)));
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 2) << "TriggerTime";
  for (int k = 0; k < 10; ++k)
    said["0008,0032." + std::to_string(k)] = std::to_string(101500 + k);
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 1) << "AcquisitionTime takes precedence";
  setInstances(scan, 9);
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 0) << "a copy that was cropped";
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(nullptr), 0);
}

TEST_F(SliceHeadersTest, PassesByTheBidsFileBesideANifti) {
  auto* scan = addThickVolume(); // 10 slices
  addStorage(scan)->SetFileName((folder / "scan.nii").string().c_str());
  const auto sidecar = [&](const std::string& text) { std::ofstream(folder / "scan.json") << text; };
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 0) << "no such file";
  sidecar(R"({"SliceTiming": [0, 5, 1, 6, 2, 7, 3, 8, 4, 9]})");
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 2);
  sidecar(R"({"SliceTiming": [0, 1, 2, 3, 4, 5, 6, 7, 8, 9]})");
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 1);
  sidecar(R"({"SliceTiming": [0, 5, 1, 6, 2, 7, 3, 8]})");
  EXPECT_EQ(logic->GetNumberOfInterleavedPasses(scan), 0) << "of another volume";
}

TEST_F(SliceHeadersTest, ThicknessOfTheBidsFileBesideANifti) {
  const auto file = [&](const char* name) { return (folder / name).string(); };
  const auto sidecar = [&](const std::string& text) { std::ofstream(file("scan.json")) << text; };
  auto* scan = addThickVolume();
  auto* storage = addStorage(scan);
  storage->SetFileName(file("scan.nii.gz").c_str());
  sidecar(R"({"SliceThickness": 3.5})");
  EXPECT_EQ(logic->GetDicomSliceThickness(scan), 3.5);
  storage->SetFileName(file("scan.nrrd").c_str());
  EXPECT_EQ(logic->GetDicomSliceThickness(scan), 0) << "no NIfTI";
  storage->SetFileName(file("scan.nii").c_str());
  EXPECT_EQ(logic->GetDicomSliceThickness(scan), 3.5);
  setInstances(scan, 10);
  logic->SetDicomLookup([](const std::string&, const std::string&) { return "4.5"; });
  EXPECT_EQ(logic->GetDicomSliceThickness(scan), 4.5) << "DICOM takes precedence";
  logic->SetDicomLookup({});
  for (const char* other : {"{}", "no JSON", R"({"SliceThickness": "3.5"})",
                            R"({"SliceThickness": 3.5, "SliceEncodingDirection": "i"})"}) {
    sidecar(other);
    EXPECT_EQ(logic->GetDicomSliceThickness(scan), 0) << other;
  }
}

} // namespace
