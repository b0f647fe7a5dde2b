#pragma once

class vtkMRMLScene;

/// Frames the scene's 3D views on a box (RAS mm: xmin, xmax, ymin, ...), but only those whose camera is still
/// at its initial position.
void frameUntouchedCameras(vtkMRMLScene* scene, const double bounds[6]);
