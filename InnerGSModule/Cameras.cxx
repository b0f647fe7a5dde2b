#include "Cameras.h"

#include <vtkMRMLCameraNode.h>
#include <vtkMRMLScene.h>

#include <vtkMath.h>
#include <vtkNew.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace {

struct Pose {
  double position[3], focus[3];
  explicit Pose(vtkMRMLCameraNode* camera) {
    camera->GetPosition(position);
    camera->GetFocalPoint(focus);
  }
  bool operator==(const Pose& other) const {
    return std::equal(position, position + 3, other.position) && std::equal(focus, focus + 3, other.focus);
  }
};

} // namespace

void frameUntouchedCameras(vtkMRMLScene* scene, const double bounds[6]) {
  double centre[3], radius = 0;
  for (int a = 0; a < 3; ++a) {
    centre[a] = (bounds[2 * a] + bounds[2 * a + 1]) / 2;
    radius = std::hypot(radius, (bounds[2 * a + 1] - bounds[2 * a]) / 2);
  }
  if (!(radius > 0)) return;
  const vtkNew<vtkMRMLCameraNode> fresh;
  std::vector<vtkMRMLNode*> nodes;
  scene->GetNodesByClass("vtkMRMLCameraNode", nodes);
  for (vtkMRMLNode* node : nodes) {
    auto* camera = vtkMRMLCameraNode::SafeDownCast(node);
    const Pose pose(camera);
    if (!(pose == Pose(fresh))) continue;
    const double distance = radius / std::sin(vtkMath::RadiansFromDegrees(camera->GetViewAngle()) / 2);
    const double before = std::sqrt(vtkMath::Distance2BetweenPoints(pose.position, pose.focus));
    double position[3];
    for (int a = 0; a < 3; ++a)
      position[a] = centre[a] + (pose.position[a] - pose.focus[a]) / before * distance;
    {
      MRMLNodeModifyBlocker blocker(camera);
      camera->SetFocalPoint(centre);
      camera->SetPosition(position);
    }
    camera->ResetClippingRange();
  }
}
