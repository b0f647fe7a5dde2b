#pragma once
#include "Widgets/App/SlicePane.h"
#include "Widgets/App/ThreeDView.h"

namespace innergs::app {

/// The three slice views and the 3D view, all or a single one; the one with the keyboard focus has a frame.
class ViewGrid : public QWidget {
  Q_OBJECT
public:
  enum class Layout { All, Axial, Coronal, Sagittal, ThreeD };
  explicit ViewGrid(ViewState* state, QWidget* parent = nullptr);

  Layout layoutShown() const { return layout_; }
  void setLayoutShown(Layout layout);
  SliceView* slice(int axis) const { return panes_[axis]->view(); }
  ThreeDView* threeD() const { return threeD_; }
  /// Fits the whole volume into every view.
  void fit();

Q_SIGNALS:
  void layoutChanged();
  void pointed(const QString& text);

protected:
  void paintEvent(QPaintEvent* event) override;

private:
  std::array<SlicePane*, 3> panes_{};
  ThreeDView* threeD_;
  Layout layout_ = Layout::All;
};

} // namespace innergs::app
