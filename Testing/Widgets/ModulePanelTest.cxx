// The panel as 3D Slicer arranges it: in a collapsible section of a module in a small scroll area.
#include "FakeHost.h"
#include "Patience.h"
#include "TestTools.h"
#include "Widgets/InputRow.h"
#include "Widgets/ReconstructionPanel.h"

#include <QApplication>
#include <QProgressBar>
#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QVBoxLayout>

#include <memory>

using namespace innergs::ui;
using innergs::Phase;

namespace {

/// A collapsible section that does not pass on its content's height-for-width.
class Fold : public QWidget {
public:
  explicit Fold(QWidget* content) : content_(content) {
    auto* layout = new QVBoxLayout(this);
    layout->setContentsMargins(4, 25, 4, 4);
    layout->addWidget(content);
  }
  void setFolded(bool folded) {
    content_->setVisible(!folded);
    setMaximumHeight(folded ? 25 : QWIDGETSIZE_MAX);
  }
  bool hasHeightForWidth() const override { return false; }

private:
  QWidget* content_;
};

} // namespace

class ModulePanelTest : public QObject {
  Q_OBJECT
private Q_SLOTS:
  void init() {
    host_ = std::make_unique<FakeHost>();
    area_ = std::make_unique<QScrollArea>();
    auto* base = new QWidget;
    base_ = new QVBoxLayout(base);
    base_->addWidget(new QPushButton("Help"));
    area_->setWidget(base);
    area_->setWidgetResizable(true);
    area_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    area_->resize(480, 470); // of 1280 × 800, with Slicer's Data Probe open
    QVERIFY(showActive(*area_));
    module_ = std::make_unique<QWidget>();
    auto* layout = new QVBoxLayout(module_.get());
    layout->addWidget(new QLabel("Parameter set:"));
    panel_ = new ReconstructionPanel(host_.get());
    panel_->layout()->setContentsMargins(0, 0, 0, 0);
    fold_ = new Fold(panel_);
    layout->addWidget(fold_);
    layout->addWidget(new QPushButton("Model"));
    layout->addStretch(1);
  }
  void cleanup() {
    leave();
    module_.reset();
    area_.reset();
    host_.reset();
  }

  void nothingIsCutOffWhateverComesAndGoes() {
    choose({"head", "side"});
    enter();
    check("entered");
    leave();
    choose({"head", "side", "thin"});
    enter();
    check("more-scans");
    area_->resize(360, 470);
    check("narrow");
    area_->resize(480, 470);
    choose({"head"});
    start();
    check("started");
    leave();
    send();
    host_->sendPreview();
    enter();
    check("ran-elsewhere");
    area_->resize(600, 300);
    check("wide");
    leave();
    area_->resize(400, 470);
    Report report = FakeHost::exampleReport();
    report.warnings << "The slices of the first scan lie so far apart that what is between them is made up.";
    host_->sendFinished(report);
    enter();
    check("finished-elsewhere");
    fold_->setFolded(true);
    choose({"side", "head"});
    fold_->setFolded(false);
    check("unfolded");
    area_->hide();
    choose({"thin"});
    host_->addVolume("head", {"Head, renamed", {256, 256, 30}, {0.9, 0.9, 4}, 2, "axial"});
    area_->show();
    check("window-shown");
    QFont large = area_->font();
    large.setPointSizeF(1.3 * large.pointSizeF());
    area_->setFont(large);
    check("large-font");
    leave();
    choose({"thin", "side", "head"});
    enter();
    check("large-font-entered");
  }

  void theButtonAndTheProgressStayInView() {
    choose({"head", "side"});
    enter();
    TRY_VERIFY(button()->isEnabled());
    seenWherever({button(), child("estimateText")});
    snapshot(*area_, "module-start");
    start();
    send();
    host_->sendPreview();
    TRY_VERIFY(child("preview")->isVisible());
    seenWherever({button(), child("progressBar"), child("phaseText"), child("remainingText")});
    snapshot(*area_, "module-running");
    host_->sendFailed("The file cannot be read: choose another one");
    TRY_VERIFY(isSeen(child("message")));
    QVERIFY(!child("progressBar")->isVisible());
    seenWherever({button()});
  }

  void theKeyboardIsNeverUnderTheButton() {
    choose({"head", "side", "thin"});
    enter();
    TRY_VERIFY(button()->isEnabled());
    TRY_COMPARE(clippedWidget(*module_), QString());
    panel_->findChild<InputRow*>()->fields().first()->setFocus();
    for (int n = 0; n < 60 && QApplication::focusWidget() != button(); ++n) {
      QWidget* at = QApplication::focusWidget();
      QVERIFY2(isSeen(at), qPrintable(at->objectName()));
      QTest::keyClick(at, Qt::Key_Tab);
    }
    QCOMPARE(QApplication::focusWidget(), button());
  }

private:
  QPushButton* button() { return panel_->findChild<QPushButton*>("reconstruct"); }
  QWidget* child(const char* name) { return panel_->findChild<QWidget*>(name); }
  void choose(const QStringList& ids) {
    Request request;
    for (const QString& id : ids)
      request.inputs << InputChoice{id, 0, 1, -1};
    panel_->setRequest(request);
  }
  void start() {
    panel_->startOrCancel();
    QVERIFY(host_->isRunning());
  }
  void send() {
    host_->sendProgress(Phase::Fitting, 0.1, 10, 0.02, 25, 40,
                        "On the CPU. The CUDA backend is not installed.");
    host_->sendProgress(Phase::Fitting, 0.2, 20, 0.01, 28, 30);
  }
  void enter() {
    base_->insertWidget(1, module_.get());
    module_->setVisible(true);
  }
  void leave() {
    module_->setVisible(false);
    base_->removeWidget(module_.get());
    module_->setParent(nullptr);
  }
  void check(const char* name) {
    TRY_COMPARE(clippedWidget(*module_), QString());
    for (const auto* row : panel_->findChildren<InputRow*>())
      QVERIFY2(!row->isVisible() || row->height() >= row->minimumSizeHint().height(), name);
    snapshot(*area_->widget(), QString("module-%1").arg(name));
  }
  /// Completely visible, and not under the pinned row.
  bool isSeen(const QWidget* widget) {
    return widget->isVisible() && widget->visibleRegion().boundingRect() == widget->rect() &&
           (child("pinnedBar")->isAncestorOf(widget) ||
            !QRect(widget->mapTo(panel_, QPoint(0, 0)), widget->size())
                 .intersects(child("pinnedBar")->geometry()));
  }
  void seenWherever(const QVector<QWidget*>& widgets) {
    TRY_COMPARE(clippedWidget(*module_), QString());
    QScrollBar* bar = area_->verticalScrollBar();
    QVERIFY(bar->maximum() > 100);
    for (int at = 0; at <= bar->maximum(); at += 10) {
      bar->setValue(at);
      for (QWidget* widget : widgets)
        QVERIFY2(isSeen(widget), qPrintable(QString("%1 at %2").arg(widget->objectName()).arg(at)));
    }
    bar->setValue(0);
  }
  std::unique_ptr<FakeHost> host_;
  std::unique_ptr<QScrollArea> area_;
  std::unique_ptr<QWidget> module_;
  QVBoxLayout* base_ = nullptr;
  Fold* fold_ = nullptr;
  ReconstructionPanel* panel_ = nullptr;
};

QTEST_MAIN(ModulePanelTest)
#include "ModulePanelTest.moc"
