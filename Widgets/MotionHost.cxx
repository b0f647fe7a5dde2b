#include "Widgets/MotionHost.h"

#include "vtkInnerGSDynamicModel.h"

namespace innergs::ui {

MotionInfo motionInfoOf(vtkInnerGSDynamicModel* model, double now) {
  MotionInfo info;
  double range[2];
  if (!model || !model->GetTimeRange(range)) return info;
  info.known = true;
  info.first = range[0];
  info.last = range[1];
  info.now = now;
  info.kind = QString::fromStdString(model->GetKindName());
  return info;
}

} // namespace innergs::ui
