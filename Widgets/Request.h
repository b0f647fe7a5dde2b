#pragma once
#include "Core/Job/Progress.h"
#include "Core/Settings/Settings.h"

#include <QMetaType>
#include <QString>
#include <QStringList>
#include <QVector>

#include <array>
#include <cmath>
#include <cstdint>

/// What passes between the panels and the program that shows them (Host.h). Volumes, regions and models are
/// named by the host's IDs: node IDs in 3D Slicer, the document's own in the desktop app.
namespace innergs::ui {

/// One scan of a reconstruction.
struct InputChoice {
  QString id;
  double sliceThickness = 0; // mm; 0: the distance between slices
  int sliceProfile = 1;      // as innergs::SliceProfile: 0 point, 1 box, 2 Gaussian
  int sliceAxis = -1;        // 0, 1, 2: the index axis that counts the slices; −1: automatic
  QString maskId = {};       // of its own; "": the request's
  QString posesId = {};      // where its slices lie, a transform for each; "": where the volume puts them
  bool operator==(const InputChoice&) const = default;
};

/// The grid of the result, as vtkMRMLInnerGSParameterNode::OutputGrids.
enum class OutputGrid {
  Automatic, // isotropic at the finest spacing of all inputs, over the first one's box or the region
  Input,     // the first input's voxels
  Spacing,   // isotropic at `spacing`
  Reference  // the reference volume's voxels
};

/// Everything that a reconstruction is asked for.
struct Request {
  QVector<InputChoice> inputs;
  QString maskId, regionId; // "" none; the mask of the scans without one of their own
  OutputGrid grid = OutputGrid::Automatic;
  double spacing = 1;                    // mm
  QString referenceId;                   // with OutputGrid::Reference
  QString outputVolumeId, outputModelId; // "" new ones
  Settings settings;
  double heldOutFraction = 0;       // of each input's slices, held out from a second fit; 0 to 0.5
  bool estimateUncertainty = false; // also a volume of how far the result may be off
  bool evaluateQuality = true;      // also judge the settings by protocol H in a second fit
  QString resumeFile;               // a model file to resume; "": none
  int qualityGap = 0;               // protocol H keeps every n-th slice; 0: 2nd or 4th by the spacing
};

struct VolumeInfo {
  QString name;
  std::array<int, 3> dimensions{}; // voxels along I, J, K
  std::array<double, 3> spacing{}; // mm
  int sliceAxis = 2;               // what −1 in InputChoice leads to
  QString orientation;             // of its slices: "axial", "coronal", "sagittal", "oblique"
  double sliceThickness = 0;       // mm, as the file says: what 0 in InputChoice leads to; 0: it does not
  bool hasPoses = false;           // each slice lies at a pose of its own, as the file says
  int passes = 0; // interleaved ones in which its slices were acquired, as the file says; 0: unknown
};

/// What a reconstruction will take, before the start.
struct Estimate {
  QString refusal;            // the sentence with which it would be refused; "" when it can start
  std::int64_t memory = 0;    // bytes beyond the inputs; 0: unknown
  std::int64_t available = 0; // bytes that the machine has; 0: unknown
  double seconds = 0;         // roughly; 0: unknown
  QString reason;             // where it will run, and why there
};

/// One method's score on samples that no method saw.
struct QualityRow {
  QString method;            // the evaluation's name for it: "gaussians", "linear", ...
  double psnr = 0, ssim = 0; // dB; −1…1
  bool isOurs() const { return method == QLatin1String("gaussians"); }
};

/// What a successful reconstruction reports.
struct Report {
  QString volumeId, modelId, tableId; // what it made; tableId may be ""
  QString uncertaintyId;              // the standard deviation of the volume; "": none
  QString uncertainty;                // how often its intervals hold, a sentence; "": none
  QStringList warnings;               // sentences
  QString profile;                    // how thick the slices look, a sentence; "": unknown
  QString agreement;                  // how well several scans agree, sentences; "": one scan
  QString prediction;                 // what was put between the slices, a sentence; "": nothing
  double trainingPsnr = NAN;          // dB on the fitted samples: not held out
  Judging judging = Judging::NotAsked;
  double heldOutPsnr = NAN; // dB on held-out slices, of a second fit that did not see them; NaN: unknown
  int heldOutSlices = 0;    // of all scans
  int scans = 1;            // that were reconstructed together
  QVector<QualityRow>
      quality;            // protocol H on the first scan alone, on slices no method saw; empty: not asked for
  QString qualitySamples; // which samples these are, a sentence
  double seconds = 0;
  std::int64_t gaussians = 0;
  QString device, settings; // where it ran and why; "name=value; ..."
};

struct ModelInfo {
  QString name;
  std::int64_t gaussians = 0, bytes = 0;
  QString description;            // one line
  std::array<double, 6> bounds{}; // RAS mm: xmin, xmax, ymin, ...
  std::array<double, 2> window{}; // lower and upper intensity worth showing
  double finestSpacing = 1;       // mm: a sensible pixel size for planes
  bool saved = true;              // false: lost when the program ends
  QString origin;                 // where it came from, for people: the scans' names, or a file; "" unknown
  QString file;                   // where it was last read from or saved to; "" nowhere yet
  bool ellipsoidsShown = false;
  std::int64_t ellipsoids = 0; // drawn then, of its Gaussians; 0: not yet, or unknown
};

} // namespace innergs::ui

Q_DECLARE_METATYPE(innergs::ui::Report)
Q_DECLARE_METATYPE(innergs::ui::Request)
