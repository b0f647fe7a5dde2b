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

/// Shows the Gaussians of models as surfaces in model nodes next to them: a few thousand each, as more would
/// stall 3D views.
class EllipsoidNodes : public QObject {
  Q_OBJECT
public:
  /// Runs its argument on a thread, then the function that it returns on this one.
  using Run = std::function<void(const std::function<std::function<void()>()>&)>;
  EllipsoidNodes(Run run, QObject* parent) : QObject(parent), run_(std::move(run)) {}

  void setMRMLScene(vtkMRMLScene* scene);
  /// Creates them on a thread.
  void show(vtkMRMLInnerGSModelNode* model);
  void hide(vtkMRMLInnerGSModelNode* model);
  bool areShown(vtkMRMLInnerGSModelNode* model) const;
  /// Whether they are being created.
  bool arePending(const QString& modelId) const { return pending_.contains(modelId); }
  /// Moves them to the model's position.
  void place(vtkMRMLInnerGSModelNode* model);
  /// Remembers those of a model that is being removed, which no panel could hide afterwards.
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
