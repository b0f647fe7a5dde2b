#pragma once
#include <QCoreApplication>
#include <QMainWindow>
#include <QPointer>

#include <functional>
#include <vector>

class QAction;

namespace innergs::ui {
class Host;
}

/// Asks before a person ends a running reconstruction by closing the application's window or the scene; "no"
/// changes nothing. Does not ask scripts.
class EndingQuestion : public QObject {
  Q_DECLARE_TR_FUNCTIONS(EndingQuestion)
public:
  EndingQuestion(innergs::ui::Host* host, QMainWindow* window, QObject* parent);
  ~EndingQuestion() override;

  /// Makes an action that calls a slot of the window ask first; does nothing if there is no such action.
  void guard(const char* action, const char* slot, const QString& question);

protected:
  bool eventFilter(QObject* watched, QEvent* event) override;

private:
  bool mayEnd(const QString& question);

  QPointer<innergs::ui::Host> host_;
  QPointer<QMainWindow> window_;
  std::vector<std::function<void()>> undo_; // restores the actions
};
