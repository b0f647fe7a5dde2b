#include "MrmlFixture.h"
#include "vtkMRMLInnerGSModelStorageNode.h"

#include <vtkCacheManager.h>
#include <vtkDataIOManager.h>
#include <vtkMRMLMessageCollection.h>
#include <vtkMRMLSubjectHierarchyNode.h>

#include <fstream>
#include <limits>

namespace {

using SceneFileTest = MrmlFixture;
using Logic = vtkSlicerInnerGSLogic;

TEST_F(SceneFileTest, SavedToAFolderAndReopened) {
  auto* parameters = addParameters(addThickVolume()); // a model with a residual grid
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* model = logic->GetLastJob()->GetModelNode();
  const double value = logic->GetValueAtRAS(model, 4, -5, 6);
  const double psnr = logic->GetLastJob()->GetTrainingPSNR();
  EXPECT_GT(psnr, 10);
  EXPECT_TRUE(model->GetModifiedSinceRead());
  // What the application's Save dialog does: every storable node gets a file, then the scene its own.
  scene->SetRootDirectory(folder.string().c_str());
  for (int n = 0; n < scene->GetNumberOfNodes(); ++n) {
    auto* node = vtkMRMLStorableNode::SafeDownCast(scene->GetNthNode(n));
    if (!node || !node->GetSaveWithScene()) continue;
    ASSERT_TRUE(node->AddDefaultStorageNode()) << node->GetName();
    auto* storage = node->GetStorageNode();
    if (!storage) continue;
    std::string file = node->GetName();
    std::replace(file.begin(), file.end(), ' ', '-');
    storage->SetFileName((folder / (file + "." + storage->GetDefaultWriteFileExtension())).string().c_str());
    ASSERT_TRUE(storage->WriteData(node)) << node->GetName();
  }
  EXPECT_FALSE(model->GetModifiedSinceRead());
  // A relative name means the working folder, wherever the scene lies.
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::create_directories(folder / "working");
  std::filesystem::current_path(folder / "working");
  scene->SetRootDirectory(folder.string().c_str());
  EXPECT_TRUE(logic->SaveModel(model, "relative.innergs")) << logic->GetLastError();
  std::filesystem::current_path(before);
  EXPECT_TRUE(std::filesystem::exists(folder / "working" / "relative.innergs"));
  EXPECT_TRUE(std::filesystem::exists(folder / "Thick-InnerGS-model.innergs"));
  scene->SetURL((folder / "scene.mrml").string().c_str());
  ASSERT_TRUE(scene->Commit());

  vtkNew<vtkMRMLScene> reopened;
  vtkNew<vtkSlicerInnerGSLogic> other;
  other->SetMRMLScene(reopened);
  reopened->SetURL((folder / "scene.mrml").string().c_str());
  ASSERT_TRUE(reopened->Connect());
  auto* restored =
      vtkMRMLInnerGSModelNode::SafeDownCast(reopened->GetFirstNodeByClass("vtkMRMLInnerGSModelNode"));
  ASSERT_NE(restored, nullptr);
  EXPECT_FALSE(restored->IsEmpty());
  EXPECT_EQ(other->GetValueAtRAS(restored, 4, -5, 6), value);
  EXPECT_FALSE(restored->GetModifiedSinceRead());
  auto* storage = vtkMRMLInnerGSModelStorageNode::SafeDownCast(restored->GetStorageNode());
  ASSERT_NE(storage, nullptr);
  storage->InvalidateFile(); // as for a file that was unpacked from a bundle
  EXPECT_TRUE(storage->Holds(restored));
  EXPECT_STREQ(restored->GetAttribute("InnerGS.Inputs"), "Thick");
  auto* again =
      vtkMRMLInnerGSParameterNode::SafeDownCast(reopened->GetFirstNodeByClass("vtkMRMLInnerGSParameterNode"));
  ASSERT_NE(again, nullptr);
  EXPECT_EQ(again->GetResultModelNode(), restored);
  ASSERT_NE(again->GetResultVolumeNode(), nullptr);
  EXPECT_STREQ(again->GetResultVolumeNode()->GetNodeReferenceID("InnerGSModel"), restored->GetID());
  ASSERT_TRUE(other->Reconstruct(again)) << other->GetLastError(); // and it works on
}

/// A scene of its own, opened from a bundle.
struct BundleReader {
  BundleReader(const std::string& bundle, const std::filesystem::path& folder) {
    cache->SetRemoteCacheDirectory((folder / "cache").string().c_str());
    io->SetCacheManager(cache);
    scene->SetDataIOManager(io);
    scene->SetCacheManager(cache);
    logic->SetMRMLScene(scene);
    read = scene->ReadFromMRB(bundle.c_str(), true);
  }
  ~BundleReader() {
    scene->SetDataIOManager(nullptr);
    scene->SetCacheManager(nullptr);
  }
  vtkNew<vtkCacheManager> cache;
  vtkNew<vtkDataIOManager> io;
  vtkNew<vtkMRMLScene> scene;
  vtkNew<Logic> logic;
  bool read = false;
};

// As one file with everything in it, which is unpacked to a folder that goes.
TEST_F(SceneFileTest, BundledAndReopened) {
  ASSERT_TRUE(logic->Reconstruct(addParameters(addThickVolume()))) << logic->GetLastError();
  auto* model = logic->GetLastJob()->GetModelNode();
  const std::string bundle = (folder / "everything.mrb").string();
  const auto valueIn = [](vtkMRMLScene* opened, Logic* with) {
    auto* restored =
        vtkMRMLInnerGSModelNode::SafeDownCast(opened->GetFirstNodeByClass("vtkMRMLInnerGSModelNode"));
    return restored && !restored->IsEmpty() ? with->GetValueAtRAS(restored, 4, -5, 6)
                                            : std::numeric_limits<double>::quiet_NaN();
  };
  for (const bool savedBefore : {false, true}) { // where the node has a file of its own elsewhere
    SCOPED_TRACE(savedBefore);
    const std::string own = (folder / "own.innergs").string();
    if (savedBefore) {
      ASSERT_TRUE(logic->SaveModel(model, own)) << logic->GetLastError();
    }
    ASSERT_TRUE(scene->WriteToMRB(bundle.c_str()));
    if (savedBefore) {
      EXPECT_EQ(std::string(model->GetStorageNode()->GetFileName()), own); // stays its file
      std::filesystem::remove(own);
    }
    const BundleReader unpacked(bundle, folder);
    vtkMRMLScene* reopened = unpacked.scene;
    Logic* other = unpacked.logic;
    ASSERT_TRUE(unpacked.read);
    EXPECT_EQ(valueIn(reopened, other), logic->GetValueAtRAS(model, 4, -5, 6));
    auto* restored =
        vtkMRMLInnerGSModelNode::SafeDownCast(reopened->GetFirstNodeByClass("vtkMRMLInnerGSModelNode"));
    ASSERT_NE(restored, nullptr);
    // Its unpacked file is gone: bundled again, the model is written from memory.
    const std::string again = (folder / "again.mrb").string();
    ASSERT_TRUE(reopened->WriteToMRB(again.c_str()));
    const BundleReader third(again, folder);
    ASSERT_TRUE(third.read);
    EXPECT_EQ(valueIn(third.scene, third.logic), logic->GetValueAtRAS(model, 4, -5, 6));
  }
}

TEST_F(SceneFileTest, ModelFiles) {
  auto* parameters = addParameters(addVolume());
  parameters->SetSetting("consistency", "false"); // PLY files leave the residual grid out
  ASSERT_TRUE(logic->Reconstruct(parameters));
  auto* model = logic->GetLastJob()->GetModelNode();
  const std::string name = (folder / "Kopf öäü.innergs").string();
  EXPECT_FALSE(logic->SaveModel(model, ""));
  EXPECT_NE(logic->GetLastError().find("no file name"), std::string::npos) << logic->GetLastError();
  EXPECT_FALSE(logic->SaveModel(model, (folder / "no such folder" / "x.innergs").string()));
  EXPECT_EQ(model->GetStorageNode(), nullptr);
  ASSERT_TRUE(logic->SaveModel(model, name)) << logic->GetLastError();
  ASSERT_NE(model->GetStorageNode(), nullptr); // it is saved now, and Slicer knows where
  EXPECT_EQ(model->GetStorageNode()->GetFileName(), name);
  EXPECT_FALSE(model->GetModifiedSinceRead());
  auto* loaded = logic->LoadModel(name);
  ASSERT_NE(loaded, nullptr) << logic->GetLastError();
  EXPECT_STREQ(loaded->GetName(), "Kopf öäü");
  EXPECT_EQ(logic->GetValueAtRAS(loaded, 1, 2, 3), logic->GetValueAtRAS(model, 1, 2, 3));
  EXPECT_NE(loaded->GetStorageNode(), nullptr);
  for (const char* attribute : {"InnerGS.Settings", "InnerGS.Inputs", "InnerGS.Version", "InnerGS.Device",
                                "InnerGS.InstructionSet", "InnerGS.TrainingPSNR"}) {
    ASSERT_NE(loaded->GetAttribute(attribute), nullptr) << attribute;
    EXPECT_STREQ(loaded->GetAttribute(attribute), model->GetAttribute(attribute));
  }
  auto* resampled = logic->Resample(loaded, 4); // and on to what is made of it
  ASSERT_NE(resampled, nullptr);
  EXPECT_STREQ(resampled->GetAttribute("InnerGS.Settings"), model->GetAttribute("InnerGS.Settings"));

  const std::string ply = (folder / "gaussians.ply").string();
  ASSERT_TRUE(logic->SaveModel(model, ply)) << logic->GetLastError();
  auto* fromPly = logic->LoadModel(ply);
  ASSERT_NE(fromPly, nullptr) << logic->GetLastError();
  EXPECT_EQ(model->GetStorageNode()->GetFileName(), name); // an export
  EXPECT_NEAR(logic->GetValueAtRAS(fromPly, 1, 2, 3), logic->GetValueAtRAS(model, 1, 2, 3), 1e-2);

  std::ofstream(folder / "broken.innergs") << "not a model";
  errors.clear();
  EXPECT_EQ(logic->LoadModel((folder / "broken.innergs").string()), nullptr);
  ASSERT_EQ(errors.size(), 1u);
  EXPECT_NE(logic->GetLastError().find("broken.innergs"), std::string::npos) << logic->GetLastError();
  EXPECT_FALSE(logic->SaveModel(model, (folder / "no such folder" / "x.innergs").string()));
  EXPECT_EQ(model->GetStorageNode()->GetFileName(), name);
  EXPECT_FALSE(logic->SaveModel(model, (folder / "x.txt").string()));
}

// By the application's Save dialog, whose storage node is the model's own.
TEST_F(SceneFileTest, PlyDoesNotCountAsSaved) {
  auto* parameters = addParameters(addThickVolume()); // a model with a residual grid
  parameters->SetNumberOfIterations(5);
  ASSERT_TRUE(logic->Reconstruct(parameters)) << logic->GetLastError();
  auto* model = logic->GetLastJob()->GetModelNode();
  ASSERT_TRUE(model->AddDefaultStorageNode());
  vtkMRMLStorageNode* storage = model->GetStorageNode();
  storage->SetFileName((folder / "head.ply").string().c_str());
  ASSERT_TRUE(storage->WriteData(model));
  EXPECT_TRUE(std::filesystem::exists(folder / "head.ply"));
  EXPECT_TRUE(model->GetModifiedSinceRead());
  EXPECT_EQ(storage->GetUserMessages()->GetNumberOfMessagesOfType(vtkCommand::WarningEvent), 1);
  storage->GetUserMessages()->ClearMessages();
  storage->SetFileName((folder / "head.innergs").string().c_str());
  ASSERT_TRUE(storage->WriteData(model));
  EXPECT_FALSE(model->GetModifiedSinceRead());
  EXPECT_EQ(storage->GetUserMessages()->GetNumberOfMessages(), 0);
  // An export beside the model's file leaves it saved.
  ASSERT_TRUE(logic->SaveModel(model, (folder / "export.ply").string())) << logic->GetLastError();
  EXPECT_FALSE(model->GetModifiedSinceRead());
  // Nothing is lost of what was a PLY file.
  auto* loaded = logic->LoadModel((folder / "head.ply").string());
  ASSERT_NE(loaded, nullptr) << logic->GetLastError();
  ASSERT_TRUE(loaded->GetStorageNode()->WriteData(loaded));
  EXPECT_FALSE(loaded->GetModifiedSinceRead());
}

TEST_F(SceneFileTest, StorageNodeTypes) {
  vtkNew<vtkMRMLInnerGSModelStorageNode> storage;
  EXPECT_TRUE(storage->SupportedFileType("a.innergs"));
  EXPECT_TRUE(storage->SupportedFileType("a.ply"));
  EXPECT_FALSE(storage->SupportedFileType("a.nrrd"));
  vtkNew<vtkMRMLInnerGSModelNode> node;
  EXPECT_TRUE(storage->CanReadInReferenceNode(node));
  EXPECT_FALSE(storage->CanReadInReferenceNode(vtkNew<vtkMRMLScalarVolumeNode>()));
}

} // namespace
