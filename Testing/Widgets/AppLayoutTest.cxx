// Nothing in the desktop app's window is cut off, in light and dark colours; at 150 % as well.
#include "AppWindowTest.h"

#include "Widgets/App/Startup.h"

#include <QDockWidget>
#include <QPalette>

using namespace innergs;
using namespace apptest;

class AppLayoutTest : public AppWindowTest {
  Q_OBJECT
private Q_SLOTS:
  void nothingIsCutOff_data() {
    QTest::addColumn<bool>("dark");
    QTest::newRow("light") << false;
    QTest::newRow("dark") << true;
  }
  void nothingIsCutOff() {
    QFETCH(bool, dark);
    if (dark) app::useDarkPalette();
    window_ = std::make_unique<app::MainWindow>();
    window_->show();
    QVERIFY(QTest::qWaitForWindowExposed(window_.get()));
    open({writeFrames(*sandbox_, "series.nii", 12, 2.5f)});
    setQuick();
    reconstruct();
    chooseLine(0);
    for (const char* panel : {"reconstructDock", "queryDock", "findDock", "modelDock", "logDock"}) {
      window_->showPanel(panel);
      for (const char* name : {panel, "dataDock"}) // as soon as it is laid out
        TRY_COMPARE(clippedWidget(*window_->findChild<QDockWidget*>(name)->widget()), QString());
      TRY_COMPARE(clippedWidget(*window_->views()), QString());
      snapshot(*window_, QString("app-%1-%2").arg(panel, dark ? "dark" : "light"));
    }
    // Words stand out from what is behind them.
    for (const QWidget* widget : window_->findChildren<QWidget*>()) {
      if (!widget->isVisible() || !widget->isEnabled()) continue;
      const QPalette& palette = widget->palette();
      const int contrast = std::abs(qGray(palette.color(widget->foregroundRole()).rgb()) -
                                    qGray(palette.color(widget->backgroundRole()).rgb()));
      QVERIFY2(contrast > 90, qPrintable(widget->objectName()));
    }
  }
};

int main(int argc, char** argv) {
  return runAppTest<AppLayoutTest>(argc, argv);
}
#include "AppLayoutTest.moc"
