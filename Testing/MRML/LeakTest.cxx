#include "MrmlFixture.h"

#include <vtkMRMLSliceNode.h>

#include <vtkDebugLeaks.h>
#include <vtkWeakPointer.h>

namespace {

struct Session : MrmlFixture {
  void TestBody() override {}
  void run(std::vector<vtkWeakPointer<vtkObject>>& seen) {
    auto* parameters = addParameters(addVolume());
    parameters->SetNumberOfIterations(3);
    ASSERT_TRUE(logic->Reconstruct(parameters));
    vtkSlicerInnerGSJob* finished = logic->GetLastJob();
    auto* slice = addNode<vtkMRMLSliceNode>();
    slice->SetLayoutName("Red");
    auto* followed = logic->FollowSlice(finished->GetModelNode(), slice);
    ASSERT_NE(followed, nullptr);
    for (vtkObject* object :
         {static_cast<vtkObject*>(logic), static_cast<vtkObject*>(scene), static_cast<vtkObject*>(finished),
          static_cast<vtkObject*>(parameters), static_cast<vtkObject*>(finished->GetModelNode()),
          static_cast<vtkObject*>(finished->GetModelNode()->GetModel()),
          static_cast<vtkObject*>(finished->GetVolumeNode()),
          static_cast<vtkObject*>(finished->GetVolumeNode()->GetImageData()),
          static_cast<vtkObject*>(parameters->GetInputVolumeNode()->GetImageData()),
          static_cast<vtkObject*>(followed), static_cast<vtkObject*>(followed->GetImageData()),
          static_cast<vtkObject*>(slice)})
      seen.emplace_back(object);
    parameters->SetInstructionSet("none such");
    ASSERT_FALSE(logic->Reconstruct(parameters));
    seen.emplace_back(logic->GetLastJob());
    parameters->SetInstructionSet("");
    parameters->SetNumberOfIterations(100000);
    seen.emplace_back(logic->StartReconstruction(parameters)); // running when everything is deleted
    seen.emplace_back(logic->StartReconstruction(parameters));
  }
};

std::vector<vtkWeakPointer<vtkObject>> runSession() {
  std::vector<vtkWeakPointer<vtkObject>> objects;
  Session session;
  session.run(objects);
  return objects;
}

// Weak pointers to one of everything.
TEST(Leaks, NothingOutlivesSceneAndLogic) {
  const auto objects = runSession();
  EXPECT_GE(objects.size(), 15u);
  for (std::size_t n = 0; n < objects.size(); ++n)
    EXPECT_EQ(objects[n].Get(), nullptr) << "object " << n << ": " << objects[n]->GetClassName();
}

// VTK's own count of every object, if it counts: zero before, more while an object lives.
TEST(Leaks, VTKCountsNone) {
  const int before = vtkDebugLeaks::PrintCurrentLeaks();
  int living = 0;
  {
    vtkNew<vtkObject> object;
    living = vtkDebugLeaks::PrintCurrentLeaks();
  }
  if (before != 0 || living == 0)
    GTEST_SKIP() << "VTK counts no objects (" << before << " before, " << living
                 << " with one): it was built without VTK_DEBUG_LEAKS, as the wheels are.";
  runSession();
  EXPECT_EQ(vtkDebugLeaks::PrintCurrentLeaks(), 0);
}

} // namespace
