#pragma once
#include "vtkInnerGSModel.h"
#include "vtkMRMLInnerGSModelNode.h"
#include "vtkMRMLInnerGSParameterNode.h"
#include "vtkSlicerInnerGSJob.h"
#include "vtkSlicerInnerGSLogic.h"

#include <vtkMRMLLinearTransformNode.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>

#include <vtkCallbackCommand.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkSmartPointer.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <thread>

/// Calls a function for events of an object while it lives.
class Observer {
public:
  using Call = std::function<void(unsigned long, void*)>;
  Observer(vtkObject* object, std::initializer_list<unsigned long> events, Call call);
  ~Observer();
  Observer(const Observer&) = delete;
  Observer& operator=(const Observer&) = delete;

private:
  vtkSmartPointer<vtkObject> object_;
  Call call_;
  vtkNew<vtkCallbackCommand> command_;
};

/// Polls until the condition holds; a test's time limit ends the wait for something that never happens.
inline void waitUntil(const std::function<bool()>& holds) {
  while (!holds())
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

/// A scene with the logic and, on request, a smooth synthetic head.
class MrmlFixture : public testing::Test {
protected:
  MrmlFixture();
  ~MrmlFixture() override;

  template <class Node>
  Node* addNode(const std::string& name = {}) {
    return Node::SafeDownCast(scene->AddNewNodeByClass(vtkNew<Node>()->GetClassName(), name));
  }
  /// A smooth function of the world position, so that values verify the geometry.
  static double truth(double r, double a, double s);

  /// size voxels sampled from truth() at the matrix's positions; short integers, like a scanner's.
  vtkMRMLScalarVolumeNode* addVolume(const char* name, const int size[3], vtkMatrix4x4* ijkToRAS,
                                     vtkMatrix4x4* nodeToWorld = nullptr);
  /// 24×22×20 voxels of 2 mm around the origin.
  vtkMRMLScalarVolumeNode* addVolume(const char* name = "Head");
  /// Along the axes, around the origin; spacing in mm.
  vtkMRMLScalarVolumeNode* addCentredVolume(const char* name, const int size[3], const double spacing[3]);
  /// Wide axial slices: 32×30×10 voxels of 1.5×1.5×5 mm.
  vtkMRMLScalarVolumeNode* addThickVolume(const char* name = "Thick");
  /// 36×34×30 oblique voxels of 1.5×1.5×2 mm: as many as an uncertainty needs.
  vtkMRMLScalarVolumeNode* addLargerVolume(const char* name = "Larger");
  vtkMRMLInnerGSParameterNode* addParameters(vtkMRMLVolumeNode* input);
  vtkMRMLLinearTransformNode* addTransform(vtkMatrix4x4* matrix, const char* name = "Transform");

  /// A second one for the same scene and recovery folder.
  vtkSmartPointer<vtkSlicerInnerGSLogic> anotherLogic();

  /// Root mean square difference from truth() over a volume's voxels, through its parent transform, without
  /// `margin` voxels at each edge.
  double error(vtkMRMLScalarVolumeNode* volume, int margin = 2);
  int countNodes(const char* className);
  /// The messages of all ErrorEvents so far.
  std::vector<std::string> errors;

  vtkNew<vtkMRMLScene> scene;
  vtkSmartPointer<vtkSlicerInnerGSLogic> logic;
  std::filesystem::path folder; // empty, removed at the end

private:
  std::unique_ptr<Observer> onError_;
};

/// IJK to RAS.
vtkSmartPointer<vtkMatrix4x4> matrixOf(vtkMRMLVolumeNode* volume);

/// A right-handed rotation about (1, 2, 3) by an angle in degrees, then a shift; spacing in the columns.
vtkSmartPointer<vtkMatrix4x4> oblique(double degrees, const double spacing[3], const double origin[3]);
