#include "Widgets/App/RenderTurns.h"

#include <QTimer>

#include <algorithm>

namespace innergs::app {

void RenderTurns::add(QObject* view, std::function<void()> draw) {
  if (std::any_of(waiting_.begin(), waiting_.end(), [view](const auto& one) { return one.first == view; }))
    return;
  waiting_.emplace_back(view, std::move(draw));
  if (waiting_.size() == 1) wait();
}

void RenderTurns::wait() {
  QTimer::singleShot(0, this, &RenderTurns::next);
}

void RenderTurns::next() {
  const auto [view, draw] = std::move(waiting_.front());
  waiting_.pop_front();
  if (!waiting_.empty()) wait();
  if (view) draw();
}

} // namespace innergs::app
