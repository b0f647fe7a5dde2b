#pragma once
#include "Core/Render/PlaneBudget.h"
#include "Widgets/Host.h"
#include "Widgets/PlaneWorker.h"

#include <QTimer>

#include <vtkNew.h>
#include <vtkSmartPointer.h>

class QCheckBox;
class QDoubleSpinBox;
class QLabel;
class QPushButton;
class QToolButton;

namespace innergs::ui {

class MessageLine;
class PlaneExport;
class PlaneView;
class ValueSlider;
struct ModelPlane;

/// Shows a model on any plane, set by orientation, position and angles or by the handles on the image. The
/// plane can be added to the host's volumes or saved as a picture.
///
/// While it moves, planes are computed on a separate thread, the latest one first; if one would take longer
/// than 16 ms, with larger pixels until the movement ends.
class QueryPanel : public QWidget {
  Q_OBJECT
public:
  explicit QueryPanel(Host* host, QWidget* parent = nullptr);
  ~QueryPanel() override;

  QString modelId() const { return modelId_; }
  void setModelId(const QString& id);
  /// Like a slice node's SliceToRAS; one that spans no plane is rejected with a sentence in the panel. From
  /// then on only users move the plane, and a new model does not reset it.
  void setPlane(vtkMatrix4x4* planeToRAS);
  /// Unit columns: right, up, normal; the origin is the centre of the view. Owned by the panel.
  vtkMatrix4x4* planeToRAS() const;

Q_SIGNALS:
  void planeChanged(vtkMatrix4x4* planeToRAS);
  void modelIdChanged(const QString& id);
  /// The picture that the panel now shows, with its position; without an image: nothing.
  void pictureChanged(const innergs::ui::PlaneImage& picture);
  /// The intensities shown as black and white, scanner units.
  void windowChanged(double lower, double upper);

protected:
  void showEvent(QShowEvent* event) override;

private:
  void build();
  void connectAll();
  void updateModel();
  void setPose(const PlanePose& pose, bool settled = false);
  void edited(const PlanePose& pose);
  void showPose();
  void home();
  void showWindow();
  /// Window and level that suit what is shown.
  void resetWindow();
  bool showsUncertainty() const;
  PlaneTask taskWithoutPixels() const;
  PlaneTask taskFor(double pixelSize) const;
  ModelPlane shownPlane() const;
  void query(bool moving);
  void settle();
  void probe(const QPointF& planePoint);
  /// Shows the value under the mouse, or at the centre while the view has the keyboard focus.
  void probeShown();
  void showProbe(const PlaneImage& point);
  void clearReadout();
  void showImage(const PlaneImage& image);

  Host* host_;
  QString modelId_;
  std::shared_ptr<const Model> model_;
  vtkSmartPointer<vtkAbstractTransform> toModel_;
  std::shared_ptr<const UncertaintyVolume> uncertainty_; // of the model; null: unknown
  ModelInfo info_;
  PlanePose pose_;
  vtkNew<vtkMatrix4x4> matrix_;
  bool placed_ = false; // by setPlane() or for a model
  bool linked_ = false; // another view shares the plane
  bool dragging_ = false;
  bool coarse_ = false;    // the last request is coarser than it should stay
  bool waiting_ = false;   // until the panel is visible
  PlaneBudget budget_{16}; // ms, while the plane moves
  QTimer settle_{this};

  Selector* selector_ = nullptr;
  QWidget* controls_ = nullptr;
  QToolButton *orientations_[3] = {}, *copyCommand_ = nullptr;
  QPushButton *home_ = nullptr, *autoWindow_ = nullptr, *exportVolume_ = nullptr, *savePicture_ = nullptr;
  ValueSlider *position_ = nullptr, *tiltUp_ = nullptr, *tiltSide_ = nullptr, *inPlane_ = nullptr;
  QDoubleSpinBox *pixelSize_ = nullptr, *window_ = nullptr, *level_ = nullptr;
  QCheckBox *handles_ = nullptr, *showUncertainty_ = nullptr;
  QLabel *size_ = nullptr, *readout_ = nullptr;
  MessageLine* message_ = nullptr;
  PlaneView* view_ = nullptr;
  PlaneWorker* worker_ = nullptr;
  PlaneExport* export_ = nullptr;
};

} // namespace innergs::ui
