#pragma once
#include "../Core/JobInputs.h"
#include "../Core/RandomFields.h"

#include "vtkInnerGSModel.h"
#include "vtkInnerGSReconstruct.h"

#include <vtkCallbackCommand.h>
#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

#include <string>
#include <vector>

/// VTK objects made from the engine's, with a separate implementation of the LPS–RAS conversion.
namespace innergs::testing {

/// IJK → RAS of a grid: the first two rows of IJK → LPS negated.
inline vtkSmartPointer<vtkMatrix4x4> rasMatrix(const Affine3& lps) {
  auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
  for (int r = 0; r < 3; ++r) {
    const double sign = r < 2 ? -1 : 1;
    for (int c = 0; c < 3; ++c)
      matrix->SetElement(r, c, sign * lps.linear[r][c]);
    matrix->SetElement(r, 3, sign * lps.offset[r]);
  }
  return matrix;
}
inline vtkSmartPointer<vtkMatrix4x4> rasMatrix(const GridGeometry& grid) {
  return rasMatrix(grid.indexToWorld());
}

/// Voxels without geometry (origin 0, spacing 1), of any scalar type.
inline vtkSmartPointer<vtkImageData> plainImage(const Volume& volume, int type = VTK_FLOAT) {
  auto image = vtkSmartPointer<vtkImageData>::New();
  const auto& n = volume.geometry.size;
  image->SetDimensions(static_cast<int>(n[0]), static_cast<int>(n[1]), static_cast<int>(n[2]));
  image->AllocateScalars(type, 1);
  std::size_t at = 0;
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        image->SetScalarComponentFromDouble(i, j, k, 0, volume.voxels[at++]);
  return image;
}

inline void addInput(vtkInnerGSReconstruct* filter, int index, const Stack& stack, int type = VTK_FLOAT) {
  filter->AddInputData(plainImage(stack.image, type));
  filter->SetInputIJKToRASMatrix(index, rasMatrix(stack.image.geometry));
  filter->SetInputSliceThickness(index, stack.thickness);
  filter->SetInputSliceProfile(index, static_cast<int>(stack.profile));
}

/// A filter set up for the same job as (input, quickSettings(iterations)).
inline vtkSmartPointer<vtkInnerGSReconstruct> quickFilter(const ReconstructionInput& input,
                                                          int iterations = 10) {
  auto filter = vtkSmartPointer<vtkInnerGSReconstruct>::New();
  for (std::size_t i = 0; i < input.stacks.size(); ++i)
    addInput(filter, static_cast<int>(i), input.stacks[i]);
  filter->SetPreset(vtkInnerGSReconstruct::Fast);
  filter->SetNumberOfIterations(iterations);
  filter->SetNumberOfGaussians(300);
  filter->SetNumberOfThreads(2);
  return filter;
}

inline std::vector<float> valuesOf(vtkImageData* image) {
  if (!image || image->GetNumberOfPoints() == 0) return {};
  const auto* p = static_cast<const float*>(image->GetScalarPointer());
  return {p, p + image->GetNumberOfPoints()};
}

inline ::testing::AssertionResult closeTo(vtkMatrix4x4* a, vtkMatrix4x4* b, double tolerance = 1e-9) {
  for (int i = 0; i < 16; ++i)
    if (!(std::abs(a->GetElement(i / 4, i % 4) - b->GetElement(i / 4, i % 4)) <= tolerance))
      return ::testing::AssertionFailure()
             << "element " << i / 4 << "," << i % 4 << ": " << a->GetElement(i / 4, i % 4) << " against "
             << b->GetElement(i / 4, i % 4);
  return ::testing::AssertionSuccess();
}

/// A field as a VTK model.
inline vtkSmartPointer<vtkInnerGSModel> modelOf(GaussianField field) {
  auto core = std::make_shared<Model>();
  core->field = std::move(field);
  auto model = vtkSmartPointer<vtkInnerGSModel>::New();
  model->SetCoreModel(core);
  return model;
}

inline GaussianField randomSmallField() {
  return randomField(200, {}, 5);
}

/// Collects an object's error events and keeps them off the console.
class Errors {
public:
  explicit Errors(vtkObject* object) : object_(object) {
    command_->SetClientData(this);
    command_->SetCallback([](vtkObject*, unsigned long, void* self, void* text) {
      static_cast<Errors*>(self)->texts.emplace_back(static_cast<const char*>(text));
    });
    tag_ = object->AddObserver("ErrorEvent", command_);
  }
  ~Errors() { object_->RemoveObserver(tag_); }
  Errors(const Errors&) = delete;
  std::vector<std::string> texts;

private:
  vtkObject* object_;
  vtkNew<vtkCallbackCommand> command_;
  unsigned long tag_;
};

/// Calls `each(call data)` at every such event while it lives.
class Observer {
public:
  Observer(vtkObject* object, unsigned long event, std::function<void(void*)> each)
      : object_(object), each_(std::move(each)) {
    command_->SetClientData(this);
    command_->SetCallback([](vtkObject*, unsigned long, void* self, void* data) {
      auto* observer = static_cast<Observer*>(self);
      ++observer->count;
      observer->each_(data);
    });
    tag_ = object->AddObserver(event, command_);
  }
  ~Observer() { object_->RemoveObserver(tag_); }
  Observer(const Observer&) = delete;
  int count = 0;

private:
  vtkObject* object_;
  std::function<void(void*)> each_;
  vtkNew<vtkCallbackCommand> command_;
  unsigned long tag_;
};

} // namespace innergs::testing
