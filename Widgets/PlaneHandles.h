#pragma once
#include <QPointF>
#include <QSizeF>
#include <QString>

#include <optional>
#include <utility>

class QPainter;
class QPalette;

namespace innergs::ui {

/// The handles of a plane.
enum class PlaneHandle {
  None,
  Move,           // in the centre: along the normal, by dragging up and down
  TiltHorizontal, // above and below: about the view's horizontal axis
  TiltVertical,   // left and right: about the view's vertical axis
  Turn            // on the diagonals: within the plane
};

/// Positions of the handles in a view (pixels of the widget, y down), sized by its font.
class PlaneHandles {
public:
  PlaneHandles(const QSizeF& view, double fontHeight);

  bool fit() const { return radius_ >= 2.5 * unit_; } // false: the view is too small for them
  QPointF centre() const { return centre_; }
  double radius() const { return radius_; } // from the centre to the others
  PlaneHandle at(const QPointF& point) const;
  /// turned: degrees counter-clockwise that the diagonal handles have followed a drag.
  void paint(QPainter& painter, const QPalette& palette, PlaneHandle hot, double turned = 0) const;

private:
  QPointF centre_;
  double radius_, unit_;
};

/// One line on what dragging it does.
QString hintOf(PlaneHandle handle);

} // namespace innergs::ui
