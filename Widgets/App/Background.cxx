#include "Widgets/App/Background.h"

#include "Core/Base/Failure.h"

#include <QEventLoop>
#include <QMetaObject>
#include <QString>

#include <utility>

namespace innergs::app {

Background::Background(QObject* parent) : QObject(parent) {}

Background::~Background() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  toDo_.notify_one();
  if (thread_.joinable()) thread_.join();
}

void Background::run(const QString& text, Work work) {
  ++open_;
  {
    const std::lock_guard lock(mutex_);
    items_.push_back({text, std::move(work)});
  }
  toDo_.notify_one();
  if (open_ == 1) Q_EMIT busyChanged(text);
  if (thread_.joinable()) return;
  const QString noThread = app::sentenceOf([&] {
    thread_ = std::thread([this] {
      for (Item item = take(); item.work; item = take())
        carryOut(item);
    });
  });
  if (!noThread.isEmpty()) carryOut(take());
}

void Background::runAndWait(const QString& text, const std::function<void()>& work) {
  QEventLoop loop;
  QString failure;
  run(text, [&] {
    failure = app::sentenceOf(work);
    return [&] { loop.quit(); };
  });
  loop.exec(QEventLoop::ExcludeUserInputEvents);
  if (!failure.isEmpty()) Q_EMIT failed(failure);
}

Background::Item Background::take() {
  std::unique_lock lock(mutex_);
  toDo_.wait(lock, [&] { return quit_ || !items_.empty(); });
  if (quit_) return {};
  Item item = std::move(items_.front());
  items_.pop_front();
  return item;
}

void Background::carryOut(const Item& item) {
  std::function<void()> after;
  const QString failure = app::sentenceOf([&] { after = item.work(); });
  if (!failure.isEmpty()) after = [this, failure] { Q_EMIT failed(failure); };
  QMetaObject::invokeMethod(
      this,
      [this, after = std::move(after)] {
        if (after) after();
        --open_;
        QString next;
        {
          const std::lock_guard lock(mutex_);
          if (!items_.empty()) next = items_.front().text;
        }
        if (open_ == 0 || !next.isEmpty()) Q_EMIT busyChanged(open_ == 0 ? QString() : next);
      },
      Qt::QueuedConnection);
}

QString sentenceOf(const std::function<void()>& task) {
  return QString::fromStdString(innergs::sentenceOf(task));
}

} // namespace innergs::app
