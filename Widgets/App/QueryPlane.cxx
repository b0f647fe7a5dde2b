#include "Widgets/App/QueryPlane.h"

#include "Widgets/PlaneWorker.h"

#include <vtkActor.h>
#include <vtkImageData.h>
#include <vtkImageProperty.h>
#include <vtkImageSlice.h>
#include <vtkImageSliceMapper.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkOutlineSource.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>

namespace innergs::app {

struct QueryPlane::Parts {
  vtkNew<vtkImageSliceMapper> mapper;
  vtkNew<vtkImageSlice> slice;
  vtkNew<vtkOutlineSource> frame;
  vtkNew<vtkActor> outline;
};

QueryPlane::QueryPlane(vtkRenderer* renderer) : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  p.mapper->SetOrientationToZ();
  p.mapper->BorderOn(); // half a pixel more: full pixels, not up to their centres
  p.slice->SetMapper(p.mapper);
  p.slice->GetProperty()->SetInterpolationTypeToLinear();
  vtkNew<vtkPolyDataMapper> lines;
  lines->SetInputConnection(p.frame->GetOutputPort());
  p.outline->SetMapper(lines);
  p.outline->GetProperty()->LightingOff();
  p.outline->GetProperty()->SetColor(0.30, 0.75, 1); // a different colour from the three slices
  p.outline->GetProperty()->SetLineWidth(2);
  show();
  renderer->AddViewProp(p.slice);
  renderer->AddActor(p.outline);
}

QueryPlane::~QueryPlane() = default;

void QueryPlane::setPicture(const ui::PlaneImage& picture) {
  Parts& p = *parts_;
  any_ = picture.shown() != nullptr && picture.ijkToRAS != nullptr;
  if (any_) {
    int size[3];
    picture.shown()->GetDimensions(size);
    p.mapper->SetInputData(picture.shown());
    p.frame->SetBounds(-0.5, size[0] - 0.5, -0.5, size[1] - 0.5, 0, 0);
    p.slice->SetUserMatrix(picture.ijkToRAS);
    p.outline->SetUserMatrix(picture.ijkToRAS);
  }
  show();
}

void QueryPlane::setWindow(double lower, double upper) {
  parts_->slice->GetProperty()->SetColorWindow(upper - lower);
  parts_->slice->GetProperty()->SetColorLevel(0.5 * (lower + upper));
}

void QueryPlane::setShown(bool shown) {
  shown_ = shown;
  show();
}

void QueryPlane::show() {
  parts_->slice->SetVisibility(shown_ && any_);
  parts_->outline->SetVisibility(shown_ && any_);
  if (!any_) parts_->mapper->SetInputData(nullptr);
}

} // namespace innergs::app
