// A user's complete session in the desktop app, by mouse and keyboard.
#include "AppWindowTest.h"

#include "IO/ModelFile.h"
#include "IO/VolumeIO.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Startup.h"
#include "Widgets/ModelPanel.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/TextFormat.h"

#include <QDir>
#include <QDockWidget>
#include <QLabel>
#include <QMenuBar>
#include <QScopeGuard>
#include <QTimer>
#include <QTranslator>

#include <vtkMatrix4x4.h>

#include <cmath>

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;
using innergs::app::MainWindow;
using innergs::app::SliceView;

namespace {

/// German for "&File", "axial", "%n %1 slices" and "%Ln Gaussians", as written by lrelease.
const char* const kGerman =
    "PLhkGMrvnJXNIRy/YKG93acAAAACZGVCAAAAIAAq0CUAAAAyAGjvfAAAAAAFYtHzAAAAcAaZu/MAAADjaQAAAUsDAAAADABhAHgA"
    "aQBhAGwAZQgAAAAABgAAAAVheGlhbAcAAAAMaW5uZXJnczo6YXBwAQMAAAAMACYARABhAHQAZQBpCAAAAAAGAAAABSZGaWxlBwAA"
    "ABhpbm5lcmdzOjphcHA6Ok1haW5XaW5kb3cBAwAAABoAJQBuACAAJQAxACAAUwBjAGgAaQBjAGgAdAMAAAAeACUAbgAgACUAMQAg"
    "AFMAYwBoAGkAYwBoAHQAZQBuCAAAAAAGAAAADCVuICUxIHNsaWNlcwcAAAAVaW5uZXJnczo6dWk6OklucHV0Um93AQMAAAAUACUA"
    "TABuACAARwBsAG8AYwBrAGUDAAAAFgAlAEwAbgAgAEcAbABvAGMAawBlAG4IAAAAAAYAAAANJUxuIEdhdXNzaWFucwcAAAAXaW5u"
    "ZXJnczo6dWk6OlRleHRGb3JtYXQBiAAAAAIBAQ==";

} // namespace

class AppTest : public AppWindowTest {
  Q_OBJECT
private Q_SLOTS:
  void wholePath() {
    // Open.
    open({writeBall(*sandbox_, "ball.nii.gz", {32, 32, 10}, {1.2, 1.2, 4})});
    QCOMPARE(lines(), QStringList{"ball"});
    QCOMPARE(window_->state()->volume()->name, QString("ball"));
    // Reconstruct, cancel, reconstruct.
    setQuick(true);
    QSignalSpy progress(&host(), &AppHost::progressed);
    start();
    QVERIFY(progress.wait(kPatience));
    QSignalSpy cancelled(&host(), &AppHost::cancelled);
    QTest::mouseClick(button(), Qt::LeftButton);
    QVERIFY(cancelled.wait(kPatience));
    QCOMPARE(lines(), QStringList{"ball"});
    setQuick();
    window_->state()->setWindow(5, 66);
    reconstruct();
    QCOMPARE(lines(), (QStringList{"ball", "ball reconstructed", "ball model"}));
    // The result is shown immediately with the same window and level.
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
    TRY_VERIFY(window_->findChild<QPushButton*>("queryExportVolume")->isEnabled());
    QTest::mouseClick(window_->findChild<QPushButton*>("queryExportVolume"), Qt::LeftButton);
    TRY_COMPARE(lines().size(), 4);
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

  void reconstructsWhatIsShown() {
    open({writeBall(*sandbox_, "one.nii"), writeBall(*sandbox_, "two.nii")});
    const auto input = [&] { return window_->reconstruction()->request().inputs.value(0).id; };
    const auto& volumes = host().document().volumes();
    QCOMPARE(input(), volumes[1]->id);
    chooseLine(0);
    QCOMPARE(input(), volumes[0]->id);
    // Another row starts empty, not with the same scan again.
    QTest::mouseClick(window_->findChild<QAbstractButton*>("addInput"), Qt::LeftButton);
    QCOMPARE(window_->reconstruction()->request().inputs.size(), 1);
    TRY_VERIFY(!window_->findChild<QTimer*>("estimateTimer")->isActive());
    QVERIFY(button()->isEnabled());
    QTest::mouseClick(window_->findChild<QAbstractButton*>("removeInput"), Qt::LeftButton);
    // A result is not preselected as a scan.
    window_->reconstruction()->suggestInput(volumes[0]->id);
    setQuick();
    reconstruct();
    QCOMPARE(window_->state()->volume()->name, QString("one reconstructed"));
    QCOMPARE(input(), volumes[0]->id);
    // Nor when it is saved and shown again.
    const QString result = volumes[2]->id;
    QCOMPARE(host().save(result, sandbox_->path("result.nii")), QString());
    trigger("nextVolume");
    QCOMPARE(input(), volumes[0]->id);
    trigger("previousVolume");
    QCOMPARE(window_->state()->volumeId(), result);
    QCOMPARE(input(), volumes[0]->id);
    // Other scans are shown during a run: this one is still being reconstructed.
    setQuick(true);
    start();
    chooseLine(1);
    QCOMPARE(window_->state()->volumeId(), volumes[1]->id);
    open({writeBall(*sandbox_, "three.nii")});
    QCOMPARE(input(), volumes[0]->id);
    host().cancel();
    TRY_VERIFY(!host().isRunning());
    chooseLine(1);
    window_->state()->setVolumeId(volumes[3]->id);
    QCOMPARE(input(), volumes[3]->id);
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

  /// In each panel, the data list and the menu bar, which are visible at the same time.
  void everyAltKeyGoesToOnePlace() {
    for (const char* dock : {"reconstructDock", "queryDock", "modelDock", "logDock"}) {
      window_->showPanel(dock);
      TRY_VERIFY(window_->findChild<QDockWidget*>(dock)->widget()->isVisible());
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

  void staysResponsiveDuringAFit() {
    open({writeBall(*sandbox_, "big.nii", {64, 64, 32}, {1.2, 1.2, 2.4})});
    ui::Request request = window_->reconstruction()->request();
    request.settings.preset = Preset::Balanced;
    request.settings.prediction = PredictionKind::None;
    request.evaluateQuality = false;
    window_->reconstruction()->setRequest(request);
    QSignalSpy progress(&host(), &AppHost::progressed);
    start();
    TRY_VERIFY(progress.count() > 40);
    QVERIFY(host().isRunning());
    host().cancel();
    TRY_VERIFY(!host().isRunning());
  }

  void speaksTheUsersLanguage() {
    const QStringList folders{sandbox_->path("absent"), sandbox_->path("translations")};
    const QLocale german(QLocale::German, QLocale::Germany);
    QVERIFY(!app::loadTranslations(german, folders)); // as without any
    QVERIFY(qApp->findChildren<QTranslator*>().isEmpty());
    QVERIFY(QDir().mkpath(folders[1]));
    QFile file(folders[1] + "/innergs_de.qm");
    QVERIFY(file.open(QIODevice::WriteOnly));
    file.write(QByteArray::fromBase64(kGerman));
    file.close();
    QVERIFY(!app::loadTranslations(QLocale(QLocale::French, QLocale::France), folders));
    QVERIFY(app::loadTranslations(german, folders));
    const auto back = qScopeGuard([] { qDeleteAll(qApp->findChildren<QTranslator*>()); });
    window_ = std::make_unique<MainWindow>();
    QCOMPARE(window_->menuBar()->actions().first()->text(), QString("&Datei"));
    open({writeBall(*sandbox_, "ball.nii")});
    const QString text = window_->findChild<QLabel*>("inputDescription")->text();
    QVERIFY2(text.startsWith("10 axiale Schichten"), qPrintable(text));
    QCOMPARE(ui::gaussiansText(1).section(' ', 1), QString("Glocke"));
    QCOMPARE(ui::gaussiansText(2).section(' ', 1), QString("Glocken"));
    QVERIFY(app::translationFolders().first().startsWith(QCoreApplication::applicationDirPath()));
  }

  void helpSaysWhatItIs() {
    QString text;
    answerBox("aboutBox", "Close", &text);
    trigger("about");
    TRY_VERIFY(text.contains("not for clinical use") && text.contains("Apache"));
    text.clear();
    answerBox("citationBox", "Close", &text);
    trigger("citation");
    TRY_VERIFY(text.contains("2508.13287"));
  }
};

int main(int argc, char** argv) {
  return runAppTest<AppTest>(argc, argv);
}
#include "AppTest.moc"
