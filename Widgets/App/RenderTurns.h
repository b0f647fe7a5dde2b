#pragma once
#include <QObject>
#include <QPointer>

#include <deque>
#include <functional>
#include <utility>

namespace innergs::app {

/// Draws one view in each turn of the event loop: all in one turn hold it as long as all of them take.
class RenderTurns : public QObject {
  Q_OBJECT
public:
  using QObject::QObject;
  /// Calls `draw` in a turn of its own, once for many calls, and not when the view is gone by then.
  void add(QObject* view, std::function<void()> draw);
  /// Whether no view waits to be drawn.
  bool isIdle() const { return waiting_.empty(); }

private:
  void wait();
  void next();
  std::deque<std::pair<QPointer<QObject>, std::function<void()>>> waiting_;
};

} // namespace innergs::app
