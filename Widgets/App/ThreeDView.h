#pragma once
#include "Widgets/App/ViewState.h"
#include "Widgets/EllipsoidActor.h"
#include "Widgets/PlaneWorker.h"

#include <QVTKOpenGLNativeWidget.h>

#include <memory>

namespace innergs::app {

class Background;
class QueryPlane;

/// The shown volume in space: the three planes through the crosshair, optionally the whole volume, the query
/// panel's plane, and the ellipsoids of models that show them.
class ThreeDView : public QVTKOpenGLNativeWidget {
  Q_OBJECT
public:
  explicit ThreeDView(ViewState* state, QWidget* parent = nullptr);
  ~ThreeDView() override;

  bool isVolumeRendered() const { return rendered_; }
  void setVolumeRendered(bool on);
  void setPlanesShown(bool on);
  ///@{
  /// The query panel's plane; initially hidden.
  void setQueryPicture(const ui::PlaneImage& picture);
  void setQueryWindow(double lower, double upper);
  void setQueryShown(bool on);
  ///@}
  /// The whole volume from the front, with the patient's right on the left.
  void fit();
  /// The whole volume from the current direction.
  void frame();

Q_SIGNALS:
  void doubleClicked();
  /// A model's ellipsoids could not be created.
  void failed(const QString& modelId, const QString& sentence);

protected:
  void keyPressEvent(QKeyEvent* event) override;
  void mouseDoubleClickEvent(QMouseEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;

private:
  /// Pans, in heights of the view.
  void pan(double right, double up);
  void showVolume();
  void showWindow();
  void showPlanes();
  void showModels();
  void showEllipsoids(const QString& id, vtkInnerGSModel* model, vtkPolyData* centres,
                      const ui::EllipsoidOptions& options);
  void render();

  ViewState* state_;
  bool rendered_ = false, planes_ = true, fitted_ = false;
  std::array<double, 7> framed_{}; // the camera as frame() left it
  struct Scene;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<QueryPlane> query_;
  Background* background_; // makes the ellipsoids
};

} // namespace innergs::app
