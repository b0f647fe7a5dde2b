#pragma once
#include "Widgets/App/SliceView.h"

class QDoubleSpinBox;
class QSlider;

namespace innergs::app {

/// A slice view with its slider and position.
class SlicePane : public QWidget {
  Q_OBJECT
public:
  SlicePane(ViewState* state, int axis, QWidget* parent = nullptr);
  SliceView* view() const { return view_; }
  /// Width of the frame around the view with the keyboard focus, pixels.
  static int frameWidth(const QWidget* widget);

private:
  void showRange();
  void showPosition();
  ViewState* state_;
  SliceView* view_;
  QSlider* slider_;
  QDoubleSpinBox* position_;
};

} // namespace innergs::app
