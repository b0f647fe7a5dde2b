// The question before a person ends a running reconstruction in Slicer, tested on a window made like
// Slicer's.
#include "EndingQuestion.h"
#include "FakeHost.h"
#include "TestTools.h"

#include <QAction>
#include <QMessageBox>
#include <QPushButton>
#include <QTimer>

#include <memory>

/// Its action is connected by name, like uic does.
class Window : public QMainWindow {
  Q_OBJECT
public:
  Window() : closeScene(new QAction(this)) {
    closeScene->setObjectName("FileCloseSceneAction");
    QMetaObject::connectSlotsByName(this);
  }
  QAction* closeScene;
  int scenesClosed = 0;

public Q_SLOTS:
  void on_FileCloseSceneAction_triggered() { ++scenesClosed; }
};

class EndingQuestionTest : public QObject {
  Q_OBJECT
private Q_SLOTS:
  void init() {
    window_ = std::make_unique<Window>();
    host_ = std::make_unique<FakeHost>();
    host_->cancelsByItself = false;
    question_ = std::make_unique<EndingQuestion>(host_.get(), window_.get(), nullptr);
    question_->guard("FileCloseSceneAction", "on_FileCloseSceneAction_triggered()", "Close the scene?");
    QVERIFY(showActive(*window_));
  }
  void cleanup() {
    question_.reset();
    window_.reset();
    host_.reset();
  }

  void nothingIsAskedWhileNothingRuns() {
    window_->closeScene->trigger();
    QCOMPARE(window_->scenesClosed, 1);
    QVERIFY(window_->close());
    QCOMPARE(asked_, QString());
  }

  void theWindowStaysOpenUntilItMayClose() {
    start();
    answer("Keep Running");
    QVERIFY(!window_->close());
    QVERIFY(window_->isVisible());
    QVERIFY2(asked_.contains("reconstruction is running"), qPrintable(asked_));
    answer("Stop and Close");
    QVERIFY(window_->close());
    QVERIFY(!window_->isVisible());
  }

  void theSceneStaysUntilItMayClose() {
    start();
    answer("Keep Running");
    window_->closeScene->trigger();
    QCOMPARE(window_->scenesClosed, 0);
    QCOMPARE(asked_, QString("Close the scene?"));
    answer("Stop and Close");
    window_->closeScene->trigger();
    QCOMPARE(window_->scenesClosed, 1);
    host_->sendFinished({});
    asked_.clear();
    window_->closeScene->trigger();
    QCOMPARE(window_->scenesClosed, 2);
    QCOMPARE(asked_, QString());
  }

  void theEscapeKeyKeepsItRunning() {
    start();
    QTimer timer;
    connect(&timer, &QTimer::timeout, this, [] {
      if (auto* box = qobject_cast<QMessageBox*>(QApplication::activeModalWidget()))
        QTest::keyClick(box, Qt::Key_Escape);
    });
    timer.start(10);
    QVERIFY(!window_->close());
  }

  void actionsAreAsTheyWereAfterwards() {
    start();
    question_.reset();
    window_->closeScene->trigger();
    QCOMPARE(window_->scenesClosed, 1);
    QVERIFY(window_->close());
  }

  void anActionThatIsConnectedOtherwiseIsLeftAlone() {
    QAction other(window_.get());
    other.setObjectName("Other");
    int triggered = 0;
    connect(&other, &QAction::triggered, this, [&] { ++triggered; });
    question_->guard("Other", "on_Other_triggered()", "?");
    question_->guard("NoSuchAction", "on_NoSuchAction_triggered()", "?");
    start();
    other.trigger();
    QCOMPARE(triggered, 1);
  }

private:
  void start() {
    asked_.clear();
    QVERIFY(host_->start({}));
    QVERIFY(host_->isRunning());
  }
  /// Clicks the button of the question that will come.
  void answer(const QString& button) {
    auto* timer = new QTimer(this);
    connect(timer, &QTimer::timeout, this, [this, timer, button] {
      auto* box = qobject_cast<QMessageBox*>(QApplication::activeModalWidget());
      if (!box || !box->isVisible()) return;
      asked_ = box->text();
      timer->deleteLater();
      for (QAbstractButton* one : box->buttons())
        if (one->text().remove('&') == button) return QTest::mouseClick(one, Qt::LeftButton);
    });
    timer->start(10);
  }

  std::unique_ptr<Window> window_;
  std::unique_ptr<FakeHost> host_;
  std::unique_ptr<EndingQuestion> question_;
  QString asked_;
};

QTEST_MAIN(EndingQuestionTest)
#include "EndingQuestionTest.moc"
