#pragma once

class vtkMRMLScene;

/// Frames the scene's 3D views on a box (RAS mm: xmin, xmax, ymin, ...), but only those whose camera is still
/// where every new one is.
void frameUntouchedCameras(vtkMRMLScene* scene, const double bounds[6]);
