#include "EndingQuestion.h"

#include "Widgets/Host.h"
#include "Widgets/MotionHost.h"

#include <QAction>
#include <QEvent>
#include <QMessageBox>
#include <QMetaObject>
#include <QPushButton>

EndingQuestion::EndingQuestion(innergs::ui::Host* host, QMainWindow* window, QObject* parent)
    : QObject(parent), host_(host), window_(window) {
  window->installEventFilter(this);
}

EndingQuestion::~EndingQuestion() {
  for (const auto& undo : undo_)
    undo();
}

void EndingQuestion::guard(const char* actionName, const char* slot, const QString& question) {
  QPointer<QAction> action = window_ ? window_->findChild<QAction*>(actionName) : nullptr;
  const QByteArray method = QByteArray("1") + slot; // as SLOT() makes it
  if (!action || window_->metaObject()->indexOfSlot(slot) < 0 ||
      !QObject::disconnect(action, SIGNAL(triggered()), window_, method))
    return;
  const QByteArray name = QByteArray(slot).chopped(2); // without ()
  const auto connection = connect(action, &QAction::triggered, this, [this, name, question] {
    if (mayEnd(question) && window_) QMetaObject::invokeMethod(window_, name.constData());
  });
  undo_.push_back([action, window = window_, method, connection] {
    QObject::disconnect(connection);
    if (action && window) QObject::connect(action, SIGNAL(triggered()), window, method);
  });
}

bool EndingQuestion::eventFilter(QObject* watched, QEvent* event) {
  if (watched != window_ || event->type() != QEvent::Close) return false;
  if (mayEnd(
          tr("A reconstruction is running. Stop it and close? Once its iterations have begun, its state is "
             "kept, so that you can continue it.")))
    return false;
  event->ignore();
  return true;
}

bool EndingQuestion::mayEnd(const QString& question) {
  if (!host_ || !(host_->isRunning() || (host_->motion() && host_->motion()->isRunning()))) return true;
  QMessageBox box(QMessageBox::Question, QStringLiteral("InnerGS"), question, QMessageBox::NoButton, window_);
  box.setObjectName("runningBox");
  QPushButton* stay = box.addButton(tr("&Keep Running"), QMessageBox::RejectRole);
  QPushButton* stop = box.addButton(tr("&Stop and Close"), QMessageBox::DestructiveRole);
  box.setDefaultButton(stay);
  box.setEscapeButton(stay);
  box.exec();
  return box.clickedButton() == stop;
}
