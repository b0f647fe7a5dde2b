#pragma once
#include "FakeHost.h"

#include "vtkInnerGSModel.h"
#include "vtkInnerGSReconstruct.h"

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>

/// The intensity that the ramp model was fitted to, at a RAS point (mm).
inline double rampAt(double r, double a, double s) {
  return 200 + 3 * r - 2 * a + s;
}

/// A model of 40×48×36 mm around (5, −10, 20), fitted to slices of rampAt() in a second or two.
inline vtkSmartPointer<vtkInnerGSModel> fittedRamp() {
  vtkNew<vtkImageData> image;
  image->SetDimensions(20, 24, 18);
  image->AllocateScalars(VTK_FLOAT, 1);
  vtkNew<vtkMatrix4x4> toRAS; // left-handed: I to the left, J to the front, K up; 2 mm
  const double corner[3] = {24, -33, 3};
  for (int a = 0; a < 3; ++a) {
    toRAS->SetElement(a, a, a == 0 ? -2 : 2);
    toRAS->SetElement(a, 3, corner[a]);
  }
  for (int k = 0; k < 18; ++k)
    for (int j = 0; j < 24; ++j)
      for (int i = 0; i < 20; ++i)
        image->SetScalarComponentFromDouble(i, j, k, 0,
                                            rampAt(corner[0] - 2 * i, corner[1] + 2 * j, corner[2] + 2 * k));
  vtkNew<vtkInnerGSReconstruct> fit;
  fit->AddInputData(image);
  fit->SetInputIJKToRASMatrix(0, toRAS);
  fit->SetPreset(vtkInnerGSReconstruct::Fast);
  fit->SetNumberOfGaussians(400);
  fit->SetNumberOfIterations(40);
  fit->SetLinearIntensity(1);
  fit->SetOutputSpacing(2, 2, 2);
  fit->Update();
  auto model = vtkSmartPointer<vtkInnerGSModel>::New();
  model->ShallowCopy(fit->GetOutputModel());
  return model;
}

inline QString addModel(FakeHost& host, const QString& id, vtkInnerGSModel* data,
                        const std::array<double, 2>& window) {
  innergs::ui::ModelInfo info;
  info.name = id;
  info.gaussians = data->GetNumberOfGaussians();
  info.bytes = std::int64_t{1024} * static_cast<std::int64_t>(data->GetActualMemorySize());
  info.description = QString::fromStdString(data->GetDescription());
  data->GetBounds(info.bounds.data());
  info.window = window;
  info.finestSpacing = 2;
  host.models[id] = info;
  host.modelData[id] = data;
  Q_EMIT host.modelsChanged();
  return id;
}
