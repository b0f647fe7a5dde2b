#include "Widgets/PlaneHandles.h"

#include <QCoreApplication>
#include <QPainter>
#include <QPainterPath>
#include <QPalette>

#include <algorithm>
#include <cmath>

namespace innergs::ui {

namespace {

constexpr double arcHalf = 14; // degrees that a diagonal handle extends to either side

double lengthOf(const QPointF& p) {
  return std::hypot(p.x(), p.y());
}

/// A triangle pointing along `direction`, with its centre at `at`.
QPolygonF arrowHead(const QPointF& at, const QPointF& direction, double size) {
  const QPointF across(-direction.y(), direction.x());
  QPolygonF triangle;
  triangle << at + size * direction << at - 0.6 * size * direction + 0.8 * size * across
           << at - 0.6 * size * direction - 0.8 * size * across;
  return triangle;
}

void stroke(QPainter& painter, const QPainterPath& path, const QColor& colour, double width, bool filled) {
  painter.setPen(QPen(QColor(0, 0, 0, 160), width + 2, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin));
  painter.setBrush(Qt::NoBrush);
  painter.drawPath(path);
  painter.setPen(QPen(colour, width, Qt::SolidLine, Qt::RoundCap, Qt::RoundJoin));
  if (filled) painter.setBrush(colour);
  painter.drawPath(path);
}

} // namespace

PlaneHandles::PlaneHandles(const QSizeF& view, double fontHeight)
    : centre_(0.5 * view.width(), 0.5 * view.height()),
      radius_(std::min(0.5 * view.width() - 3.6 * fontHeight, 0.5 * view.height() - 2.9 * fontHeight)),
      unit_(fontHeight) {}

PlaneHandle PlaneHandles::at(const QPointF& point) const {
  if (!fit()) return PlaneHandle::None;
  const QPointF p = point - centre_;
  const double reach = 0.8 * unit_;
  if (lengthOf(p) <= reach) return PlaneHandle::Move;
  if (lengthOf({std::abs(p.x()) - radius_, p.y()}) <= reach) return PlaneHandle::TiltVertical;
  if (lengthOf({p.x(), std::abs(p.y()) - radius_}) <= reach) return PlaneHandle::TiltHorizontal;
  if (std::abs(lengthOf(p) - radius_) > 0.6 * unit_) return PlaneHandle::None;
  const double angle = std::atan2(std::abs(p.y()), std::abs(p.x())) * 180 / 3.14159265358979;
  return std::abs(angle - 45) <= arcHalf + 4 ? PlaneHandle::Turn : PlaneHandle::None;
}

void PlaneHandles::paint(QPainter& painter, const QPalette& palette, PlaneHandle hot, double turned) const {
  if (!fit()) return;
  painter.save();
  painter.setRenderHint(QPainter::Antialiasing);
  const auto colour = [&](PlaneHandle handle) {
    QColor c = palette.color(QPalette::Active, QPalette::Highlight).lighter(handle == hot ? 160 : 130);
    c.setAlpha(handle == hot ? 255 : 170);
    return c;
  };
  const double width = std::max(1.5, unit_ / 9), head = 0.32 * unit_;

  QPainterPath move; // a double arrow up and down
  move.addPolygon(arrowHead(centre_ + QPointF(0, -0.55 * unit_), {0, -1}, head));
  move.closeSubpath();
  move.addPolygon(arrowHead(centre_ + QPointF(0, 0.55 * unit_), {0, 1}, head));
  move.closeSubpath();
  move.addEllipse(centre_, 0.12 * unit_, 0.12 * unit_);
  stroke(painter, move, colour(PlaneHandle::Move), 1, true);

  for (const double side : {-1., 1.}) {
    const QPointF right(side * radius_, 0), up(0, side * radius_);
    QPainterPath vertical, horizontal;
    vertical.addEllipse(centre_ + right, head, head);
    stroke(painter, vertical, colour(PlaneHandle::TiltVertical), 1, true);
    horizontal.addEllipse(centre_ + up, head, head);
    stroke(painter, horizontal, colour(PlaneHandle::TiltHorizontal), 1, true);
    // The ticks show how the handles move; the axes they tilt about belong to the other pair.
    QPainterPath ticks;
    for (const double way : {-1., 1.}) {
      ticks.addPolygon(arrowHead(centre_ + right + QPointF(way * 0.75 * unit_, 0), {way, 0}, 0.55 * head));
      ticks.closeSubpath();
    }
    stroke(painter, ticks, colour(PlaneHandle::TiltVertical), 0.5, true);
    ticks.clear();
    for (const double way : {-1., 1.}) {
      ticks.addPolygon(arrowHead(centre_ + up + QPointF(0, way * 0.75 * unit_), {0, way}, 0.55 * head));
      ticks.closeSubpath();
    }
    stroke(painter, ticks, colour(PlaneHandle::TiltHorizontal), 0.5, true);
  }
  for (int quarter = 0; quarter < 4; ++quarter) {
    const QRectF box(centre_ - QPointF(radius_, radius_), QSizeF(2 * radius_, 2 * radius_));
    QPainterPath arc;
    const double from = 45 + 90 * quarter + turned - arcHalf;
    arc.arcMoveTo(box, from);
    arc.arcTo(box, from, 2 * arcHalf);
    stroke(painter, arc, colour(PlaneHandle::Turn), width * 1.6, false);
  }
  painter.restore();
}

QString hintOf(PlaneHandle handle) {
  static const char* const hints[] = {
      "", QT_TRANSLATE_NOOP("innergs::ui::PlaneHandles", "Drag up or down: move along the normal"),
      QT_TRANSLATE_NOOP("innergs::ui::PlaneHandles", "Drag up or down: tilt about the horizontal axis"),
      QT_TRANSLATE_NOOP("innergs::ui::PlaneHandles", "Drag left or right: tilt about the vertical axis"),
      QT_TRANSLATE_NOOP("innergs::ui::PlaneHandles", "Drag around: turn in the plane")};
  if (handle == PlaneHandle::None) return {};
  return QCoreApplication::translate("innergs::ui::PlaneHandles", hints[static_cast<int>(handle)]);
}

} // namespace innergs::ui
