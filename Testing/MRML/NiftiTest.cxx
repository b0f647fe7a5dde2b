#include "MrmlFixture.h"

#include <vtkMRMLVolumeArchetypeStorageNode.h>

#include <fstream>
#include <string>

namespace {

class NiftiTest : public MrmlFixture {
protected:
  /// The volume, written to the temporary folder and read back as a new node; null if that fails.
  vtkMRMLScalarVolumeNode* throughFile(vtkMRMLScalarVolumeNode* volume, const std::string& file) {
    const std::string path = (folder / file).string();
    vtkNew<vtkMRMLVolumeArchetypeStorageNode> out, in;
    out->SetFileName(path.c_str());
    if (!out->WriteData(volume) || !std::filesystem::exists(path)) return nullptr;
    in->SetFileName(path.c_str());
    auto* read = addNode<vtkMRMLScalarVolumeNode>(volume->GetName());
    return in->ReadData(read) ? read : nullptr;
  }
  /// pixdim[0] of an uncompressed file: -1 for left-handed axes.
  double handedness(const std::string& file) {
    std::ifstream stream(folder / file, std::ios::binary);
    float value = 0;
    stream.seekg(76).read(reinterpret_cast<char*>(&value), sizeof value);
    return static_cast<double>(value);
  }
};

// The same head stored along other axes, some left-handed: the same values at the same positions.
TEST_F(NiftiTest, OneHeadInSevenOrientations) {
  const std::string letters = "RASLPI";
  const int voxels[3] = {24, 22, 20};
  int leftHanded = 0;
  for (const std::string code : {"RAS", "LPS", "AIL", "PSR", "SLA", "IRP", "LAS"}) {
    SCOPED_TRACE(code);
    int size[3];
    vtkNew<vtkMatrix4x4> matrix;
    matrix->Zero();
    matrix->SetElement(3, 3, 1);
    for (int index = 0; index < 3; ++index) {
      const std::size_t letter = letters.find(code[index]);
      const int axis = static_cast<int>(letter % 3);
      size[index] = voxels[axis];
      const double step = letter < 3 ? 2 : -2;
      matrix->SetElement(axis, index, step);
      matrix->SetElement(axis, 3, -step * (voxels[axis] - 1) / 2);
    }
    auto* input = throughFile(addVolume(code.c_str(), size, matrix), code + ".nii");
    ASSERT_NE(input, nullptr);
    const bool mirrored = matrix->Determinant() < 0;
    EXPECT_EQ(handedness(code + ".nii"), mirrored ? -1 : 1); // of the file: Slicer's reader may flip an axis
    leftHanded += mirrored;
    ASSERT_LT(error(input, 0), 1); // every voxel is in place
    ASSERT_TRUE(logic->Reconstruct(addParameters(input))) << logic->GetLastError();
    EXPECT_LT(error(logic->GetLastJob()->GetVolumeNode()), 6);
    for (double s = -12; s <= 12; s += 6)
      for (double a = -12; a <= 12; a += 6)
        for (double r = -12; r <= 12; r += 6)
          EXPECT_NEAR(logic->GetValueAtRAS(logic->GetLastJob()->GetModelNode(), r, a, s), truth(r, a, s), 25);
  }
  EXPECT_GE(leftHanded, 2);
}

TEST_F(NiftiTest, ObliqueThickSlices) {
  const int size[3] = {32, 30, 12};
  const double spacing[3] = {1.5, 1.5, 4}, origin[3] = {-22, -18, -26};
  auto* input = throughFile(addVolume("Oblique", size, oblique(20, spacing, origin)), "oblique.nii");
  ASSERT_NE(input, nullptr);
  auto* parameters = addParameters(input);
  parameters->SetOutputGrid(vtkMRMLInnerGSParameterNode::InputGrid);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_GT(logic->GetLastJob()->GetTrainingPSNR(), 30);
  auto* volume = logic->GetLastJob()->GetVolumeNode();
  EXPECT_LT(error(volume), 10);
  auto* again = throughFile(volume, "result.nii.gz"); // and what was made of it
  ASSERT_NE(again, nullptr);
  EXPECT_LT(error(again), 10);
}

TEST_F(NiftiTest, AbdomenFromDisk) {
  const std::string path = INNERGS_TEST_DATA "/B_abdomen_spgr_FA15.nii.gz";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "Needs " << path;
  vtkNew<vtkMRMLVolumeArchetypeStorageNode> storage;
  storage->SetFileName(path.c_str());
  auto* input = addNode<vtkMRMLScalarVolumeNode>("Abdomen");
  ASSERT_TRUE(storage->ReadData(input));
  auto* parameters = addParameters(input);
  parameters->SetOutputGrid(vtkMRMLInnerGSParameterNode::InputGrid);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  EXPECT_GT(logic->GetLastJob()->GetTrainingPSNR(), 30);
  auto* volume = logic->GetLastJob()->GetVolumeNode();
  double sum = 0, scale = 0;
  int size[3];
  volume->GetImageData()->GetDimensions(size);
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const double x = input->GetImageData()->GetScalarComponentAsDouble(i, j, k, 0);
        const double e = volume->GetImageData()->GetScalarComponentAsDouble(i, j, k, 0) - x;
        sum += e * e;
        scale += x * x;
      }
  EXPECT_LT(std::sqrt(sum / scale), 0.15); // the same voxels at the same positions
}

} // namespace
