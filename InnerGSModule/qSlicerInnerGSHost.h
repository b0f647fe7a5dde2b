#pragma once
#include "Widgets/Host.h"

#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <QMap>
#include <QTimer>

#include <vector>

class vtkMRMLInnerGSModelNode;
class vtkMRMLInnerGSParameterNode;
class vtkMRMLNode;
class vtkMRMLScene;
class vtkObject;
class vtkSlicerInnerGSJob;
class vtkSlicerInnerGSLogic;

/// Shows the scene and the module's logic to the panels. What they ask for goes into the parameter node
/// first.
class qSlicerInnerGSHost : public innergs::ui::Host {
  Q_OBJECT
public:
  explicit qSlicerInnerGSHost(QObject* parent = nullptr);
  ~qSlicerInnerGSHost() override;

  void setLogic(vtkSlicerInnerGSLogic* logic);
  void setMRMLScene(vtkMRMLScene* scene);
  /// The set of parameters that requests are written to.
  void setParameterNode(vtkMRMLInnerGSParameterNode* node);
  vtkMRMLInnerGSParameterNode* parameterNode() const;
  /// Writes it, unless the scene is being closed or loaded.
  void store(const innergs::ui::Request& request);
  vtkMRMLInnerGSModelNode* modelNode(const QString& id) const;

  bool offers(Role role) const override;
  innergs::ui::Selector* createSelector(Role role, QWidget* parent) override;
  innergs::ui::VolumeInfo volumeInfo(const QString& id) const override;
  innergs::ui::Estimate estimate(const innergs::ui::Request& request) override;
  bool start(const innergs::ui::Request& request) override;
  void cancel() override;
  bool isRunning() const override;
  innergs::ui::ModelInfo modelInfo(const QString& id) const override;
  vtkInnerGSModel* model(const QString& id) const override;
  QString loadModel(const QString& file, QString* error) override;
  QString saveModel(const QString& id, const QString& file) override;
  QString showEllipsoids(const QString& id, bool shown) override;
  QString addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                    QString* error) override;
  QString folder() const override;
  void setFolder(const QString& folder) override;

Q_SIGNALS:
  void mrmlSceneChanged(vtkMRMLScene* scene);

private:
  void onJob(vtkObject* caller, unsigned long event, void* job);
  void onScene(vtkObject* caller, unsigned long event, void* node);
  void onModel(vtkObject* caller, unsigned long event, void* data);
  void watchModels();
  void fitRegion(vtkMRMLNode* region);
  QString lastError() const;

  struct Watch {
    vtkWeakPointer<vtkObject> object;
    unsigned long tag;
  };
  template <class Method>
  void watch(std::vector<Watch>& list, vtkObject* object, unsigned long event, Method m);
  static void unwatch(std::vector<Watch>& list);

  vtkWeakPointer<vtkSlicerInnerGSLogic> logic_;
  vtkWeakPointer<vtkMRMLScene> scene_;
  vtkWeakPointer<vtkMRMLInnerGSParameterNode> parameters_;
  vtkSmartPointer<vtkSlicerInnerGSJob> job_; // started here and not done
  std::vector<Watch> logicWatches_, sceneWatches_, modelWatches_;
  QTimer changed_; // one signal for many changes of the scene
  QString phase_;  // of the log's last line
  std::string deviceNote_;
  innergs::Progress fit_; // the last one shown
  bool judging_ = false;
  /// Models under a transform, moved to the world: what model() shows.
  struct Moved {
    vtkSmartPointer<vtkMRMLInnerGSModelNode> node;
    vtkWeakPointer<vtkInnerGSModel> from;
    std::array<double, 16> matrix;
  };
  mutable QMap<QString, Moved> moved_;
};
