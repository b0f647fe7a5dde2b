#include "ReconstructInternals.h"

// What belongs to one input.

#define innergsInputMacro(name, member, Type)                                                                \
  void vtkInnerGSReconstruct::SetInput##name(int index, Type value) {                                        \
    auto* input = this->Work->inputs.at(index);                                                              \
    if (!input) {                                                                                            \
      vtkErrorMacro(<< "There is no input with the index " << index << ": give 0 or more.");                 \
      return;                                                                                                \
    }                                                                                                        \
    if (input->member == value) return;                                                                      \
    input->member = value;                                                                                   \
    this->Modified();                                                                                        \
  }
innergsInputMacro(SliceThickness, thickness, double);
innergsInputMacro(SliceProfile, profile, int);
innergsInputMacro(SliceAxis, axis, int);
innergsInputMacro(Name, name, const std::string&);
#undef innergsInputMacro

double vtkInnerGSReconstruct::GetInputSliceThickness(int index) {
  return this->Work->inputs.get(index).thickness;
}
int vtkInnerGSReconstruct::GetInputSliceProfile(int index) {
  return this->Work->inputs.get(index).profile;
}
int vtkInnerGSReconstruct::GetInputSliceAxis(int index) {
  return this->Work->inputs.get(index).axis;
}
std::string vtkInnerGSReconstruct::GetInputName(int index) {
  return this->Work->inputs.get(index).name;
}

void vtkInnerGSReconstruct::SetInputIJKToRASMatrix(int index, vtkMatrix4x4* ijkToRAS) {
  auto* input = this->Work->inputs.at(index);
  if (!input) {
    vtkErrorMacro(<< "There is no input with the index " << index << ": give 0 or more.");
    return;
  }
  if (innergs::vtk::assignCopy(input->ijkToRAS, ijkToRAS)) this->Modified();
}

vtkMatrix4x4* vtkInnerGSReconstruct::GetInputIJKToRASMatrix(int index) {
  auto* input = this->Work->inputs.at(index);
  return input ? input->ijkToRAS.Get() : nullptr;
}

// What belongs to all.

void vtkInnerGSReconstruct::ClearInputs() {
  this->RemoveAllInputConnections(0);
  this->RemoveAllInputConnections(1);
  this->Work->inputs = {};
  this->Work->snapshot.reset();
  this->Modified();
}

void vtkInnerGSReconstruct::SetMaskData(vtkImageData* mask) {
  if (mask)
    this->SetInputDataObject(1, mask);
  else
    this->RemoveAllInputConnections(1);
}

void vtkInnerGSReconstruct::SetMaskIJKToRASMatrix(vtkMatrix4x4* ijkToRAS) {
  if (innergs::vtk::assignCopy(this->Work->inputs.maskToRAS, ijkToRAS)) this->Modified();
}

void vtkInnerGSReconstruct::SetRegionToRASMatrix(vtkMatrix4x4* regionToRAS) {
  if (innergs::vtk::assignCopy(this->Work->regionToRAS, regionToRAS)) this->Modified();
}

vtkMatrix4x4* vtkInnerGSReconstruct::GetRegionToRASMatrix() {
  return this->Work->regionToRAS;
}

void vtkInnerGSReconstruct::SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ,
                                             int dimensionK) {
  const int dimensions[3] = {dimensionI, dimensionJ, dimensionK}, first[3] = {0, 0, 0};
  if (this->Work->reference.set(ijkToRAS, dimensions, first)) this->Modified();
}

void vtkInnerGSReconstruct::SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS) {
  if (this->Work->reference.set(image, ijkToRAS)) this->Modified();
}

bool vtkInnerGSReconstruct::HasReferenceGrid() {
  return this->Work->reference.given();
}

void vtkInnerGSReconstruct::SetResumeModel(vtkInnerGSModel* model) {
  if (this->Work->resume == model) return;
  this->Work->resume = model;
  this->Modified();
}

vtkInnerGSModel* vtkInnerGSReconstruct::GetResumeModel() {
  return this->Work->resume;
}
