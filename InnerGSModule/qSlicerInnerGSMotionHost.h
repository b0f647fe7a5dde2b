#pragma once
#include "ScopedObservers.h"
#include "Widgets/MotionHost.h"

#include <vtkSlicerInnerGSLogic.h>

#include <vtkSmartPointer.h>
#include <vtkWeakPointer.h>

#include <QTimer>

#include <cmath>
#include <string>

class vtkMRMLInnerGSModelNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLSequenceBrowserNode;
class vtkSlicerInnerGSJob;

/// Sequences of the scene as the panel's dynamic scans. The time of a model, the volume that shows it in the
/// slice views, and the browser of its frames go together: each follows the others.
class qSlicerInnerGSMotionHost : public innergs::ui::MotionHost {
  Q_OBJECT
public:
  explicit qSlicerInnerGSMotionHost(QObject* parent = nullptr);

  void setLogic(vtkSlicerInnerGSLogic* logic);

  innergs::ui::SeriesInfo seriesInfo(const QString& id) const override;
  bool start(const innergs::ui::MotionRequest& request) override;
  void cancel() override;
  bool isRunning() const override;
  innergs::ui::MotionInfo motionInfo(const QString& modelId) const override;
  void setTime(const QString& modelId, double seconds) override;
  innergs::ui::MotionInfo previewInfo() const override;
  void setPreviewTime(double seconds) override;
  bool savesFrames() const override { return false; } // Slicer saves sequences
  QString saveFrames(const QString& modelId, double rate, const QString& file) override;

private:
  vtkMRMLInnerGSModelNode* modelNode(const QString& id) const;
  vtkMRMLSequenceBrowserNode* browserOf(vtkMRMLInnerGSModelNode* model) const;
  void onJob(vtkObject* caller, unsigned long event, void* job);
  void onBrowser(vtkObject* caller, unsigned long event, void* data);
  void watch(const QString& modelId);
  void showFrame();
  void showPreview();
  void putIntoViews(vtkMRMLScalarVolumeNode* volume, const std::string& name);
  void dropPreview();

  vtkWeakPointer<vtkSlicerInnerGSLogic> logic_;
  vtkSmartPointer<vtkSlicerInnerGSJob> job_; // started here and not done
  ScopedObservers logicObservers_, browserObservers_;
  QString watched_;   // the model whose browser is observed
  QTimer frame_;      // one frame for many times
  int selected_ = -1; // item of the browser, as last seen or chosen here
  vtkWeakPointer<vtkMRMLScalarVolumeNode> shown_;
  QString shownOf_;                                 // the model that it shows
  vtkWeakPointer<vtkMRMLScalarVolumeNode> preview_; // shows the model so far; then the model
  QTimer previewFrame_;                             // one frame for many times
  double previewTime_ = NAN;                        // s
  QString scan_;                                    // name of the one that is fitted
};
