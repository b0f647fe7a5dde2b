// A person's whole path through the desktop app, by mouse and keyboard.
#include "AppFixture.h"

#include "IO/ModelFile.h"
#include "IO/VolumeIO.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/DataList.h"
#include "Widgets/App/MainWindow.h"
#include "Widgets/ModelPanel.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ReconstructionPanel.h"

#include <QAction>
#include <QApplication>
#include <QComboBox>
#include <QDir>
#include <QDockWidget>
#include <QDropEvent>
#include <QElapsedTimer>
#include <QFileDialog>
#include <QLabel>
#include <QLineEdit>
#include <QMenu>
#include <QMenuBar>
#include <QMessageBox>
#include <QMimeData>
#include <QPushButton>
#include <QSignalSpy>
#include <QSlider>
#include <QSurfaceFormat>
#include <QTest>
#include <QTreeWidget>
#include <QUrl>
#include <QWheelEvent>

#include <vtkMatrix4x4.h>

#include <cmath>
#include <memory>

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;
using innergs::app::MainWindow;
using innergs::app::SliceView;

class AppTest : public QObject {
  Q_OBJECT
private:
  std::unique_ptr<Sandbox> sandbox_;
  std::unique_ptr<MainWindow> window_;

  AppHost& host() { return *window_->host(); }
  QPushButton* button() { return window_->findChild<QPushButton*>("reconstruct"); }
  QStringList lines() const {
    QStringList names;
    const auto* tree = window_->findChild<QTreeWidget*>("dataTree");
    for (int n = 0; n < tree->topLevelItemCount(); ++n)
      names << tree->topLevelItem(n)->text(0);
    return names;
  }
  void open(const QStringList& paths) {
    window_->open(paths);
    QTRY_VERIFY_WITH_TIMEOUT(!host().background().isBusy(), 60000);
  }
  void setQuick(bool longFit = false) {
    ui::Request request = window_->reconstruction()->request();
    const ui::Request quick = apptest::request({}, longFit);
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
  void trigger(const char* name) {
    auto* action = window_->findChild<QAction*>(name);
    QVERIFY2(action && action->isEnabled(), name);
    action->trigger();
  }
  /// The text of the error box, which is closed.
  QString errorText() {
    QString text;
    answerBox("errorBox", "OK", &text);
    (void)QTest::qWaitFor([&] { return !text.isEmpty(); }, 20000);
    return text;
  }
  void reconstruct() {
    QSignalSpy finished(&host(), &AppHost::finished);
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(host().isRunning());
    QVERIFY(finished.wait(60000));
  }

private Q_SLOTS:
  void initTestCase() { QApplication::setAttribute(Qt::AA_DontUseNativeDialogs); }
  void init() {
    sandbox_ = std::make_unique<Sandbox>();
    window_ = std::make_unique<MainWindow>();
    window_->show();
    QVERIFY(QTest::qWaitForWindowExposed(window_.get()));
  }
  void cleanup() {
    window_.reset();
    sandbox_.reset();
  }

  void wholePath() {
    // Open.
    open({writeBall(*sandbox_, "ball.nii.gz", {32, 32, 10}, {1.2, 1.2, 4})});
    QCOMPARE(lines(), QStringList{"ball"});
    QCOMPARE(window_->state()->volume()->name, QString("ball"));
    // Reconstruct, cancel, reconstruct.
    setQuick(true);
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(host().isRunning());
    QTest::qWait(200);
    QSignalSpy cancelled(&host(), &AppHost::cancelled);
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(cancelled.wait(5000));
    QCOMPARE(lines(), QStringList{"ball"});
    setQuick();
    window_->state()->setWindow(5, 66);
    reconstruct();
    QCOMPARE(lines(), (QStringList{"ball", "ball reconstructed", "ball model"}));
    // The result is shown at once with window and level kept.
    QCOMPARE(window_->state()->volume()->name, QString("ball reconstructed"));
    QCOMPARE(window_->state()->volume()->window->upper, 66.0);
    QVERIFY(window_->isWindowModified());
    // An oblique plane of the model.
    window_->showPanel("queryDock");
    vtkNew<vtkMatrix4x4> plane;
    const double c = std::cos(0.6), s = std::sin(0.6);
    const double elements[16] = {c, 0, s, 0, 0, 1, 0, 0, -s, 0, c, 2, 0, 0, 0, 1};
    plane->DeepCopy(elements);
    window_->query()->setPlane(plane);
    QCOMPARE(window_->query()->modelId(), host().document().models().front()->id);
    QTRY_VERIFY(window_->findChild<QPushButton*>("queryExportVolume")->isEnabled());
    QTest::mouseClick(window_->findChild<QPushButton*>("queryExportVolume"), Qt::LeftButton);
    QTRY_COMPARE(lines().size(), 4);
    const auto exported = host().document().volumes().back();
    QVERIFY(exported->range[1] > 60); // through the ball
    QVERIFY(std::abs(exported->ijkToRAS->GetElement(0, 2) / exported->volume->geometry.spacing[2]) >
            0.5); // oblique
    // Save volume and model and read them back.
    window_->state()->setVolumeId(host().document().volumes()[1]->id);
    const QString volume = sandbox_->path("out.nii.gz"), model = sandbox_->path("out.innergs");
    answerFileDialog(volume);
    trigger("saveVolume");
    answerFileDialog(model);
    trigger("saveModel");
    QVERIFY(readVolume(volume.toStdString()).voxels == host().document().volumes()[1]->volume->voxels);
    QCOMPARE(readModel(model.toStdString()).field.size(),
             std::int64_t(host().document().models().front()->model->GetNumberOfGaussians()));
    QVERIFY(host().document().volumes()[1]->saved && host().document().models()[0]->saved);
    QCOMPARE(app::recentFiles().first(), model);
    QCOMPARE(host().folder(), QFileInfo(volume).absolutePath());
    // A second reconstruction.
    window_->state()->setVolumeId(host().document().volumes()[0]->id);
    reconstruct();
    QVERIFY(lines().contains("ball reconstructed (2)"));
  }

  void viewsAreLinked() {
    open({writeBall(*sandbox_, "ball.nii.gz", {40, 40, 20}, {1, 1, 2}, true)});
    app::ViewState* state = window_->state();
    SliceView* axial = window_->views()->slice(2);
    const Vec3 before = state->crosshair();
    const Vec3 target{before[0] + 6, before[1] - 4, before[2]};
    // A click puts the crosshair there; the letters say where right and left are.
    QTest::mouseClick(axial, Qt::LeftButton, {}, axial->fromRAS(target).toPoint());
    QVERIFY(std::abs(state->crosshair()[0] - target[0]) < 0.5 &&
            std::abs(state->crosshair()[1] - target[1]) < 0.5);
    QVERIFY(std::abs(window_->views()->slice(0)->position() - target[0]) < 0.5);
    QCOMPARE(axial->letters()[0], QChar('R'));
    QCOMPARE(axial->letters()[2], QChar('A'));
    QVERIFY(axial->toRAS(QPointF(0, axial->height() / 2))[0] > axial->toRAS(QPointF(axial->width(), 0))[0]);
    QCOMPARE(window_->views()->slice(0)->letters()[0], QChar('A'));
    // The wheel and the keys go through the slices by the distance between them.
    const double step = state->stepAlong(2), z = state->crosshair()[2];
    QWheelEvent wheel(QPointF(20, 20), axial->mapToGlobal(QPoint(20, 20)), {}, {0, 120}, Qt::NoButton,
                      Qt::NoModifier, Qt::NoScrollPhase, false);
    QCoreApplication::sendEvent(axial, &wheel);
    QVERIFY(std::abs(state->crosshair()[2] - z - step) < 1e-6);
    QTest::keyClick(axial, Qt::Key_Down);
    QVERIFY(std::abs(state->crosshair()[2] - z) < 1e-6);
    // A drag changes window and level; reset goes back.
    const double lower = state->volume()->window->lower;
    const QPoint at(axial->width() / 2, axial->height() / 2);
    QTest::mousePress(axial, Qt::LeftButton, {}, at);
    QMouseEvent move(QEvent::MouseMove, QPointF(at + QPoint(0, 60)), Qt::LeftButton, Qt::LeftButton, {});
    QCoreApplication::sendEvent(axial, &move);
    QTest::mouseRelease(axial, Qt::LeftButton, {}, at + QPoint(0, 60));
    QVERIFY(state->volume()->window->lower < lower);
    trigger("resetWindow");
    QCOMPARE(state->volume()->window->lower, lower);
    // The value under the mouse.
    QSignalSpy pointed(window_->views(), &app::ViewGrid::pointed);
    QMouseEvent hover(QEvent::MouseMove, axial->fromRAS({0, 0, 0}), Qt::NoButton, Qt::NoButton, {});
    QCoreApplication::sendEvent(axial, &hover);
    QVERIFY2(pointed.last().first().toString().contains(" mm: "),
             qPrintable(pointed.last().first().toString()));
    // A view alone by double click, and back.
    QTest::mouseDClick(axial, Qt::LeftButton);
    QVERIFY(!window_->views()->slice(0)->isVisible());
    QTest::mouseDClick(axial, Qt::LeftButton);
    QVERIFY(window_->views()->slice(0)->isVisible());
    // The slider of the view.
    auto* slider = axial->parentWidget()->findChild<QSlider*>("slider");
    QTest::keyClick(slider, Qt::Key_Home);
    QVERIFY(std::abs(axial->position() - state->bounds()[4]) < 1.01 * step);
  }

  void comparesVolumesAtTheSamePlace() {
    open(
        {writeBall(*sandbox_, "thick.nii.gz"), writeBall(*sandbox_, "thin.nii.gz", {40, 40, 40}, {1, 1, 1})});
    app::ViewState* state = window_->state();
    QCOMPARE(state->volume()->name, QString("thin"));
    state->setCrosshair({3, -2, 4});
    trigger("nextVolume");
    QCOMPARE(state->volume()->name, QString("thick"));
    QCOMPARE(state->crosshair()[0], 3.0);
    trigger("previousVolume");
    QCOMPARE(state->volume()->name, QString("thin"));
    // By the list as well.
    auto* tree = window_->findChild<QTreeWidget*>("dataTree");
    tree->setCurrentItem(tree->topLevelItem(0));
    QCOMPARE(state->volume()->name, QString("thick"));
  }

  void rendersVolumesAndEllipsoids() {
    open({writeBall(*sandbox_, "ball.nii.gz", {24, 24, 24}, {1.5, 1.5, 1.5})});
    setQuick();
    reconstruct();
    const QImage planes = window_->views()->threeD()->grab().toImage();
    trigger("volumeRendering");
    QVERIFY(window_->views()->threeD()->isVolumeRendered());
    QTest::qWait(300);
    const QImage rendered = window_->views()->threeD()->grab().toImage();
    QVERIFY(rendered != planes);
    trigger("volumeRendering");
    trigger("planes");
    QTest::qWait(200);
    const QImage empty = window_->views()->threeD()->grab().toImage();
    trigger("ellipsoids");
    QVERIFY(host().document().models().front()->ellipsoidsShown);
    QTRY_VERIFY(window_->views()->threeD()->grab().toImage() != empty);
    trigger("ellipsoids");
    QTRY_VERIFY(window_->views()->threeD()->grab().toImage() == empty);
  }

  void saysWhatIsWrong() {
    window_->open({sandbox_->path("absent.nii")});
    QVERIFY(errorText().contains("does not exist; check the path."));
    window_->open({writeRgb(*sandbox_, "rgb.nii")});
    QVERIFY(errorText().contains("colour (RGB) pixels; convert it to grey values first."));
    // Several at once in one box.
    window_->open({writeBall(*sandbox_, "slice.nii", {16, 16, 1}), sandbox_->path("absent.innergs"),
                   writeBall(*sandbox_, "fine.nii")});
    const QString text = errorText();
    QVERIFY(text.contains("single slice") && text.contains("absent.innergs"));
    QCOMPARE(lines(), QStringList{"fine"});
  }

  void opensByDragAndDrop() {
    QMimeData data;
    data.setUrls({QUrl::fromLocalFile(writeBall(*sandbox_, "one.nii")),
                  QUrl::fromLocalFile(writeBall(*sandbox_, "two words ü.nii.gz"))});
    QDragEnterEvent enter({50, 50}, Qt::CopyAction, &data, Qt::LeftButton, {});
    QCoreApplication::sendEvent(window_.get(), &enter);
    QVERIFY(enter.isAccepted());
    QDropEvent drop({50, 50}, Qt::CopyAction, &data, Qt::LeftButton, {});
    QCoreApplication::sendEvent(window_.get(), &drop);
    QTRY_COMPARE(lines(), (QStringList{"one", "two words ü"}));
    QMimeData text;
    text.setText("hello");
    QDragEnterEvent other({50, 50}, Qt::CopyAction, &text, Qt::LeftButton, {});
    other.setAccepted(false);
    QCoreApplication::sendEvent(window_.get(), &other);
    QVERIFY(!other.isAccepted());
  }

  void savesAsChosenAndReplacesNothingUnasked() {
    QVERIFY(QDir().mkpath(sandbox_->path("scans")));
    open({writeBall(*sandbox_, "scans/ball.nii.gz")});
    answerFileDialog(sandbox_->path("t1 1.5mm"));
    trigger("saveVolume");
    const QString whole = sandbox_->path("t1 1.5mm.nii.gz");
    QVERIFY(QFile::exists(whole));
    QFile kept(whole);
    QVERIFY(kept.open(QIODevice::WriteOnly));
    kept.write("precious");
    kept.close();
    QString text;
    answerBox("replaceBox", "No", &text);
    answerFileDialog(sandbox_->path("t1 1.5mm"));
    trigger("saveVolume");
    QVERIFY(text.contains("t1 1.5mm.nii.gz"));
    QCOMPARE(QFileInfo(whole).size(), qint64(8));
    answerFileDialog(sandbox_->path("plain"), "NRRD");
    trigger("saveVolume");
    QVERIFY(QFile::exists(sandbox_->path("plain.nrrd")) && !QFile::exists(sandbox_->path("plain.nii.gz")));
    answerFileDialog(sandbox_->path("v2.5"), "NRRD");
    trigger("saveVolume");
    QVERIFY(QFile::exists(sandbox_->path("v2.5.nrrd")));
  }

  void reconstructsWhatIsShown() {
    open({writeBall(*sandbox_, "one.nii"), writeBall(*sandbox_, "two.nii")});
    const auto input = [&] { return window_->reconstruction()->request().inputs.value(0).id; };
    const auto& volumes = host().document().volumes();
    QCOMPARE(input(), volumes[1]->id);
    auto* tree = window_->findChild<QTreeWidget*>("dataTree");
    tree->setCurrentItem(tree->topLevelItem(0));
    QCOMPARE(input(), volumes[0]->id);
    // Another one begins without a choice, not as the same scan once more.
    QTest::mouseClick(window_->findChild<QAbstractButton*>("addInput"), Qt::LeftButton);
    QCOMPARE(window_->reconstruction()->request().inputs.size(), 1);
    QTest::qWait(300);
    QVERIFY(button()->isEnabled());
    QTest::mouseClick(window_->findChild<QAbstractButton*>("removeInput"), Qt::LeftButton);
    // A result is no scan to begin with.
    window_->reconstruction()->suggestInput(volumes[0]->id);
    setQuick();
    reconstruct();
    QCOMPARE(window_->state()->volume()->name, QString("one reconstructed"));
    QCOMPARE(input(), volumes[0]->id);
  }

  void menusAndPanelsShareTheModel() {
    open({writeBall(*sandbox_, "ball.nii")});
    setQuick();
    reconstruct();
    const QString file = sandbox_->path("ball.innergs");
    QCOMPARE(host().saveModel(host().document().models()[0]->id, file), QString());
    open({file});
    const auto& models = host().document().models();
    QCOMPARE(int(models.size()), 2);
    auto* panel = window_->findChild<ui::ModelPanel*>();
    for (const int n : {1, 0}) {
      window_->query()->setModelId(models[n]->id);
      QCOMPARE(panel->modelId(), models[n]->id);
      trigger("ellipsoids");
      QVERIFY(models[n]->ellipsoidsShown && !models[1 - n]->ellipsoidsShown);
      trigger("ellipsoids");
    }
    panel->setModelId(models[1]->id);
    QCOMPARE(window_->query()->modelId(), models[1]->id);
    host().document().remove(QString(models[1]->id));
    QCOMPARE(panel->modelId(), models[0]->id);
    QCOMPARE(window_->query()->modelId(), models[0]->id);
  }

  void volumesElsewhereAreSeen() {
    Volume far = ball({24, 24, 24}, {1, 1, 1});
    far.geometry.origin[0] += 500;
    const QString file = sandbox_->path("far.nii");
    writeVolume(far, file.toStdString());
    open({writeBall(*sandbox_, "near.nii")});
    SliceView* axial = window_->views()->slice(2);
    axial->stepSlices(1);
    open({file});
    for (int axis = 0; axis < 3; ++axis) {
      SliceView* view = window_->views()->slice(axis);
      const QPointF at = view->fromRAS(window_->state()->crosshair());
      QVERIFY2(view->rect().contains(at.toPoint()),
               qPrintable(QString("%1: %2, %3").arg(axis).arg(at.x()).arg(at.y())));
    }
    QTest::qWait(100);
    const QImage seen = axial->grab().toImage();
    QVERIFY(qGray(seen.pixel(seen.width() / 2 + seen.width() / 20, seen.height() / 2 + seen.height() / 20)) >
            40);
  }

  /// In each panel, the list of data and the menu bar, which are seen at the same time.
  void everyAltKeyGoesToOnePlace() {
    for (const char* dock : {"reconstructDock", "queryDock", "modelDock", "logDock"}) {
      window_->showPanel(dock);
      QTRY_VERIFY(window_->findChild<QDockWidget*>(dock)->widget()->isVisible());
      QMap<QString, QString> places;
      const auto add = [&](const QString& words) {
        const QString key = QKeySequence::mnemonic(words).toString();
        if (key.isEmpty()) return QString();
        const QString before = places.value(key);
        places[key] = words;
        return before.isEmpty() ? QString() : QString("%1: %2 | %3 | %4").arg(dock, key, before, words);
      };
      for (const QAction* menu : window_->menuBar()->actions())
        QCOMPARE(add(menu->text()), QString());
      for (const auto* widget : window_->findChildren<QWidget*>()) {
        const auto* text = qobject_cast<const QLabel*>(widget);
        const auto* pressed = qobject_cast<const QAbstractButton*>(widget);
        const QWidget* home = widget;
        while (home && !qobject_cast<const QDockWidget*>(home))
          home = home->parentWidget();
        if (!home || (home->objectName() != dock && home->objectName() != "dataDock")) continue;
        if (!widget->isVisibleTo(home)) continue;
        if (text && text->buddy()) QCOMPARE(add(text->text()), QString());
        if (pressed) QCOMPARE(add(pressed->text()), QString());
      }
      QVERIFY(places.size() >= 4);
    }
  }

  void deleteClosesAnItem() {
    open({writeBall(*sandbox_, "one.nii"), writeBall(*sandbox_, "two.nii")});
    auto* tree = window_->findChild<QTreeWidget*>("dataTree");
    window_->activateWindow();
    QVERIFY(QTest::qWaitForWindowActive(window_.get()));
    tree->setFocus();
    QTest::keyClick(tree, Qt::Key_Delete);
    QCOMPARE(lines(), QStringList{"one"});
  }

  void asksAboutUnsavedResults() {
    open({writeBall(*sandbox_, "ball.nii")});
    setQuick();
    reconstruct();
    QString text;
    answerBox("unsavedBox", "Cancel", &text);
    QVERIFY(!window_->close());
    QVERIFY(text.contains("ball reconstructed") && text.contains("ball model"));
    QVERIFY(window_->isVisible());
    // Closing one of them asks as well.
    auto* tree = window_->findChild<QTreeWidget*>("dataTree");
    tree->setCurrentItem(tree->topLevelItem(2));
    answerBox("closeItemBox", "Discard");
    QTest::mouseClick(window_->findChild<QPushButton*>("closeItem"), Qt::LeftButton);
    QCOMPARE(lines(), (QStringList{"ball", "ball reconstructed"}));
    const QString file = sandbox_->path("saved.nrrd");
    answerBox("unsavedBox", "Save All");
    answerFileDialog(file);
    QVERIFY(window_->close());
    QVERIFY(QFile::exists(file));
  }

  void closedWhileRunning() {
    open({writeBall(*sandbox_, "ball.nii", {48, 48, 16})});
    setQuick(true);
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(host().isRunning());
    answerBox("runningBox", "Keep Running");
    QVERIFY(!window_->close());
    QTRY_VERIFY(!window_->findChild<QMessageBox*>("runningBox"));
    QVERIFY(host().isRunning() && window_->isVisible());
    answerBox("runningBox", "Stop and Close");
    window_->close();
    QTRY_VERIFY_WITH_TIMEOUT(!window_->isVisible(), 10000);
    QVERIFY(!host().isRunning());
  }

  void resultFinishedWhileClosingIsNotLost() {
    open({writeBall(*sandbox_, "ball.nii")});
    setQuick();
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    window_->close(); // asks; the fit ends meanwhile
    QTRY_VERIFY(window_->findChild<QMessageBox*>("runningBox"));
    QTRY_COMPARE_WITH_TIMEOUT(lines().size(), 3, 60000);
    QString text;
    answerBox("unsavedBox", "Cancel", &text);
    answerBox("runningBox", "Stop and Close");
    QTRY_VERIFY(text.contains("ball reconstructed"));
    QVERIFY(window_->isVisible());
  }

  void closedWhileAFileIsRead() {
    window_->open({writeBall(*sandbox_, "large.nii.gz", {128, 128, 60}, {1, 1, 1})});
    QVERIFY(host().background().isBusy());
    QVERIFY(!window_->close());
    QTRY_VERIFY_WITH_TIMEOUT(!window_->isVisible(), 20000);
    QVERIFY(!host().background().isBusy());
  }

  void windowDeletedWhileRunning() {
    open({writeBall(*sandbox_, "ball.nii", {48, 48, 16})});
    setQuick(true);
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(host().isRunning());
    QTest::qWait(100);
    window_.reset();
    QVERIFY(true); // without a crash
    window_ = std::make_unique<MainWindow>();
  }

  void renamesAndRemembers() {
    const QString file = writeBall(*sandbox_, "ball.nii");
    open({file});
    auto* tree = window_->findChild<QTreeWidget*>("dataTree");
    QTest::mouseClick(window_->findChild<QPushButton*>("renameItem"), Qt::LeftButton);
    auto* edit = tree->findChild<QLineEdit*>();
    QVERIFY(edit);
    edit->setText("Head of J.");
    QTest::keyClick(edit, Qt::Key_Return);
    QTRY_COMPARE(lines(), QStringList{"Head of J."});
    window_->resize(1111, 777);
    QVERIFY(window_->close()); // nothing to save
    window_ = std::make_unique<MainWindow>();
    window_->show();
    QTRY_COMPARE(window_->size(), QSize(1111, 777));
    auto* recent = window_->findChild<QMenu*>("recentMenu");
    QVERIFY(recent->actions().first()->text().contains("ball.nii"));
    recent->actions().first()->trigger();
    QTRY_COMPARE(lines(), QStringList{"ball"});
  }

  void staysResponsiveDuringAFit() {
    open({writeBall(*sandbox_, "big.nii", {96, 96, 48}, {0.8, 0.8, 1.6})});
    ui::Request request = window_->reconstruction()->request();
    request.settings.preset = Preset::Balanced;
    request.evaluateQuality = false;
    window_->reconstruction()->setRequest(request);
    QTRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(host().isRunning());
    QElapsedTimer clock;
    clock.start();
    const Gap gap = measureGap([&] { return clock.elapsed() > 4000 || !host().isRunning(); }, 6000);
    qInfo("longest event-loop gap during a fit: %.0f ms, of it %.0f ms of the main thread's own work",
          gap.wall, gap.cpu);
    host().cancel();
    QTRY_VERIFY_WITH_TIMEOUT(!host().isRunning(), 60000);
    // Times are for benchmarks: this only tells a loop that goes on from one that waits for the fit.
    QVERIFY2(gap.cpu <= 1000, qPrintable(QString::number(gap.cpu)));
  }

  void opensLargeFilesWithoutHoldingTheWindow() {
    const QString file = writeBall(*sandbox_, "large.nii.gz", {160, 160, 120}, {1, 1, 1});
    window_->open({file});
    const Gap gap = measureGap([&] { return !host().background().isBusy(); }, 60000);
    qInfo("longest event-loop gap while opening: %.0f ms, of it %.0f ms of the main thread's own work",
          gap.wall, gap.cpu);
    QVERIFY(gap.done);
    QCOMPARE(lines(), QStringList{"large"});
    QVERIFY2(gap.cpu <= 1000, qPrintable(QString::number(gap.cpu)));
  }

  void helpSaysWhatItIs() {
    QString text;
    answerBox("aboutBox", "Close", &text);
    trigger("about");
    QTRY_VERIFY(text.contains("not for clinical use") && text.contains("Apache"));
    text.clear();
    answerBox("citationBox", "Close", &text);
    trigger("citation");
    QTRY_VERIFY(text.contains("2508.13287"));
  }

  void opensRealVolumes() {
    const QString dicom = testData("G_dicom_mr_T1_oblique"),
                  thick = testData("F_icbm152_thick5mm_cor.nii.gz");
    if (dicom.isEmpty() || thick.isEmpty()) QSKIP("no test data: INNERGS_TEST_DATA is not set or incomplete");
    open({dicom, thick});
    QCOMPARE(lines().size(), 2);
    QCOMPARE(host().volumeInfo(host().document().volumes()[1]->id).orientation, QString("coronal"));
    QCOMPARE(lines().front(), QString("G_dicom_mr_T1_oblique"));
  }
};

int main(int argc, char** argv) {
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  QApplication app(argc, argv);
  AppTest test;
  return QTest::qExec(&test, argc, argv);
}
#include "AppTest.moc"
