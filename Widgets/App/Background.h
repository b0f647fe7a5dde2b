#pragma once
#include <QObject>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace innergs::app {

/// Runs tasks, such as reading and writing files, one after another on a thread; if the system has no more
/// threads, on the main thread.
class Background : public QObject {
  Q_OBJECT
public:
  explicit Background(QObject* parent = nullptr);
  /// Waits for the current task and drops the waiting ones.
  ~Background() override;

  /// `work` runs on the thread; the function that it returns is then called on the main thread. `text`: for
  /// the busy bar. If `work` throws, failed() is emitted and nothing is called, so it must catch exceptions
  /// itself (sentenceOf) if something must be cleaned up.
  using Work = std::function<std::function<void()>()>;
  void run(const QString& text, Work work);
  bool isBusy() const { return open_ > 0; }

  /// Runs `work` on the thread and keeps the main thread's windows painting until it is done.
  void runAndWait(const QString& text, const std::function<void()>& work);

Q_SIGNALS:
  /// The current task's text; "" if none is left.
  void busyChanged(const QString& text);
  /// A task threw an exception, described by the sentence.
  void failed(const QString& sentence);

private:
  struct Item {
    QString text;
    Work work;
  };
  Item take(); // waits for one; its work is empty at the end
  void carryOut(const Item& item);

  int open_ = 0; // main thread
  std::mutex mutex_;
  std::condition_variable toDo_;
  bool quit_ = false;
  std::deque<Item> items_;
  std::thread thread_;
};

/// Runs the task and returns a sentence on what it throws; "" on success.
QString sentenceOf(const std::function<void()>& task);

} // namespace innergs::app
