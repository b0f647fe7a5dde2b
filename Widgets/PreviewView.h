#pragma once
#include "Widgets/HeightForWidth.h"

#include <QImage>
#include <QSizeF>
#include <QWidget>

#include <array>

class vtkImageData;
class vtkMatrix4x4;

namespace innergs::ui {

/// The middle axial, coronal and sagittal slice of an image in radiological orientation (patient's right on
/// the left), at one scale in mm.
class PreviewView : public HeightForWidth<QWidget> {
  Q_OBJECT
public:
  explicit PreviewView(QWidget* parent = nullptr);
  /// Copies the data that it shows; ijkToRAS null: the identity.
  void setImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS);
  void clear();
  bool isEmpty() const { return planes_[0].image.isNull(); }

  int heightForWidth(int width) const override;

protected:
  void paintEvent(QPaintEvent* event) override;

private:
  struct PlanePicture {
    QImage image;
    QSizeF size; // mm
  };
  /// Pixels per mm at which all planes fit side by side.
  double scale(int width) const;

  std::array<PlanePicture, 3> planes_;
};

} // namespace innergs::ui
