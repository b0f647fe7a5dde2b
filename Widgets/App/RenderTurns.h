#pragma once
#include <QObject>
#include <QPointer>

#include <deque>
#include <functional>
#include <utility>

namespace innergs::app {

/// Draws one view per turn of the event loop, as drawing all in one turn would block it for too long.
class RenderTurns : public QObject {
  Q_OBJECT
public:
  using QObject::QObject;
  /// Calls `draw` in a separate turn: once for many calls, and not after the view is deleted.
  void add(QObject* view, std::function<void()> draw);
  /// Whether no view is waiting to be drawn.
  bool isIdle() const { return waiting_.empty(); }

private:
  void wait();
  void next();
  std::deque<std::pair<QPointer<QObject>, std::function<void()>>> waiting_;
};

} // namespace innergs::app
