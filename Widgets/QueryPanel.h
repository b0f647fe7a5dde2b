#pragma once
#include "Widgets/Host.h"
#include "Widgets/PlaneWorker.h"

#include <QStringList>
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
class PlaneView;
class ValueSlider;

/// Looks at a model on any plane: by orientation, position and angles, or by the handles on the image. The
/// plane can be put among the host's volumes or saved as a picture.
///
/// While it is moved, planes are computed on a thread of their own, the latest one first; where one would
/// take longer than 16 ms, with larger pixels until the movement ends.
class QueryPanel : public QWidget {
  Q_OBJECT
public:
  explicit QueryPanel(Host* host, QWidget* parent = nullptr);
  ~QueryPanel() override;

  QString modelId() const { return modelId_; }
  void setModelId(const QString& id);
  /// As a slice node's SliceToRAS; one that spans no plane is refused with a sentence in the panel. From then
  /// on the plane is moved by people alone, never to a new model.
  void setPlane(vtkMatrix4x4* planeToRAS);
  /// Unit columns: right, up, normal; origin in the middle of the view. Owned by the panel.
  vtkMatrix4x4* planeToRAS() const;

Q_SIGNALS:
  void planeChanged(vtkMatrix4x4* planeToRAS);
  void modelIdChanged(const QString& id);
  /// What the panel shows now, where it lies; without an image: nothing.
  void pictureChanged(const innergs::ui::PlaneImage& picture);
  /// What is black and white in it, scanner units.
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
  PlaneTask taskFor(double pixelSize) const;
  void query(bool moving);
  void settle();
  void probe(const QPointF& planePoint);
  /// Under the mouse, or in the middle while the view has the keyboard.
  void probeShown();
  void showProbe(const PlaneImage& point);
  void clearReadout();
  void showImage(const PlaneImage& image);
  void exportPlane(const QString& file);
  void finishExport(const PlaneImage& image);
  void choosePictureFile();
  void copyCommand();
  QString planeName() const;
  void say(const QString& message, bool error = false);

  Host* host_;
  QString modelId_;
  std::shared_ptr<const Model> model_;
  vtkSmartPointer<vtkAbstractTransform> toModel_;
  ModelInfo info_;
  PlanePose pose_;
  vtkNew<vtkMatrix4x4> matrix_;
  bool placed_ = false; // by setPlane() or for a model
  bool linked_ = false; // the plane is another view's as well
  bool dragging_ = false;
  bool coarse_ = false;   // what was asked for last is coarser than it should stay
  bool waiting_ = false;  // for the panel to be seen
  double msPerPixel_ = 0; // of the last query
  QTimer settle_{this};
  struct Export {
    QString name, modelId;
  };
  QList<Export> exports_; // in the order of the worker's

  Selector* selector_ = nullptr;
  QWidget* controls_ = nullptr;
  QToolButton *orientations_[3] = {}, *copyCommand_ = nullptr;
  QPushButton *home_ = nullptr, *autoWindow_ = nullptr, *exportVolume_ = nullptr, *savePicture_ = nullptr;
  ValueSlider *position_ = nullptr, *tiltUp_ = nullptr, *tiltSide_ = nullptr, *inPlane_ = nullptr;
  QDoubleSpinBox *pixelSize_ = nullptr, *window_ = nullptr, *level_ = nullptr;
  QCheckBox* handles_ = nullptr;
  QLabel *size_ = nullptr, *readout_ = nullptr;
  MessageLine* message_ = nullptr;
  PlaneView* view_ = nullptr;
  PlaneWorker* worker_ = nullptr;
};

} // namespace innergs::ui
