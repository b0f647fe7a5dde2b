#pragma once
#include <QPointer>
#include <QVector>
#include <QWidget>

namespace innergs::ui {

/// A row of a panel that stays visible: when scrolled out of sight, it covers the panel at the lower edge of
/// the surrounding scroll areas.
class PinnedRow : public QWidget {
  Q_OBJECT
public:
  /// panel: its parent or an ancestor, whose area it does not leave.
  explicit PinnedRow(QWidget* panel);
  ~PinnedRow() override;
  /// Sets its content, once; the panel owns it.
  void setContent(QWidget* content);
  /// Whether it also stays at the upper edge.
  void setPinnedAtTop(bool pinned);

  QSize sizeHint() const override;
  QSize minimumSizeHint() const override;
  bool hasHeightForWidth() const override;
  int heightForWidth(int width) const override;
  bool eventFilter(QObject* watched, QEvent* event) override;

protected:
  void moveEvent(QMoveEvent* event) override;
  void resizeEvent(QResizeEvent* event) override;
  void showEvent(QShowEvent* event) override;
  void hideEvent(QHideEvent* event) override;

private:
  class Bar;
  void watchAncestors();
  void place();
  void uncover(QWidget* focused);

  QWidget* panel_;
  QPointer<QWidget> bar_; // a Bar
  QVector<QPointer<QWidget>> watched_;
  bool atTop_ = false;
};

} // namespace innergs::ui
