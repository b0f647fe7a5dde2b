// The whole way through the desktop app without a mouse.
#include "AppWindowTest.h"

#include "Widgets/App/AppSettings.h"
#include "Widgets/QueryPanel.h"

#include <QDockWidget>
#include <QFile>
#include <QMenu>
#include <QSet>
#include <QSpinBox>
#include <QTimer>

#include <vtkMatrix4x4.h>

#include <utility>

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;

class AppKeyboardTest : public AppWindowTest {
  Q_OBJECT
  /// The widget with the keyboard. Without a window manager, no window gets it back by itself.
  static QWidget* target() {
    if (QWidget* popup = QApplication::activePopupWidget()) return popup;
    QWidget* window = QApplication::activeModalWidget();
    for (QWidget* widget : QApplication::topLevelWidgets())
      if (!window && qobject_cast<app::MainWindow*>(widget)) window = widget;
    if (!window->isActiveWindow()) {
      window->activateWindow();
      (void)QTest::qWaitForWindowActive(window);
    }
    QWidget* focus = QApplication::focusWidget();
    return focus && focus->window() == window ? focus : window;
  }
  static void press(Qt::Key key, Qt::KeyboardModifiers modifiers = {}) {
    QTest::keyClick(target(), key, modifiers);
  }
  static void type(const QString& text) { QTest::keyClicks(target(), text); }
  static QString focused() {
    const QWidget* focus = QApplication::focusWidget();
    return focus ? focus->objectName() : QString();
  }
  /// By Tab; false when that never gets there.
  static bool tabTo(const QString& name) {
    for (int n = 0; n < 150 && focused() != name; ++n)
      press(Qt::Key_Tab);
    return focused() == name;
  }
  /// Of the pixels, 0 to 1.
  static double partThatDiffers(const QImage& a, const QImage& b) {
    qint64 count = 0;
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x)
        count += std::abs(qGray(a.pixel(x, y)) - qGray(b.pixel(x, y))) > 8;
    return double(count) / (double(a.width()) * a.height());
  }
  /// Does this with the keyboard in the dialog that opens next: dialogs wait for their answer.
  static void inDialog(const std::function<void(QWidget*)>& answer) {
    auto* timer = new QTimer(qApp);
    connect(timer, &QTimer::timeout, timer, [timer, answer] {
      QWidget* dialog = QApplication::activeModalWidget();
      if (!dialog || !dialog->isVisible() || !QApplication::focusWidget() ||
          QApplication::focusWidget()->window() != dialog)
        return;
      timer->deleteLater();
      answer(dialog);
    });
    timer->start(20);
  }

private Q_SLOTS:
  void init() {
    AppWindowTest::init();
    window_->activateWindow();
    QVERIFY(QTest::qWaitForWindowActive(window_.get()));
  }

  void wholePath() {
    // Open a recent file: Alt+F, R, 1.
    app::addRecentFile(writeFrames(*sandbox_, "series.nii", 3, 2));
    window_.reset();
    window_ = std::make_unique<app::MainWindow>();
    QVERIFY(showActive(*window_));
    press(Qt::Key_F, Qt::AltModifier);
    TRY_VERIFY(QApplication::activePopupWidget());
    press(Qt::Key_R);
    press(Qt::Key_1);
    TRY_COMPARE(lines(), QStringList{"series frame 1"});
    TRY_VERIFY(!host().background().isBusy());
    // The next frame.
    press(Qt::Key_F4);
    QVERIFY(tabTo("frame"));
    press(Qt::Key_Up);
    TRY_COMPARE(lines(), QStringList{"series frame 2"});
    // Start, cancel, start.
    setQuick(true);
    press(Qt::Key_F5);
    TRY_VERIFY(button()->isEnabled());
    QVERIFY(tabTo("reconstruct"));
    QSignalSpy cancelled(&host(), &AppHost::cancelled), finished(&host(), &AppHost::finished);
    press(Qt::Key_Space);
    QVERIFY(host().isRunning());
    QCOMPARE(focused(), QString("reconstruct"));
    press(Qt::Key_Space);
    QVERIFY(cancelled.wait(kPatience));
    setQuick();
    TRY_VERIFY(button()->isEnabled());
    QCOMPARE(focused(), QString("reconstruct"));
    press(Qt::Key_Space);
    QVERIFY(finished.wait(kPatience));
    QCOMPARE(lines().size(), 3);
    // Look at a tilted plane of the model and export it.
    press(Qt::Key_F6);
    TRY_VERIFY(tabTo("queryView"));
    for (int n = 0; n < 10; ++n)
      press(Qt::Key_Up);
    QVERIFY(std::abs(window_->query()->planeToRAS()->GetElement(2, 2)) < 0.99);
    QVERIFY(tabTo("queryExportVolume"));
    press(Qt::Key_Space);
    TRY_COMPARE(lines().size(), 4);
    // Save the result.
    press(Qt::Key_F4);
    press(Qt::Key_Home);
    press(Qt::Key_Down);
    QCOMPARE(window_->state()->volume()->name, QString("series frame 2 reconstructed"));
    const QString file = sandbox_->path("result.nii.gz");
    inDialog([&](QWidget* dialog) {
      auto* edit = dialog->findChild<QLineEdit*>("fileNameEdit");
      QCOMPARE(QApplication::focusWidget(), static_cast<QWidget*>(edit));
      edit->selectAll();
      type(file);
      press(Qt::Key_Return);
    });
    press(Qt::Key_S, Qt::ControlModifier);
    QVERIFY(QFile::exists(file));
    QVERIFY(window_->state()->volume()->saved);
    // Rename and close one.
    press(Qt::Key_F2);
    type("Mine");
    press(Qt::Key_Return);
    TRY_VERIFY(lines().contains("Mine"));
    press(Qt::Key_Delete);
    TRY_VERIFY(!lines().contains("Mine"));
    // Quit: Escape stays, Discard goes.
    inDialog([&](QWidget*) { press(Qt::Key_Escape); });
    press(Qt::Key_Q, Qt::ControlModifier);
    QVERIFY(window_->isVisible());
    inDialog([&](QWidget* box) {
      QCOMPARE(box->objectName(), QString("unsavedBox"));
      const auto onDiscard = [] {
        auto* focus = qobject_cast<QPushButton*>(QApplication::focusWidget());
        return focus && focus->text().contains("Discard");
      };
      for (int n = 0; n < 5 && !onDiscard(); ++n)
        press(Qt::Key_Tab);
      press(onDiscard() ? Qt::Key_Space : Qt::Key_Escape);
    });
    press(Qt::Key_Q, Qt::ControlModifier);
    TRY_VERIFY(!window_->isVisible());
  }

  /// Tab and Shift+Tab reach every control of the window and come back.
  void nothingKeepsTheKeyboard() {
    open({writeFrames(*sandbox_, "series.nii", 3, 2)});
    setQuick();
    reconstruct();
    const std::pair<Qt::Key, const char*> docks[] = {{Qt::Key_F5, "reconstructDock"},
                                                     {Qt::Key_F6, "queryDock"},
                                                     {Qt::Key_F7, "modelDock"},
                                                     {Qt::Key_F8, "logDock"},
                                                     {Qt::Key_F9, "findDock"}};
    for (const auto& [panel, dock] : docks) {
      press(panel);
      TRY_VERIFY(!window_->findChild<QDockWidget*>(dock)->visibleRegion().isEmpty());
      TRY_COMPARE(clippedWidget(*window_->findChild<QDockWidget*>(dock)->widget()), QString());
      QSet<QWidget*> wanted;
      for (QWidget* widget : window_->findChildren<QWidget*>())
        if (widget->isVisible() && widget->isEnabled() && (widget->focusPolicy() & Qt::TabFocus) &&
            !widget->focusProxy() && !widget->visibleRegion().isEmpty())
          wanted << widget;
      QVERIFY(wanted.size() > 10);
      for (const auto modifiers : {Qt::KeyboardModifiers(), Qt::KeyboardModifiers(Qt::ShiftModifier)}) {
        QSet<QWidget*> reached;
        const QWidget* first = QApplication::focusWidget();
        for (int n = 0; n < 150 && !(n > 0 && QApplication::focusWidget() == first); ++n) {
          press(modifiers ? Qt::Key_Backtab : Qt::Key_Tab, modifiers);
          QVERIFY(QApplication::focusWidget());
          QVERIFY2(QApplication::focusWidget()->window() == window_.get(), qPrintable(focused()));
          reached << QApplication::focusWidget();
          QVERIFY2(!QApplication::focusWidget()->visibleRegion().isEmpty(), qPrintable(focused()));
        }
        for (QWidget* widget : wanted)
          QVERIFY2(reached.contains(widget),
                   qPrintable(QString("%1 '%2' in panel %3")
                                  .arg(widget->metaObject()->className(), widget->objectName())
                                  .arg(panel - Qt::Key_F4)));
      }
    }
  }

  void viewsByTheKeyboard() {
    open({writeBall(*sandbox_, "ball.nii", {24, 24, 24}, {1.5, 1.5, 1.5})});
    app::ViewState* state = window_->state();
    QVERIFY(tabTo("axialView"));
    const double before = state->crosshair()[2];
    press(Qt::Key_Up);
    QVERIFY(std::abs(state->crosshair()[2] - before - state->stepAlong(2)) < 1e-9);
    const QPointF corner = window_->views()->slice(2)->fromRAS({9, 9, 0});
    press(Qt::Key_Plus);
    QVERIFY(window_->views()->slice(2)->fromRAS({9, 9, 0}) != corner);
    QVERIFY(tabTo("threeDView"));
    // A frame says where the keyboard is.
    const QPoint edge = window_->views()->threeD()->geometry().topLeft() - QPoint(1, 1);
    const QColor frame = window_->palette().color(QPalette::Highlight);
    QCOMPARE(window_->views()->grab().toImage().pixelColor(edge), frame);
    const QImage front = spaceSeen();
    press(Qt::Key_W); // no key of VTK's: wireframe
    QVERIFY(partThatDiffers(spaceSeen(), front) < 0.01);
    press(Qt::Key_Left);
    TRY_VERIFY(partThatDiffers(spaceSeen(), front) > 0.05);
    press(Qt::Key_Home);
    TRY_VERIFY(partThatDiffers(spaceSeen(), front) < 0.01);
  }
};

int main(int argc, char** argv) {
  return runAppTest<AppKeyboardTest>(argc, argv);
}
#include "AppKeyboardTest.moc"
