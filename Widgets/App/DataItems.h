#pragma once
#include "Core/Base/Error.h"
#include "Core/Image/Volume.h"
#include "Core/Job/FoundSlices.h"
#include "Core/Motion/DynamicField.h"
#include "Core/Uncertainty/Uncertainty.h"
#include "IO/ModelFile.h"
#include "IO/SegmentNames.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSModel.h"

#include <vtkImageData.h>
#include <vtkMatrix4x4.h>
#include <vtkSmartPointer.h>
#include <vtkTable.h>

#include <QString>

#include <array>
#include <memory>

namespace innergs::app {

/// The intensities shown as black and white. An input and its results share one, so they can be compared.
struct Window {
  double lower = 0, upper = 1;
  double firstLower = 0, firstUpper = 1; // what "reset" goes back to
};

/// The images of a 4D file, of which an item is one.
struct Frames {
  QString file; // that holds them; "" no such file
  int count = 1;
  int shown = 0;      // from 0
  double seconds = 0; // from one to the next; 0: unknown
};

/// Only a scan is proposed as the input of a reconstruction.
enum class VolumeRole {
  Scan,  // opened as such
  Truth, // what the sample's scan was made from, to compare with
  Made   // here: a result or a plane, saved or not
};

/// A scalar volume of the document. Its voxels never change, so threads may read them.
struct VolumeItem {
  QString id, name, file; // file "": in none yet
  VolumeRole role = VolumeRole::Scan;
  QString note;   // what was done to open it, sentences; may be ""
  QString caveat; // of figures measured on it, a sentence; may be ""
  Frames frames;
  std::shared_ptr<const Volume> volume;
  vtkSmartPointer<vtkImageData> image;    // the same voxels; origin 0, spacing 1
  vtkSmartPointer<vtkMatrix4x4> ijkToRAS; // mm
  double thickness = 0;                   // mm, as the file says; 0: the distance between slices
  int sliceAxis = 2;                      // counts the slices
  std::vector<double> times;              // s, as Stack::times; empty: not said
  std::vector<Affine3> poses;             // as Stack::poses; the views show such slices as parallel ones
  QString unplaced;                       // why the images of a tracked sweep have no poses; "": they have
  std::array<double, 2> range{0, 0};      // of the finite voxels
  std::shared_ptr<Window> window;
  std::vector<SegmentInfo> segments; // of a labelmap made here
  bool saved = true;
};

/// A model of the document.
struct ModelItem {
  QString id, name, file;
  QString origin;                                  // the scans' names, or the file
  ModelNotes notes;                                // what it was made from, for its file
  vtkSmartPointer<vtkInnerGSModel> model;          // of a dynamic scan, its model at `time`
  vtkSmartPointer<vtkInnerGSDynamicModel> dynamic; // null for others
  double time = 0;                                 // s
  std::array<double, 2> window{0, 1};              // intensities worth showing
  QString uncertaintyId;                           // the volume of its standard deviation; "" none
  std::vector<FoundSlice> slices;                  // of its scans, where they were moved; not saved
  vtkSmartPointer<vtkTable> sliceTable;            // the same; null: none was moved
  bool saved = true, ellipsoidsShown = false;
  std::int64_t ellipsoids = 0; // that the 3D view draws
};

/// An item (without ID) for a volume: image, range, window and slice axis. Looks at every voxel: for worker
/// threads. Throws Error(Geometry | NoData).
VolumeItem makeItem(Volume volume, const QString& name, const QString& file = {}, double thickness = 0,
                    int sliceAxis = -1);
/// Likewise for where some slice measured the tissue: a labelmap, unsaved.
VolumeItem makeMeasuredItem(const Uncertainty& uncertainty, const QString& name);
/// Likewise for standard deviations, unsaved; the image also says what was measured (UncertaintyImage.h).
VolumeItem makeItem(Uncertainty uncertainty, const QString& name);
ModelItem makeItem(std::shared_ptr<const Model> model, const QString& name, const QString& file = {},
                   ModelNotes notes = {}, std::shared_ptr<const FeatureModel> features = nullptr);

/// Likewise for a dynamic scan's model, at its first frame's time.
ModelItem makeItem(const std::shared_ptr<const DynamicField>& field, const QString& name,
                   const QString& file = {}, ModelNotes notes = {},
                   std::shared_ptr<const FeatureModel> features = nullptr);

/// Whether the slices of a scan lie on no grid, so that it can only be reconstructed.
bool hasNoGrid(const VolumeItem& item);
/// Error(Geometry) for another use of such a scan.
Error noGridError(const VolumeItem& item);

/// "axial", "coronal", "sagittal" or "oblique": how the slices along an axis lie.
QString orientationOf(const GridGeometry& geometry, int sliceAxis);

} // namespace innergs::app
