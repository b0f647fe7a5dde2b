#pragma once
#include "ScopedObservers.h"
#include "Widgets/ForecastCache.h"
#include "Widgets/Host.h"

#include <vtkSlicerInnerGSLogic.h>

#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <QMap>
#include <QSet>
#include <QThreadPool>
#include <QTimer>

#include <array>
#include <functional>
#include <optional>
#include <vector>

class EllipsoidNodes;
class VolumeObserver;
class qSlicerInnerGSMotionHost;
class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLNode;
class vtkMRMLScene;
class vtkMRMLSegmentationNode;
class vtkMRMLTransformNode;
class vtkObject;
class vtkSlicerInnerGSJob;

/// The scene and the module's logic as the panels' host. Requests are written to the parameter node first.
class qSlicerInnerGSHost : public innergs::ui::Host {
  Q_OBJECT
public:
  explicit qSlicerInnerGSHost(QObject* parent = nullptr);
  ~qSlicerInnerGSHost() override;

  void setLogic(vtkSlicerInnerGSLogic* logic);
  void setMRMLScene(vtkMRMLScene* scene);
  /// The parameter set that requests are written to.
  void setParameterNode(vtkMRMLInnerGSParameterNode* node);
  vtkMRMLInnerGSParameterNode* parameterNode() const;
  /// While the panels are hidden, nothing is written to the parameter node or estimated.
  void setActive(bool active);
  /// Writes it, unless the scene is being closed or loaded.
  void store(const innergs::ui::Request& request);
  vtkMRMLInnerGSModelNode* modelNode(const QString& id) const;
  /// Why model() is null for an existing model (a transform it cannot follow), as a sentence; else "".
  QString modelProblem(const QString& id) const;

  bool offers(Role role) const override;
  innergs::ui::Selector* createSelector(Role role, QWidget* parent) override;
  bool hasSlicePoses() const override;
  innergs::ui::VolumeInfo volumeInfo(const QString& id) const override;
  innergs::ui::Estimate estimate(const innergs::ui::Request& request) override;
  bool start(const innergs::ui::Request& request) override;
  void cancel() override;
  bool isRunning() const override;
  bool isQueued() const;
  bool hasResult() const override;
  vtkTable* sliceTable() const override;
  QString createSliceTransforms(const QString& folder, QString* error) override;
  innergs::ui::ModelInfo modelInfo(const QString& id) const override;
  vtkInnerGSModel* model(const QString& id) const override;
  vtkSmartPointer<vtkAbstractTransform> toModel(const QString& id) const override;
  std::shared_ptr<const innergs::ui::UncertaintyVolume> uncertaintyOf(const QString& id) const override;
  QString onlyModel() const override;
  QString loadModel(const QString& file, QString* error) override;
  QString saveModel(const QString& id, const QString& file) override;
  QString showEllipsoids(const QString& id, bool shown) override;
  QString addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                    QString* error) override;
  QString addVolumeOf(const QString& modelId, const std::array<double, 2>& window, vtkImageData* image,
                      vtkMatrix4x4* ijkToRAS, const QString& name, QString* error) override;
  std::function<innergs::NamedLabels(const std::stop_token&)>
  labelsFor(const QString& modelId, const QString& labelsId, const QString& names, QString* error) override;
  QString setFeatures(const QString& modelId,
                      const std::shared_ptr<const innergs::FeatureModel>& features) override;
  void previewSegments(const QString& modelId, const innergs::MadeSegments& made) override;
  QString addSegments(const QString& modelId, const innergs::MadeSegments& made, QString* error) override;
  innergs::ui::MotionHost* motion() override;
  QString folder() const override;
  QString recoveryFolder() const override;
  void setFolder(const QString& folder) override;

Q_SIGNALS:
  void mrmlSceneChanged(vtkMRMLScene* scene);

private:
  void onJob(vtkObject* caller, unsigned long event, void* job);
  void onScene(vtkObject* caller, unsigned long event, void* node);
  void onModel(vtkObject* caller, unsigned long event, void* data);
  void watchModels();
  void watchChosen();
  void onParameters(vtkObject* caller, unsigned long event, void* data);
  void onChosen(vtkObject* caller, unsigned long event, void* data);
  QString whyEnded(vtkSlicerInnerGSJob* job) const;
  void run(const std::function<std::function<void()>()>& work);
  QString runAndWait(const std::function<void()>& work);
  void fitRegion(vtkMRMLNode* region);
  QString lastError() const;

  vtkWeakPointer<vtkSlicerInnerGSLogic> logic_;
  vtkWeakPointer<vtkMRMLScene> scene_;
  vtkWeakPointer<vtkMRMLInnerGSParameterNode> parameters_;
  vtkSmartPointer<vtkSlicerInnerGSJob> job_; // started here and not done
  ScopedObservers logicObservers_, sceneObservers_, modelObservers_, chosenObservers_;
  vtkWeakPointer<vtkMRMLNode> watched_, watchedRegion_; // chosenObservers_ are of these
  std::vector<vtkWeakPointer<vtkMRMLNode>> watchedMasks_;
  QTimer changed_;      // one signal for many changes of the scene
  QTimer modelsMoved_;  // one for many moves of a transform
  QTimer chosenEdited_; // a mask or the region
  bool active_ = false;
  innergs::ui::ForecastCache forecasts_;
  EllipsoidNodes* ellipsoids_;
  VolumeObserver* volumeObserver_;
  qSlicerInnerGSMotionHost* motion_;
  QSet<QString> remade_;                // IDs of models that have been replaced
  QThreadPool threads_;                 // ends before the rest is destroyed
  std::optional<innergs::Phase> phase_; // of the log's last line
  std::string deviceNote_;
  bool cancelling_ = false;                         // by the panel
  vtkWeakPointer<vtkMRMLSegmentationNode> preview_; // of segments; not saved with the scene
  /// A model's transform: what toModel() gives.
  struct Place {
    vtkWeakPointer<vtkMRMLTransformNode> parent;
    vtkMTimeType changed = 0;
    vtkSmartPointer<vtkAbstractTransform> toModel;
    QString problem; // why there is none, a sentence
  };
  const Place& placeOf(vtkMRMLInnerGSModelNode* node) const;
  mutable QMap<QString, Place> places_;
};
