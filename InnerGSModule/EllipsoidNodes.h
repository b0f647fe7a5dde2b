#pragma once
#include <vtkWeakPointer.h>

#include <QObject>
#include <QSet>

#include <array>
#include <functional>
#include <utility>
#include <vector>

class vtkMRMLInnerGSModelNode;
class vtkMRMLModelNode;
class vtkMRMLScene;
class vtkPolyData;

/// The Gaussians of models as surfaces, in model nodes beside them: a few thousand each, or 3D views would
/// stall.
class EllipsoidNodes : public QObject {
  Q_OBJECT
public:
  /// Does its argument on a thread, then on this one what that returns.
  using Run = std::function<void(const std::function<std::function<void()>()>&)>;
  EllipsoidNodes(Run run, QObject* parent) : QObject(parent), run_(std::move(run)) {}

  void setMRMLScene(vtkMRMLScene* scene);
  /// Makes them on a thread.
  void show(vtkMRMLInnerGSModelNode* model);
  void hide(vtkMRMLInnerGSModelNode* model);
  bool areShown(vtkMRMLInnerGSModelNode* model) const;
  /// Whether they are being made.
  bool arePending(const QString& modelId) const { return pending_.contains(modelId); }
  /// Puts them where the model is.
  void place(vtkMRMLInnerGSModelNode* model);
  /// Notes those of a model that is about to go, which no panel could hide then.
  void orphan(vtkMRMLInnerGSModelNode* model);
  void removeOrphans();

Q_SIGNALS:
  void changed();
  void failed(const QString& sentence);

private:
  void showSurfaces(vtkMRMLInnerGSModelNode* model, vtkPolyData* surfaces,
                    const std::array<double, 2>& window);

  Run run_;
  vtkWeakPointer<vtkMRMLScene> scene_;
  QSet<QString> pending_; // IDs of models
  std::vector<vtkWeakPointer<vtkMRMLModelNode>> orphans_;
};
