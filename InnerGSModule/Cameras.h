#pragma once

class vtkMRMLScene;

/// Frames the scene's 3D views on a box (RAS mm: xmin, xmax, ymin, ...), those alone whose camera is where
/// every new one is: nobody chose what they show.
void frameUntouchedCameras(vtkMRMLScene* scene, const double bounds[6]);
