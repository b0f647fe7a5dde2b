#include "SegmentationFixture.h"

#include <vtkSegmentationConverterFactory.h>
#include <vtkSphereSource.h>

vtkStandardNewMacro(WatchedRule);

std::mutex WatchedRule::mutex;
std::set<std::thread::id> WatchedRule::threads;
bool WatchedRule::held = false;
int WatchedRule::done = 0;
std::condition_variable WatchedRule::changed;

bool WatchedRule::Convert(vtkSegment* segment) {
  {
    std::unique_lock lock(mutex);
    threads.insert(std::this_thread::get_id());
    changed.notify_all();
    changed.wait(lock, [] { return !held; });
  }
  const bool converted = this->Superclass::Convert(segment);
  std::lock_guard lock(mutex);
  ++done;
  return converted;
}

void WatchedRule::waitForEntry() {
  std::unique_lock lock(mutex);
  changed.wait(lock, [] { return !threads.empty(); });
}

WatchedRules::WatchedRules() {
  vtkSegmentationConverterFactory::GetInstance()->RegisterConverterRule(rule_);
  std::lock_guard lock(WatchedRule::mutex);
  WatchedRule::threads.clear();
  WatchedRule::done = 0;
}

WatchedRules::~WatchedRules() {
  vtkSegmentationConverterFactory::GetInstance()->UnregisterConverterRule(rule_);
}

vtkSmartPointer<vtkPolyData> ballSurface(double r, double radius) {
  vtkNew<vtkSphereSource> sphere;
  sphere->SetCenter(r, -2, 3);
  sphere->SetRadius(radius);
  sphere->SetThetaResolution(24);
  sphere->SetPhiResolution(24);
  sphere->Update();
  return sphere->GetOutput();
}

SegmentationFixture::SegmentationFixture() {
  input = addVolume();
  node = addNode<vtkMRMLSegmentationNode>("Organs");
  segments = node->GetSegmentation();
}

vtkSmartPointer<vtkOrientedImageData>
SegmentationFixture::balls(vtkMatrix4x4* toNode, const int extent[6], int type,
                           const std::vector<std::array<double, 4>>& balls) {
  auto image = vtkSmartPointer<vtkOrientedImageData>::New();
  image->SetExtent(const_cast<int*>(extent));
  image->SetImageToWorldMatrix(toNode);
  image->AllocateScalars(type, 1);
  for (int k = extent[4]; k <= extent[5]; ++k)
    for (int j = extent[2]; j <= extent[3]; ++j)
      for (int i = extent[0]; i <= extent[1]; ++i) {
        double at[4] = {double(i), double(j), double(k), 1};
        toNode->MultiplyPoint(at, at);
        int label = 0;
        for (std::size_t n = 0; n < balls.size(); ++n) {
          const auto& b = balls[n];
          if (std::hypot(at[0] - b[0], at[1] - b[1], at[2] - b[2]) < b[3]) label = int(n) + 1;
        }
        image->SetScalarComponentFromDouble(i, j, k, 0, label);
      }
  return image;
}

void SegmentationFixture::addSegment(const std::string& id, vtkDataObject* data, int label) {
  vtkNew<vtkSegment> segment;
  segment->SetLabelValue(label);
  segment->AddRepresentation(data->IsA("vtkPolyData") ? kSurface : kLabelmap, data);
  ASSERT_TRUE(segments->AddSegment(segment, id));
}

void SegmentationFixture::addSurface(const std::string& id, double r, double radius) {
  segments->SetSourceRepresentationName(kSurface);
  addSegment(id, ballSurface(r, radius));
}

void SegmentationFixture::addLabelmaps() {
  const auto matrix = matrixOf(input);
  const int whole[6] = {2, 19, 1, 18, 0, 17};
  auto shared = balls(matrix, whole, VTK_SHORT, {{-6, -4, -5, 8}, {6, 5, -5, 9}});
  const double spacing[3] = {1.1, 0.9, 1.3}, origin[3] = {-5, 2, 4};
  const int part[6] = {-9, 12, -8, 11, -7, 10};
  auto turned = balls(oblique(25, spacing, origin), part, VTK_UNSIGNED_CHAR, {{-2, 4, 6, 8}});
  addSegment("One", shared, 1);
  addSegment("Two", shared, 2);
  addSegment("Turned", turned);
  addSegment("Blank", balls(matrix, whole, VTK_UNSIGNED_CHAR, {}));
  addSegment("Empty", vtkNew<vtkOrientedImageData>());
}
