#include "Widgets/PinnedRow.h"

#include "Widgets/PanelTools.h"

#include <QApplication>
#include <QEvent>
#include <QPainter>
#include <QScrollArea>
#include <QScrollBar>
#include <QVBoxLayout>

#include <algorithm>
#include <utility>

namespace innergs::ui {
namespace {

/// The visible part of a widget, in its own coordinates.
QRect seenPart(const QWidget* widget) {
  QRect seen = widget->rect();
  QPoint at;
  for (const QWidget* w = widget; !w->isWindow() && w->parentWidget(); w = w->parentWidget()) {
    at += w->pos();
    seen &= w->parentWidget()->rect().translated(-at);
  }
  return seen;
}

} // namespace

/// Opaque, with a line where it covers the panel.
class PinnedRow::Bar : public QWidget {
public:
  explicit Bar(QWidget* parent) : QWidget(parent) {
    setObjectName("pinnedBar");
    setAutoFillBackground(true);
    layoutWithoutMargins<QVBoxLayout>(this);
  }
  enum class Line { None, Above, Below };
  void setLine(Line line) {
    if (std::exchange(line_, line) != line) update();
  }

protected:
  void paintEvent(QPaintEvent*) override {
    if (line_ == Line::None) return;
    QPainter painter(this);
    painter.setPen(palette().color(QPalette::Mid));
    const int y = line_ == Line::Above ? 0 : height() - 1;
    painter.drawLine(0, y, width() - 1, y);
  }

private:
  Line line_ = Line::None;
};

PinnedRow::PinnedRow(QWidget* panel) : QWidget(panel), panel_(panel), bar_(new Bar(panel)) {
  QSizePolicy policy(QSizePolicy::Preferred, QSizePolicy::Fixed);
  policy.setHeightForWidth(true);
  setSizePolicy(policy);
  bar_->installEventFilter(this);
  connect(qApp, &QApplication::focusChanged, this, [this](QWidget*, QWidget* now) { uncover(now); });
}

PinnedRow::~PinnedRow() {
  delete bar_;
}

void PinnedRow::setContent(QWidget* content) {
  bar_->layout()->addWidget(content);
}

void PinnedRow::setPinnedAtTop(bool pinned) {
  atTop_ = pinned;
  place();
}

QSize PinnedRow::sizeHint() const {
  return bar_->sizeHint();
}

QSize PinnedRow::minimumSizeHint() const {
  return bar_->minimumSizeHint();
}

bool PinnedRow::hasHeightForWidth() const {
  return bar_->hasHeightForWidth();
}

int PinnedRow::heightForWidth(int width) const {
  return bar_->heightForWidth(width);
}

void PinnedRow::watchAncestors() {
  for (const QPointer<QWidget>& widget : std::as_const(watched_))
    if (widget) widget->removeEventFilter(this);
  watched_.clear();
  for (QWidget* w = parentWidget(); w; w = w->isWindow() ? nullptr : w->parentWidget()) {
    w->installEventFilter(this);
    watched_ << w;
  }
}

bool PinnedRow::eventFilter(QObject* watched, QEvent* event) {
  switch (event->type()) {
  case QEvent::LayoutRequest:
    if (watched == bar_) updateGeometry();
    break;
  case QEvent::ParentChange:
    watchAncestors();
    place();
    break;
  case QEvent::Move: // scrolled
  case QEvent::Resize:
    if (watched != bar_) place();
    break;
  default:
    break;
  }
  return false;
}

void PinnedRow::place() {
  if (!bar_ || !isVisible()) return;
  const QRect own(mapTo(panel_, QPoint(0, 0)), size()), seen = seenPart(panel_);
  int y = own.y();
  if (!seen.isEmpty()) {
    y = std::max(std::min(y, seen.bottom() + 1 - own.height()), std::min(y, seen.top()));
    if (atTop_) y = std::max(y, seen.top());
    y = std::clamp(y, 0, std::max(0, panel_->height() - own.height()));
  }
  bar_->setGeometry(own.x(), y, own.width(), own.height());
  bar_->raise();
  static_cast<Bar*>(bar_.data())
      ->setLine(y < own.y()   ? Bar::Line::Above
                : y > own.y() ? Bar::Line::Below
                              : Bar::Line::None);
}

/// Scrolls a newly focused widget out from under the row where the areas alone would not.
void PinnedRow::uncover(QWidget* focused) {
  if (!focused || !isVisible() || !panel_->isAncestorOf(focused) || bar_->isAncestorOf(focused)) return;
  const QRect at(focused->mapTo(panel_, QPoint(0, 0)), focused->size()), bar = bar_->geometry();
  const int place = mapTo(panel_, QPoint(0, 0)).y(), gap = fontMetrics().height() / 2;
  int by = 0;
  if (bar.y() < place) by = std::max(0, at.bottom() + gap - bar.top());
  if (bar.y() > place) by = std::min(0, at.top() - gap - bar.bottom());
  for (QWidget* above = panel_->parentWidget(); above && by != 0; above = above->parentWidget())
    if (auto* area = qobject_cast<QScrollArea*>(above)) {
      area->verticalScrollBar()->setValue(area->verticalScrollBar()->value() + by);
      return;
    }
}

void PinnedRow::moveEvent(QMoveEvent* event) {
  QWidget::moveEvent(event);
  place();
}

void PinnedRow::resizeEvent(QResizeEvent* event) {
  QWidget::resizeEvent(event);
  place();
}

void PinnedRow::showEvent(QShowEvent* event) {
  QWidget::showEvent(event);
  watchAncestors();
  bar_->show();
  place();
}

void PinnedRow::hideEvent(QHideEvent* event) {
  QWidget::hideEvent(event);
  if (bar_ && isHidden()) bar_->hide();
}

} // namespace innergs::ui
