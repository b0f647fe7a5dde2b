#pragma once
#include <QString>

#include <vtkSmartPointer.h>

#include <array>

class vtkActor;
class vtkInnerGSModel;
class vtkPolyData;

namespace innergs::ui {

/// How a model's Gaussians are drawn: in RAS mm, coloured by their intensity.
struct EllipsoidOptions {
  int most = 20000;                   // maximum number: those with the largest weights
  double radius = 1;                  // in standard deviations
  std::array<double, 2> window{0, 1}; // scanner units: black and white
  double nothing = 0.1; // share of the window around the model's background value: hides Gaussians within it,
                        // as those of the air would cover the rest
};

///@{
/// All may be called on any thread; null after an error, with a sentence in *error (may be null).
/// Centres with the arrays of vtkInnerGSToPolyData.
vtkSmartPointer<vtkPolyData> ellipsoidCentres(vtkInnerGSModel* model, const EllipsoidOptions& options,
                                              QString* error);
/// Closed surfaces with "Intensity" at their points, e.g. for a model node: about 60 points each. The field
/// array "Gaussians" contains their number.
vtkSmartPointer<vtkPolyData> ellipsoidSurfaces(vtkInnerGSModel* model, const EllipsoidOptions& options,
                                               QString* error);
///@}
/// For a view: draws the ellipsoids as instances of one sphere, efficient even for many.
vtkSmartPointer<vtkActor> ellipsoidActor(vtkPolyData* centres, const EllipsoidOptions& options);

} // namespace innergs::ui
