#pragma once
#include <QResizeEvent>
#include <QSizePolicy>

#include <utility>

namespace innergs::ui {

/// A widget that takes the given width and the height needed for it (Base::heightForWidth), which is also its
/// minimum height: not every container above a panel supports height for width.
template <class Base>
class HeightForWidth : public Base {
public:
  template <class... Arguments>
  explicit HeightForWidth(Arguments&&... arguments) : Base(std::forward<Arguments>(arguments)...) {
    QSizePolicy policy(QSizePolicy::Ignored, QSizePolicy::Preferred);
    policy.setHeightForWidth(true);
    this->setSizePolicy(policy);
  }
  QSize sizeHint() const override { return minimumSizeHint(); }
  QSize minimumSizeHint() const override {
    const bool placed = this->testAttribute(Qt::WA_Resized);
    return {0, placed ? this->heightForWidth(this->width()) : this->fontMetrics().height()};
  }

protected:
  void resizeEvent(QResizeEvent* event) override {
    Base::resizeEvent(event);
    if (event->oldSize().width() != this->width()) this->updateGeometry();
  }
};

} // namespace innergs::ui
