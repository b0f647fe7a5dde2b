#pragma once
#include "Core/Job/Progress.h"
#include "Text/SegmentFinder.h"
#include "Widgets/Request.h"
#include "Widgets/SegmentWorker.h"
#include "Widgets/Selector.h"
#include "Widgets/UncertaintyVolume.h"

#include <QObject>

#include <vtkAbstractTransform.h>
#include <vtkSmartPointer.h>

class vtkImageData;
class vtkInnerGSModel;
class vtkMatrix4x4;
class vtkTable;

Q_DECLARE_METATYPE(innergs::Progress)

namespace innergs::ui {

class MotionHost;

/// What the panels need from the program that shows them: 3D Slicer's module or the desktop app. Called on
/// the main thread only, where all signals come as well. Nothing throws; a failure is one sentence that says
/// what to do.
class Host : public QObject {
  Q_OBJECT
public:
  using QObject::QObject;

  enum class Role {
    Input,        // a scan
    Mask,         // a labelmap or segmentation, or none
    Region,       // a box, or none
    Reference,    // a volume whose voxels the result gets
    OutputVolume, // a volume to write to, or new
    OutputModel,  // a model to write to, or new
    Model,        // a model to look at
    Labels,       // a labelmap or segmentation to learn from
    Series,       // a dynamic scan
    SlicePoses    // where the slices of a scan lie, a transform for each, or none
  };
  /// Whether there can be anything to choose for a role (the app has no regions).
  virtual bool offers(Role role) const = 0;
  virtual Selector* createSelector(Role role, QWidget* parent) = 0;
  /// Whether there is something to choose for Role::SlicePoses now: few scans need them.
  virtual bool hasSlicePoses() const { return false; }

  /// Default-constructed (no name) for an unknown ID.
  virtual VolumeInfo volumeInfo(const QString& id) const = 0;

  ///@{
  /// Reconstruction: one at a time from the panels' view. Every start() that returns true ends with exactly
  /// one of finished, failed, cancelled and ended.
  virtual Estimate estimate(const Request& request) = 0; // quick (≤ 50 ms): called while the user chooses
  /// False, after failed(sentence), when it is refused.
  virtual bool start(const Request& request) = 0;
  virtual void cancel() = 0; // returns at once; cancelled() follows within 200 ms
  virtual bool isRunning() const = 0;
  ///@}

  ///@{
  /// The last result, in 3D Slicer that of the parameter set, and where the slices of its scans were found to
  /// lie.
  virtual bool hasResult() const { return false; }
  /// As vtkInnerGSReconstruct::GetSliceTable(), another object for another result; null: no slice was moved.
  virtual vtkTable* sliceTable() const { return nullptr; }
  /// Whether transforms and table are written to files, or are in the scene.
  virtual bool keepsSlicesInFiles() const { return false; }
  /// Makes a transform per slice, as nodes or as .tfm files in a folder. A sentence on what was made, or ""
  /// with one in *error.
  virtual QString createSliceTransforms(const QString& /*folder*/, QString* /*error*/) { return {}; }
  /// The table as tab-separated values. "" or a sentence.
  virtual QString saveSliceTable(const QString& /*file*/) { return {}; }
  ///@}

  ///@{
  /// Models.
  virtual ModelInfo modelInfo(const QString& id) const = 0;
  /// The ID of the only model there is; "": none or several, or a selector chooses one by itself.
  virtual QString onlyModel() const { return {}; }
  /// Null for an unknown ID, and for a model that cannot be shown where it is.
  virtual vtkInnerGSModel* model(const QString& id) const = 0;
  /// RAS → the model's own RAS, where the model has been moved; null: the same. Another thread may use it:
  /// it never changes, and is another object after the model was moved again.
  virtual vtkSmartPointer<vtkAbstractTransform> toModel(const QString& /*id*/) const { return nullptr; }
  /// How far the model's volume may be off; null: unknown. Another object after a change.
  virtual std::shared_ptr<const UncertaintyVolume> uncertaintyOf(const QString& /*id*/) const {
    return nullptr;
  }
  /// The ID of what was read, or "" with a sentence in *error. Files: .innergs, .ply.
  virtual QString loadModel(const QString& file, QString* error) = 0;
  /// "" or a sentence. A .ply file holds only the Gaussians, so the model stays unsaved.
  virtual QString saveModel(const QString& id, const QString& file) = 0;
  virtual QString showEllipsoids(const QString& id, bool shown) = 0;
  /// Adds a volume to the host's; its ID, or "" with a sentence in *error.
  virtual QString addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                            QString* error) = 0;
  /// The same for what was made from a model, shown from lower (black) to upper (white) intensities.
  virtual QString addVolumeOf(const QString& /*modelId*/, const std::array<double, 2>& /*window*/,
                              vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                              QString* error) {
    return addVolume(image, ijkToRAS, name, error);
  }
  ///@}

  /// The folder that keeps the state of fits stopped by anything but cancel() (IO/RecoveredFit.h); "": it is
  /// not kept.
  virtual QString recoveryFolder() const { return {}; }

  ///@{
  /// Segments by their names; a host that does not offer Role::Labels has none of them.
  /// Whether the labels' names are asked for as a file.
  virtual bool asksForNames() const { return false; }
  /// Labels for a model to learn from; names: a file with their names, "": the labels' own. What is returned
  /// may be called on another thread, and throws Error. Empty, with a sentence in *error, when it is refused.
  virtual std::function<NamedLabels(const std::stop_token&)> labelsFor(const QString& /*modelId*/,
                                                                       const QString& /*labelsId*/,
                                                                       const QString& /*names*/,
                                                                       QString* /*error*/) {
    return {};
  }
  /// Gives a model what was learned for it, which leaves it unsaved. "" or a sentence.
  virtual QString setFeatures(const QString& /*modelId*/, const std::shared_ptr<const FeatureModel>&) {
    return {};
  }
  /// Shows segments of a model in the views until the next ones; none: nothing.
  virtual void previewSegments(const QString& /*modelId*/, const MadeSegments&) {}
  /// Keeps segments of a model in the host's own form (a segmentation node, a labelmap); the name of what
  /// holds them, or "" with a sentence in *error.
  virtual QString addSegments(const QString& /*modelId*/, const MadeSegments&, QString* /*error*/) {
    return {};
  }
  ///@}

  /// Of dynamic scans; null where the program has none.
  virtual MotionHost* motion() { return nullptr; }

  /// The folder that file dialogs open in. It is remembered.
  virtual QString folder() const = 0;
  virtual void setFolder(const QString& folder) = 0;

Q_SIGNALS:
  void started();
  /// After started(): it waits for another reconstruction to end. The first progressed() ends the wait.
  void waiting();
  void progressed(const innergs::Progress& progress);
  /// A coarse rendering of the result so far.
  void previewed(vtkImageData* image, vtkMatrix4x4* ijkToRAS);
  void finished(const innergs::ui::Report& report);
  void failed(const QString& sentence);
  void cancelled();
  /// Nobody cancelled it, but what it works on was taken away. why: sentences.
  void ended(const QString& why);
  /// Volumes came, went or were renamed.
  void volumesChanged();
  void modelsChanged();
  /// The same request may now be estimated otherwise: a slow part of an estimate is known.
  void estimateChanged();
  /// For the log panel.
  void logged(const QString& line);
};

} // namespace innergs::ui
