// Slice thickness from the DICOM files that a volume was read from, or from the BIDS file beside it.
#include "MrmlFixture.h"

#include <vtkMRMLVolumeArchetypeStorageNode.h>

#include <fstream>

namespace {

class SliceThicknessTest : public MrmlFixture {
protected:
  /// As left by Slicer's DICOM module: one file per slice.
  static void setInstances(vtkMRMLVolumeNode* volume, int count) {
    std::string uids;
    for (int n = 0; n < count; ++n)
      uids += (n ? " 1.2.826.0.1." : "1.2.826.0.1.") + std::to_string(n);
    volume->SetAttribute("DICOM.instanceUIDs", uids.c_str());
  }
  /// The input of a fit, including the thickness.
  std::string key(vtkMRMLInnerGSParameterNode* parameters) {
    std::string key;
    EXPECT_TRUE(logic->EstimateLater(parameters, &key)) << logic->CheckParameters(parameters);
    return key;
  }
};

TEST_F(SliceThicknessTest, OfDicomFilesIsTheDefault) {
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

TEST_F(SliceThicknessTest, WhatIsNoThicknessIsNotBelieved) {
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

TEST_F(SliceThicknessTest, OfTheBidsFileBesideANifti) {
  const auto file = [&](const char* name) { return (folder / name).string(); };
  const auto sidecar = [&](const std::string& text) { std::ofstream(file("scan.json")) << text; };
  auto* scan = addThickVolume();
  auto* storage = vtkMRMLVolumeArchetypeStorageNode::SafeDownCast(
      scene->AddNewNodeByClass("vtkMRMLVolumeArchetypeStorageNode"));
  scan->SetAndObserveStorageNodeID(storage->GetID());
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
