#pragma once
#include "AppFixture.h"
#include "TestTools.h"

#include "Widgets/App/Background.h"
#include "Widgets/App/MainWindow.h"
#include "Widgets/ReconstructionPanel.h"

#include <QAction>
#include <QApplication>
#include <QFileDialog>
#include <QLineEdit>
#include <QMessageBox>
#include <QPushButton>
#include <QSignalSpy>
#include <QSurfaceFormat>
#include <QTest>
#include <QTimer>
#include <QTreeWidget>

#include <memory>

/// The app's window with separate settings for every test, and a user's actions in it.
class AppWindowTest : public QObject {
  Q_OBJECT
protected:
  std::unique_ptr<apptest::Sandbox> sandbox_;
  std::unique_ptr<innergs::app::MainWindow> window_;

  innergs::app::AppHost& host() { return *window_->host(); }
  QPushButton* button() { return window_->findChild<QPushButton*>("reconstruct"); }
  QTreeWidget* tree() const { return window_->findChild<QTreeWidget*>("dataTree"); }
  QStringList lines() const {
    QStringList names;
    for (int n = 0; n < tree()->topLevelItemCount(); ++n)
      names << tree()->topLevelItem(n)->text(0);
    return names;
  }
  void chooseLine(int n) { tree()->setCurrentItem(tree()->topLevelItem(n)); }
  void open(const QStringList& paths) {
    window_->host()->open(paths);
    TRY_VERIFY(!host().background().isBusy());
  }
  void setQuick(bool longFit = false) {
    innergs::ui::Request request = window_->reconstruction()->request();
    const innergs::ui::Request quick = apptest::request({}, longFit);
    request.settings = quick.settings;
    request.evaluateQuality = false;
    window_->reconstruction()->setRequest(request);
  }
  /// Types a path into the file dialog that opens next, chooses the filter with this word and accepts it.
  void answerFileDialog(const QString& path, const QString& word = {}) {
    auto* timer = new QTimer(qApp);
    connect(timer, &QTimer::timeout, timer, [timer, path, word] {
      for (QWidget* widget : QApplication::topLevelWidgets())
        if (auto* dialog = qobject_cast<QFileDialog*>(widget); dialog && dialog->isVisible()) {
          auto* edit = dialog->findChild<QLineEdit*>("fileNameEdit");
          if (!edit) continue;
          timer->deleteLater();
          auto* filters = dialog->findChild<QComboBox*>("fileTypeCombo");
          for (int n = 0; n < filters->count() && !filters->currentText().contains(word); ++n)
            QTest::keyClick(filters, Qt::Key_Down);
          edit->setText(path);
          QTest::keyClick(edit, Qt::Key_Return);
          return;
        }
    });
    timer->start(20);
  }
  /// Cancels the file dialog that opens next.
  void leaveFileDialog() {
    auto* timer = new QTimer(qApp);
    connect(timer, &QTimer::timeout, timer, [timer] {
      for (QWidget* widget : QApplication::topLevelWidgets())
        if (auto* dialog = qobject_cast<QFileDialog*>(widget); dialog && dialog->isVisible()) {
          timer->deleteLater();
          QTest::keyClick(dialog, Qt::Key_Escape);
          return;
        }
    });
    timer->start(20);
  }
  void trigger(const char* name) {
    auto* action = window_->findChild<QAction*>(name);
    QVERIFY2(action && action->isEnabled(), name);
    action->trigger();
  }
  /// Closes the error box and returns its text.
  QString errorText() {
    QString text;
    apptest::answerBox("errorBox", "OK", &text);
    [&] { TRY_VERIFY(!text.isEmpty()); }();
    return text;
  }
  /// The 3D view, once it is drawn in its final state.
  QImage spaceSeen() {
    [&] { TRY_VERIFY(window_->state()->turns().isIdle()); }();
    return window_->views()->threeD()->grab().toImage();
  }
  void start() {
    TRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(host().isRunning());
  }
  void reconstruct() {
    QSignalSpy finished(&host(), &innergs::app::AppHost::finished);
    start();
    QVERIFY(finished.wait(kPatience));
  }
  /// Closes the window during a run.
  void stopAndClose() {
    apptest::answerBox("runningBox", "Stop and Close");
    window_->close();
    TRY_VERIFY(!window_->isVisible());
  }

protected Q_SLOTS:
  void initTestCase() { QApplication::setAttribute(Qt::AA_DontUseNativeDialogs); }
  void init() {
    sandbox_ = std::make_unique<apptest::Sandbox>();
    window_ = std::make_unique<innergs::app::MainWindow>();
    window_->show();
    QVERIFY(QTest::qWaitForWindowExposed(window_.get()));
  }
  void cleanup() {
    window_.reset();
    sandbox_.reset();
  }
};

/// main() of a test of the window.
template <class Test>
int runAppTest(int argc, char** argv) {
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  QApplication app(argc, argv);
  Test test;
  return QTest::qExec(&test, argc, argv);
}
