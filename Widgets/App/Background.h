#pragma once
#include <QObject>

#include <condition_variable>
#include <deque>
#include <functional>
#include <mutex>
#include <thread>

namespace innergs::app {

/// Does tasks, such as reading and writing files, one after another on a thread; where the system has no more
/// threads, on the main thread.
class Background : public QObject {
  Q_OBJECT
public:
  explicit Background(QObject* parent = nullptr);
  /// Waits for the task in progress and drops those that wait.
  ~Background() override;

  /// `work` runs on the thread; what it returns is called on the main thread afterwards. `text`: for the busy
  /// bar. Work that throws is told by failed(), and nothing is called then: what must be cleaned up catches
  /// it itself (sentenceOf).
  using Work = std::function<std::function<void()>()>;
  void run(const QString& text, Work work);
  bool isBusy() const { return open_ > 0; }

  /// Runs `work` on the thread and keeps the main thread's windows painting until it is done.
  void runAndWait(const QString& text, const std::function<void()>& work);

Q_SIGNALS:
  /// Text of the task in progress, or "" when there is none left.
  void busyChanged(const QString& text);
  /// A task threw: what, as a sentence.
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

/// What `task` throws, as one sentence; "" when it went well.
QString sentenceOf(const std::function<void()>& task);

} // namespace innergs::app
