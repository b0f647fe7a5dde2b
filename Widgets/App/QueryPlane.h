#pragma once
#include <memory>

class vtkRenderer;

namespace innergs::ui {
struct PlaneImage;
}

namespace innergs::app {

/// The query panel's picture at its position in space (RAS mm), with an outline; initially hidden.
class QueryPlane {
public:
  explicit QueryPlane(vtkRenderer* renderer);
  ~QueryPlane();

  /// Without an image, shows none.
  void setPicture(const ui::PlaneImage& picture);
  /// Black and white, scanner units.
  void setWindow(double lower, double upper);
  void setShown(bool shown);

private:
  void show();
  bool shown_ = false, any_ = false;
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

} // namespace innergs::app
