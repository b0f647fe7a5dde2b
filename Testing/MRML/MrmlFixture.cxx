#include "MrmlFixture.h"

#include <vtkMRMLTransformNode.h>

#include <vtkTransform.h>

#include <cmath>
#include <random>

Observer::Observer(vtkObject* object, std::initializer_list<unsigned long> events, Call call)
    : object_(object), call_(std::move(call)) {
  command_->SetClientData(this);
  command_->SetCallback([](vtkObject*, unsigned long event, void* self, void* data) {
    static_cast<Observer*>(self)->call_(event, data);
  });
  for (unsigned long event : events)
    object_->AddObserver(event, command_);
}

Observer::~Observer() {
  object_->RemoveObserver(command_);
}

MrmlFixture::MrmlFixture() : logic(vtkSmartPointer<vtkSlicerInnerGSLogic>::New()) {
  logic->SetMRMLScene(scene);
  onError_ = std::make_unique<Observer>(
      logic, std::initializer_list<unsigned long>{vtkCommand::ErrorEvent},
      [this](unsigned long, void* text) { errors.emplace_back(static_cast<const char*>(text)); });
  std::random_device random;
  folder = std::filesystem::temp_directory_path() / ("innergs-mrml-" + std::to_string(random()));
  std::filesystem::create_directories(folder);
  logic->SetRecoveryFolder((folder / "recovery").string());
}

MrmlFixture::~MrmlFixture() {
  onError_.reset();
  std::error_code ignored;
  std::filesystem::remove_all(folder, ignored);
}

double MrmlFixture::truth(double r, double a, double s) {
  return 400 + 120 * std::sin(r / 7) + 90 * std::cos(a / 6 + 0.3) + 70 * std::sin(s / 8 - 0.5) + r - 2 * a +
         3 * s;
}

vtkMRMLScalarVolumeNode* MrmlFixture::addVolume(const char* name, const int size[3], vtkMatrix4x4* ijkToRAS,
                                                vtkMatrix4x4* nodeToWorld) {
  vtkNew<vtkImageData> image;
  image->SetDimensions(size);
  image->AllocateScalars(VTK_SHORT, 1);
  auto* voxel = static_cast<short*>(image->GetScalarPointer());
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        double at[4] = {double(i), double(j), double(k), 1};
        ijkToRAS->MultiplyPoint(at, at);
        if (nodeToWorld) nodeToWorld->MultiplyPoint(at, at);
        *voxel++ = static_cast<short>(std::lround(truth(at[0], at[1], at[2])));
      }
  auto* node = addNode<vtkMRMLScalarVolumeNode>(name);
  node->SetAndObserveImageData(image);
  node->SetIJKToRASMatrix(ijkToRAS);
  return node;
}

vtkMRMLScalarVolumeNode* MrmlFixture::addVolume(const char* name) {
  const int size[3] = {24, 22, 20};
  vtkNew<vtkMatrix4x4> matrix;
  for (int a = 0; a < 3; ++a) {
    matrix->SetElement(a, a, 2);
    matrix->SetElement(a, 3, -(size[a] - 1.0));
  }
  return addVolume(name, size, matrix);
}

vtkMRMLScalarVolumeNode* MrmlFixture::addLargerVolume(const char* name) {
  const int size[3] = {36, 34, 30};
  const double spacing[3] = {1.5, 1.5, 2}, origin[3] = {-20, -25, -30};
  return addVolume(name, size, oblique(20, spacing, origin));
}

vtkMRMLScalarVolumeNode* MrmlFixture::addCentredVolume(const char* name, const int size[3],
                                                       const double spacing[3]) {
  vtkNew<vtkMatrix4x4> matrix;
  for (int a = 0; a < 3; ++a) {
    matrix->SetElement(a, a, spacing[a]);
    matrix->SetElement(a, 3, -spacing[a] * (size[a] - 1) / 2);
  }
  return addVolume(name, size, matrix);
}

vtkMRMLScalarVolumeNode* MrmlFixture::addThickVolume(const char* name) {
  const int size[3] = {32, 30, 10};
  const double spacing[3] = {1.5, 1.5, 5};
  return addCentredVolume(name, size, spacing);
}

vtkMRMLInnerGSParameterNode* MrmlFixture::addParameters(vtkMRMLVolumeNode* input) {
  auto* node = addNode<vtkMRMLInnerGSParameterNode>();
  node->SetInputVolumeNode(input);
  node->SetPreset(vtkMRMLInnerGSParameterNode::Fast);
  return node;
}

vtkMRMLLinearTransformNode* MrmlFixture::addTransform(vtkMatrix4x4* matrix, const char* name) {
  auto* node = addNode<vtkMRMLLinearTransformNode>(name);
  node->SetMatrixTransformToParent(matrix);
  return node;
}

vtkSmartPointer<vtkSlicerInnerGSLogic> MrmlFixture::anotherLogic() {
  auto other = vtkSmartPointer<vtkSlicerInnerGSLogic>::New();
  other->SetRecoveryFolder(logic->GetRecoveryFolder());
  other->SetMRMLScene(scene);
  return other;
}

double MrmlFixture::error(vtkMRMLScalarVolumeNode* volume, int margin) {
  vtkNew<vtkMatrix4x4> toWorld, ijkToRAS;
  if (auto* parent = volume->GetParentTransformNode()) parent->GetMatrixTransformToWorld(toWorld);
  volume->GetIJKToRASMatrix(ijkToRAS);
  vtkMatrix4x4::Multiply4x4(toWorld, ijkToRAS, toWorld);
  int size[3];
  volume->GetImageData()->GetDimensions(size);
  const auto range = [&](int axis) { return size[axis] > 2 * margin ? margin : 0; };
  double sum = 0;
  int count = 0;
  for (int k = range(2); k < size[2] - range(2); ++k)
    for (int j = range(1); j < size[1] - range(1); ++j)
      for (int i = range(0); i < size[0] - range(0); ++i, ++count) {
        double at[4] = {double(i), double(j), double(k), 1};
        toWorld->MultiplyPoint(at, at);
        const double e =
            volume->GetImageData()->GetScalarComponentAsDouble(i, j, k, 0) - truth(at[0], at[1], at[2]);
        sum += e * e;
      }
  return std::sqrt(sum / count);
}

int MrmlFixture::countNodes(const char* className) {
  return scene->GetNumberOfNodesByClass(className);
}

vtkSmartPointer<vtkMatrix4x4> matrixOf(vtkMRMLVolumeNode* volume) {
  auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
  volume->GetIJKToRASMatrix(matrix);
  return matrix;
}

vtkSmartPointer<vtkMatrix4x4> oblique(double degrees, const double spacing[3], const double origin[3]) {
  vtkNew<vtkTransform> transform;
  transform->Translate(origin);
  transform->RotateWXYZ(degrees, 1, 2, 3);
  transform->Scale(spacing);
  auto matrix = vtkSmartPointer<vtkMatrix4x4>::New();
  matrix->DeepCopy(transform->GetMatrix());
  return matrix;
}
