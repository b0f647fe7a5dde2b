#include "Widgets/EllipsoidActor.h"

#include "vtkInnerGSModel.h"
#include "vtkInnerGSToPolyData.h"

#include <QCoreApplication>

#include <vtkActor.h>
#include <vtkCallbackCommand.h>
#include <vtkCellArray.h>
#include <vtkCommand.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkGlyph3DMapper.h>
#include <vtkIdTypeArray.h>
#include <vtkLookupTable.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkSphereSource.h>
#include <vtkTensorGlyph.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace innergs::ui {

namespace {

vtkSmartPointer<vtkSphereSource> sphere() {
  auto source = vtkSmartPointer<vtkSphereSource>::New();
  source->SetRadius(1);
  source->SetThetaResolution(10);
  source->SetPhiResolution(8);
  return source;
}

/// The points of the given indices.
vtkSmartPointer<vtkPolyData> chosen(vtkPolyData* all, const std::vector<vtkIdType>& indices) {
  auto data = vtkSmartPointer<vtkPolyData>::New();
  const auto count = static_cast<vtkIdType>(indices.size());
  vtkNew<vtkPoints> points;
  points->SetNumberOfPoints(count);
  vtkNew<vtkCellArray> vertices;
  data->GetPointData()->CopyAllocate(all->GetPointData(), count);
  for (vtkIdType i = 0; i < count; ++i) {
    points->SetPoint(i, all->GetPoint(indices[i]));
    data->GetPointData()->CopyData(all->GetPointData(), indices[i], i);
    vertices->InsertNextCell(1, &i);
  }
  data->SetPoints(points);
  data->SetVerts(vertices);
  data->GetPointData()->SetActiveScalars("Intensity");
  data->GetPointData()->SetActiveTensors("Ellipsoid");
  return data;
}

} // namespace

vtkSmartPointer<vtkPolyData> ellipsoidCentres(vtkInnerGSModel* model, const EllipsoidOptions& options,
                                              QString* error) {
  if (error) error->clear();
  vtkNew<vtkInnerGSToPolyData> filter;
  vtkNew<vtkCallbackCommand> silent; // its error is passed on
  silent->SetCallback([](vtkObject*, unsigned long, void*, void*) {});
  filter->AddObserver(vtkCommand::ErrorEvent, silent);
  vtkNew<vtkInnerGSModel> own; // shares the Gaussians, not the pipeline of another thread
  if (model) own->SetCoreModel(model->GetCoreModel());
  filter->SetModel(own);
  filter->ComputeDisagreementOff();
  filter->SetEllipsoidRadius(options.radius);
  filter->Update();
  if (!filter->GetErrorMessage().empty()) {
    if (error) *error = QString::fromStdString(filter->GetErrorMessage());
    return nullptr;
  }
  vtkPolyData* all = filter->GetOutput();
  vtkDataArray* weights = all->GetPointData()->GetArray("Weight");
  vtkDataArray* intensities = all->GetPointData()->GetArray("Intensity");
  const double background = own->GetBackgroundValue();
  const double nothing = options.nothing * (options.window[1] - options.window[0]);
  std::vector<vtkIdType> indices;
  for (vtkIdType i = 0; i < all->GetNumberOfPoints(); ++i)
    if (std::abs(intensities->GetComponent(i, 0) - background) >= nothing) indices.push_back(i);
  const auto most = static_cast<std::size_t>(std::max(0, options.most));
  if (indices.size() > most) {
    std::nth_element(indices.begin(), indices.begin() + static_cast<std::ptrdiff_t>(most), indices.end(),
                     [&](vtkIdType a, vtkIdType b) {
                       const double wa = weights->GetComponent(a, 0), wb = weights->GetComponent(b, 0);
                       return wa > wb || (wa == wb && a < b);
                     });
    indices.resize(most);
    std::sort(indices.begin(), indices.end());
  }
  if (indices.empty()) {
    if (error)
      *error = QCoreApplication::translate("innergs::ui::EllipsoidActor",
                                           "The model has no ellipsoids that differ from its background.");
    return nullptr;
  }
  return chosen(all, indices);
}

vtkSmartPointer<vtkPolyData> ellipsoidSurfaces(vtkInnerGSModel* model, const EllipsoidOptions& options,
                                               QString* error) {
  const auto centres = ellipsoidCentres(model, options, error);
  if (!centres) return nullptr;
  vtkNew<vtkTensorGlyph> glyph;
  glyph->SetInputData(centres);
  glyph->SetSourceConnection(sphere()->GetOutputPort());
  glyph->ExtractEigenvaluesOn();
  glyph->ScalingOn();
  glyph->SetScaleFactor(1);
  glyph->ClampScalingOff();
  glyph->ColorGlyphsOn();
  glyph->SetColorModeToScalars();
  glyph->Update();
  vtkSmartPointer<vtkPolyData> surfaces = glyph->GetOutput();
  if (vtkDataArray* scalars = surfaces->GetPointData()->GetScalars()) scalars->SetName("Intensity");
  vtkNew<vtkIdTypeArray> count;
  count->SetName("Gaussians");
  count->InsertNextValue(centres->GetNumberOfPoints());
  surfaces->GetFieldData()->AddArray(count);
  return surfaces;
}

vtkSmartPointer<vtkActor> ellipsoidActor(vtkPolyData* centres, const EllipsoidOptions& options) {
  vtkNew<vtkGlyph3DMapper> mapper;
  mapper->SetInputData(centres);
  mapper->SetSourceConnection(sphere()->GetOutputPort());
  mapper->SetScaleArray("Scales");
  mapper->SetScaleModeToScaleByVectorComponents();
  mapper->SetScaleFactor(options.radius);
  mapper->SetOrientationArray("Orientation");
  mapper->SetOrientationModeToQuaternion();
  mapper->SetScalarModeToUsePointFieldData();
  mapper->SelectColorArray("Intensity");
  vtkNew<vtkLookupTable> greys;
  greys->SetHueRange(0, 0);
  greys->SetSaturationRange(0, 0);
  greys->SetValueRange(0.1, 1); // black ones would be invisible on a black background
  greys->SetRange(options.window.data());
  greys->Build();
  mapper->SetLookupTable(greys);
  mapper->SetColorModeToMapScalars();
  mapper->UseLookupTableScalarRangeOn();
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  actor->GetProperty()->SetSpecular(0.1);
  return actor;
}

} // namespace innergs::ui
