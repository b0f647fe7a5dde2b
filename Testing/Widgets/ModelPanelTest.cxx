#include "Widgets/ModelPanel.h"
#include "FakeHost.h"
#include "Patience.h"
#include "Widgets/EllipsoidActor.h"
#include "Widgets/MessageLine.h"

#include "Core/Job/ReconstructionJob.h"
#include "vtkInnerGSModel.h"

#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkDataArray.h>
#include <vtkFieldData.h>
#include <vtkGlyph3DMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <QApplication>
#include <QCheckBox>
#include <QDir>
#include <QFile>
#include <QFileDialog>
#include <QLabel>
#include <QLocale>
#include <QPushButton>
#include <QSignalSpy>
#include <QTemporaryDir>
#include <QtTest>

#include <cmath>
#include <vector>

using namespace innergs;
using namespace innergs::ui;

namespace {

struct Shown {
  FakeHost host;
  QString id;
  ModelPanel panel;

  Shown() : id(host.addBallModel("Head / T1", 400)), panel(&host) {
    host.models[id].origin = "head, side";
    panel.resize(400, 400);
    panel.show();
    if (!QTest::qWaitForWindowExposed(&panel)) qWarning("not exposed");
    panel.setModelId(id);
  }
  QString text(const char* name) { return panel.findChild<QLabel*>(name)->text(); }
  QPushButton* button(const char* name) { return panel.findChild<QPushButton*>(name); }
  QString message() {
    auto* line = panel.findChild<MessageLine*>("modelMessage");
    return line->isVisible() ? line->text() : QString();
  }
  /// Opens a file dialog with a button and answers it.
  void answer(const char* name, const char* dialogName, const QString& file) {
    QTest::mouseClick(button(name), Qt::LeftButton);
    QFileDialog* dialog = nullptr;
    TRY_VERIFY((dialog = panel.findChild<QFileDialog*>(dialogName)));
    Q_EMIT dialog->fileSelected(file);
    dialog->reject();
    TRY_VERIFY(!panel.findChild<QFileDialog*>(dialogName));
  }
};

/// Three Gaussians: a heavy one in the background, a heavy elongated one, a light round one.
vtkSmartPointer<vtkInnerGSModel> threeGaussians() {
  auto core = std::make_shared<Model>();
  auto& field = core->field;
  field.intensityScale = 100;
  const float weights[3] = {2, 1, 0}, intensities[3] = {0, 0.8f, 0.9f};
  for (int i = 0; i < 3; ++i) {
    Gaussian g{};
    g.mean[0] = static_cast<float>(10 * i); // LPS: to the left
    g.quaternion[0] = 1;
    g.logScale[0] = i == 1 ? std::log(4.f) : 0;
    g.logWeight = weights[i];
    g.intensity = intensities[i];
    field.gaussians.push_back(g);
  }
  auto model = vtkSmartPointer<vtkInnerGSModel>::New();
  model->SetCoreModel(core);
  return model;
}

} // namespace

class ModelPanelTest : public QObject {
  Q_OBJECT
private Q_SLOTS:
  void saysWhatTheModelIs() {
    Shown shown;
    QCOMPARE(shown.panel.modelId(), shown.id);
    QCOMPARE(shown.text("modelGaussians"), QString("400"));
    QCOMPARE(shown.text("modelMemory"), QString("26 kB"));
    QCOMPARE(shown.text("modelSize"), QString("80.0 × 80.0 × 80.0 mm along R, A, S"));
    QCOMPARE(shown.text("modelOrigin"), QString("head, side"));
    QCOMPARE(shown.text("modelState"), QString("Not saved yet"));
    QVERIFY(shown.panel.findChild<QLabel*>("modelState")->font().bold());
    QCOMPARE(shown.text("modelDescription"), shown.host.models[shown.id].description);
  }

  void saysHowManyOfTheEllipsoidsAreDrawn() {
    Shown shown;
    auto* line = shown.panel.findChild<QLabel*>("modelEllipsoidsShown");
    QVERIFY(!line->isVisible());
    ModelInfo& info = shown.host.models[shown.id];
    info.ellipsoidsShown = true;
    info.gaussians = 1'045'528;
    info.ellipsoids = 20'000;
    Q_EMIT shown.host.modelsChanged();
    QVERIFY(line->isVisible());
    QCOMPARE(line->text(), QString("Showing 20,000 of 1,045,528 Gaussians."));
    QCOMPARE(shown.text("modelGaussians"), QString("1,045,528"));
  }

  void nothingChosenNothingToDo() {
    FakeHost host;
    ModelPanel panel(&host);
    QVERIFY(!panel.findChild<QPushButton*>("modelSave")->isEnabled());
    QVERIFY(!panel.findChild<QCheckBox*>("modelEllipsoids")->isEnabled());
    QVERIFY(panel.findChild<QPushButton*>("modelLoad")->isEnabled());
    QCOMPARE(panel.findChild<QLabel*>("modelState")->text(), QString("No model chosen"));
  }

  void savesAndTakesTheMarkAway() {
    QTemporaryDir folder;
    Shown shown;
    shown.host.setFolder(folder.path());
    shown.answer("modelSave", "modelSaveDialog", folder.filePath("sub/head"));
    QCOMPARE(shown.host.savedFiles, QStringList{folder.filePath("sub/head.innergs")});
    QCOMPARE(shown.host.folder(), folder.filePath("sub"));
    QCOMPARE(shown.text("modelState"), QString("Saved"));
    QVERIFY(!shown.panel.findChild<QLabel*>("modelState")->font().bold());
    QVERIFY(shown.message().contains("head.innergs"));
    Model core = *shown.host.modelData[shown.id]->GetCoreModel();
    core.field.residual = {{{2, 3, 4}, {0, 0, 0}, {1, 1, 1}, {}}, std::vector<float>(24, 0.25f)};
    shown.host.modelData[shown.id]->SetCoreModel(std::make_shared<const Model>(std::move(core)));
    shown.answer("modelSave", "modelSaveDialog", folder.filePath("head.PLY"));
    QCOMPARE(shown.host.savedFiles.last(), folder.filePath("head.PLY"));
    QVERIFY2(shown.message().contains("residual grid of 2x3x4 values (RMS "), qPrintable(shown.message()));
  }

  void namesTheFileAndItsSize() {
    QTemporaryDir folder;
    Shown shown;
    QFile file(folder.filePath("x.innergs"));
    QVERIFY(file.open(QIODevice::WriteOnly));
    file.write(QByteArray(3000, 'x'));
    file.close();
    shown.host.models[shown.id].file = file.fileName();
    Q_EMIT shown.host.modelsChanged();
    QCOMPARE(shown.text("modelFile"),
             QString("%1 (%2)").arg(QDir::toNativeSeparators(file.fileName()), "3 kB"));
    QVERIFY(file.remove());
    Q_EMIT shown.host.modelsChanged();
    QVERIFY(shown.text("modelFile").endsWith("(no longer there)"));
  }

  void loadsAndShowsWhatWasLoaded() {
    QTemporaryDir folder;
    Shown shown;
    QSignalSpy changed(&shown.panel, &ModelPanel::modelIdChanged);
    shown.answer("modelLoad", "modelLoadDialog", folder.filePath("other.innergs"));
    QCOMPARE(shown.host.loadedFiles, QStringList{folder.filePath("other.innergs")});
    QCOMPARE(shown.host.folder(), folder.path());
    QCOMPARE(changed.size(), 1);
    QVERIFY(shown.panel.modelId() != shown.id);
    QVERIFY(shown.message().contains("other.innergs"));
  }

  void errorsAreTheHostsSentences() {
    Shown shown;
    shown.host.modelError = "The file is <damaged>: choose another one.";
    shown.answer("modelLoad", "modelLoadDialog", "/nowhere/x.innergs");
    QVERIFY(shown.message().contains(shown.host.modelError));
    QCOMPARE(shown.panel.modelId(), shown.id);
    shown.host.modelError = "The disk is full: free some space.";
    shown.answer("modelSave", "modelSaveDialog", "/nowhere/x.innergs");
    QVERIFY(shown.message().contains(shown.host.modelError));
    QCOMPARE(shown.text("modelState"), QString("Not saved yet"));
    auto* box = shown.panel.findChild<QCheckBox*>("modelEllipsoids");
    box->click();
    QVERIFY(!box->isChecked()); // they are not shown
    shown.host.modelError.clear();
    box->click();
    QVERIFY(box->isChecked());
    QVERIFY(shown.host.models[shown.id].ellipsoidsShown);
    QCOMPARE(shown.message(), QString());
    box->click();
    QVERIFY(!shown.host.models[shown.id].ellipsoidsShown);
  }

  void modelThatGoesAway() {
    Shown shown;
    shown.host.models.remove(shown.id);
    shown.host.modelData.remove(shown.id);
    Q_EMIT shown.host.modelsChanged();
    QCOMPARE(shown.text("modelState"), QString("No model chosen"));
    QVERIFY(!shown.button("modelSave")->isEnabled());
  }

  void ellipsoidsAreTheHeaviestOfWhatIsThere() {
    EllipsoidOptions options;
    options.window = {0, 100};
    QString error;
    auto centres = ellipsoidCentres(threeGaussians(), options, &error);
    QVERIFY2(centres, qPrintable(error));
    QCOMPARE(centres->GetNumberOfPoints(), 2); // not the background's
    options.most = 1;
    centres = ellipsoidCentres(threeGaussians(), options, &error);
    QCOMPARE(centres->GetNumberOfPoints(), 1);
    QCOMPARE(centres->GetPoint(0)[0], -10.); // RAS
    QVERIFY(std::abs(centres->GetPointData()->GetArray("Intensity")->GetComponent(0, 0) - 80) < 1e-3);

    options.radius = 2;
    const auto surface = ellipsoidSurfaces(threeGaussians(), options, &error);
    QVERIFY(surface && surface->GetNumberOfPolys() > 20);
    QCOMPARE(surface->GetFieldData()->GetArray("Gaussians")->GetComponent(0, 0), 1.);
    double bounds[6];
    surface->GetBounds(bounds);
    QVERIFY(std::abs(bounds[1] - bounds[0] - 16) < 0.6); // twice two standard deviations of 4 mm
    QVERIFY(std::abs(bounds[5] - bounds[4] - 4) < 0.3);
    QVERIFY(std::abs(0.5 * (bounds[0] + bounds[1]) + 10) < 0.3);
    QVERIFY(surface->GetPointData()->GetArray("Intensity"));

    const auto actor = ellipsoidActor(centres, options);
    auto* mapper = vtkGlyph3DMapper::SafeDownCast(actor->GetMapper());
    QVERIFY(mapper);
    mapper->GetBounds(bounds);
    QVERIFY(bounds[0] < -10 && bounds[1] > -10);
  }

  void instancesLieAsTheSurfacesDo() {
    auto core = std::make_shared<Model>();
    Gaussian g{}; // elongated along (1, 1, 0) in LPS, which is (−1, −1, 0) in RAS, and slightly raised
    g.quaternion[0] = std::cos(3.14159265f / 8), g.quaternion[3] = std::sin(3.14159265f / 8);
    g.logScale[0] = std::log(8.f);
    g.intensity = 1;
    core->field.gaussians = {g};
    core->field.gaussians.push_back(g); // and a transverse one, smaller and to the left
    core->field.gaussians[1].quaternion[3] *= -1;
    core->field.gaussians[1].logScale[0] = std::log(4.f);
    core->field.gaussians[1].mean[0] = 12;
    vtkNew<vtkInnerGSModel> model;
    model->SetCoreModel(core);
    const EllipsoidOptions options;
    const auto actor = ellipsoidActor(ellipsoidCentres(model, options, nullptr), options);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(ellipsoidSurfaces(model, options, nullptr));
    vtkNew<vtkActor> surfaces;
    mapper->ScalarVisibilityOff();
    surfaces->SetMapper(mapper);
    const auto seen = [](vtkActor* one) {
      vtkNew<vtkRenderer> renderer;
      renderer->AddActor(one);
      renderer->GetActiveCamera()->ParallelProjectionOn();
      renderer->ResetCamera(-16, 16, -16, 16, -16, 16);
      vtkNew<vtkRenderWindow> window;
      window->SetOffScreenRendering(1);
      window->SetMultiSamples(0);
      window->SetSize(100, 100);
      window->AddRenderer(renderer);
      window->Render();
      vtkNew<vtkUnsignedCharArray> pixels;
      window->GetPixelData(0, 0, 99, 99, 1, pixels);
      std::vector<bool> lit(10000);
      for (int i = 0; i < 10000; ++i)
        lit[i] = pixels->GetComponent(i, 0) > 0;
      return lit;
    };
    const auto instances = seen(actor), whole = seen(surfaces);
    int both = 0, either = 0;
    for (int i = 0; i < 10000; ++i) {
      both += instances[i] && whole[i];
      either += instances[i] || whole[i];
    }
    QVERIFY2(both > 100 && both > 0.9 * either, qPrintable(QString("%1 of %2").arg(both).arg(either)));
    QVERIFY(whole[100 * 56 + 56] && !whole[100 * 56 + 44]); // R and A are right and up
  }

  void ellipsoidsOfNothingAreASentence() {
    QString error;
    vtkNew<vtkInnerGSModel> empty;
    QVERIFY(!ellipsoidCentres(empty, {}, &error));
    QVERIFY2(error.endsWith("."), qPrintable(error));
    QVERIFY(!ellipsoidCentres(nullptr, {}, &error));
    QVERIFY2(error.endsWith("."), qPrintable(error));
    EllipsoidOptions options;
    options.window = {0, 1e6};
    QVERIFY(!ellipsoidSurfaces(threeGaussians(), options, &error));
    QVERIFY2(error.contains("background"), qPrintable(error));
  }
};

int main(int argc, char** argv) {
  QLocale::setDefault(QLocale::c());
  QApplication app(argc, argv);
  ModelPanelTest test;
  return QTest::qExec(&test, argc, argv);
}
#include "ModelPanelTest.moc"
