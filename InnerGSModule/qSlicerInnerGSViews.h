#pragma once
#include <QObject>

#include <vtkWeakPointer.h>

class vtkMatrix4x4;
class vtkMRMLInnerGSModelNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLScene;
class vtkMRMLSliceCompositeNode;
class vtkMRMLSliceNode;
class vtkObject;
class vtkSlicerApplicationLogic;
class vtkSlicerInnerGSLogic;

/// The application's slice and 3D views: results shown there, and a slice view that shares its plane with the
/// query panel.
class qSlicerInnerGSViews : public QObject {
  Q_OBJECT
public:
  qSlicerInnerGSViews(vtkSlicerInnerGSLogic* logic, vtkSlicerApplicationLogic* application, QObject* parent);
  ~qSlicerInnerGSViews() override;

  /// Puts it in the background of all slice views, which stay where they are.
  void showInSlices(vtkMRMLScalarVolumeNode* volume);
  /// Volume rendering; "" or a sentence.
  QString showIn3D(vtkMRMLScalarVolumeNode* volume, bool shown);
  static bool isShownIn3D(vtkMRMLScalarVolumeNode* volume);
  /// Frames on it those 3D views that nobody has turned or moved.
  static void frameIn3D(vtkMRMLScalarVolumeNode* volume);

  ///@{
  /// The linked slice view; null: none.
  void link(vtkMRMLSliceNode* slice);
  vtkMRMLSliceNode* linked() const;
  void setPlane(vtkMatrix4x4* planeToRAS);
  /// The model's plane as the linked view's background; null model: what was there before. "" or a sentence.
  QString showModel(vtkMRMLInnerGSModelNode* model);
  /// The slice view that shows a model according to the scene, and that model; null if none does.
  vtkMRMLSliceNode* remembered(vtkMRMLInnerGSModelNode** model) const;
  ///@}

Q_SIGNALS:
  void planeChanged(vtkMatrix4x4* planeToRAS);

private:
  void onSlice(vtkObject* caller, unsigned long event, void* data);
  vtkMRMLSliceCompositeNode* layersOf(vtkMRMLSliceNode* slice) const;

  vtkWeakPointer<vtkSlicerInnerGSLogic> logic_;
  vtkWeakPointer<vtkSlicerApplicationLogic> application_;
  vtkWeakPointer<vtkMRMLSliceNode> slice_;
  vtkWeakPointer<vtkMRMLScalarVolumeNode> followed_;
  unsigned long tag_ = 0;
  bool moving_ = false;
  QString background_; // before the model was shown
};
