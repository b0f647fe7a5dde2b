#include "Widgets/App/ViewGrid.h"

#include <QApplication>
#include <QGridLayout>
#include <QPainter>

namespace innergs::app {

ViewGrid::ViewGrid(ViewState* state, QWidget* parent)
    : QWidget(parent), threeD_(new ThreeDView(state, this)) {
  for (int axis = 0; axis < 3; ++axis) {
    panes_[axis] = new SlicePane(state, axis, this);
    connect(panes_[axis]->view(), &SliceView::pointed, this, &ViewGrid::pointed);
    static constexpr Layout alone[] = {Layout::Sagittal, Layout::Coronal, Layout::Axial};
    connect(panes_[axis]->view(), &SliceView::doubleClicked, this,
            [this, axis] { setLayoutShown(layout_ == alone[axis] ? Layout::All : alone[axis]); });
  }
  connect(threeD_, &ThreeDView::doubleClicked, this,
          [this] { setLayoutShown(layout_ == Layout::ThreeD ? Layout::All : Layout::ThreeD); });
  auto* grid = new QGridLayout(this);
  const int frame = SlicePane::frameWidth(this);
  grid->setContentsMargins(frame, frame, frame, frame);
  grid->setSpacing(frame);
  grid->addWidget(panes_[2], 0, 0);
  grid->addWidget(threeD_, 0, 1);
  grid->addWidget(panes_[1], 1, 0);
  grid->addWidget(panes_[0], 1, 1);
  for (int n = 0; n < 2; ++n) {
    grid->setRowStretch(n, 1);
    grid->setColumnStretch(n, 1);
  }
  connect(qApp, &QApplication::focusChanged, this, QOverload<>::of(&QWidget::update));
  const int least = 12 * fontMetrics().height();
  setMinimumSize(least, least);
}

void ViewGrid::paintEvent(QPaintEvent*) {
  const QWidget* views[] = {panes_[0]->view(), panes_[1]->view(), panes_[2]->view(), threeD_};
  for (const QWidget* view : views) {
    if (!view->hasFocus()) continue;
    const int frame = SlicePane::frameWidth(this);
    const QRect around(view->mapTo(this, QPoint(0, 0)), view->size());
    QPainter(this).fillRect(around.adjusted(-frame, -frame, frame, frame),
                            palette().color(QPalette::Highlight));
  }
}

void ViewGrid::setLayoutShown(Layout layout) {
  layout_ = layout;
  auto* grid = static_cast<QGridLayout*>(QWidget::layout());
  const bool all = layout == Layout::All;
  const bool shown[] = {all || layout == Layout::Sagittal, all || layout == Layout::Coronal,
                        all || layout == Layout::Axial};
  for (int axis = 0; axis < 3; ++axis)
    panes_[axis]->setVisible(shown[axis]);
  const bool space = all || layout == Layout::ThreeD;
  threeD_->setVisible(space);
  grid->setColumnStretch(0, shown[2] || shown[1]);
  grid->setColumnStretch(1, shown[0] || space);
  grid->setRowStretch(0, shown[2] || space);
  grid->setRowStretch(1, shown[0] || shown[1]);
  Q_EMIT layoutChanged();
}

void ViewGrid::fit() {
  for (SlicePane* pane : panes_)
    pane->view()->fit();
  threeD_->fit();
}

} // namespace innergs::app
