#include "Widgets/FindPanel.h"
#include "FakeHost.h"
#include "Features/BoxPhantom.h"
#include "Motion/MovingPhantom.h"
#include "Patience.h"
#include "Widgets/MessageLine.h"

#include "Core/Base/Error.h"
#include "Core/Model/Model.h"
#include "Core/Motion/DynamicJob.h"
#include "vtkInnerGSDynamicModel.h"
#include "vtkInnerGSModel.h"

#include <QCheckBox>
#include <QComboBox>
#include <QDoubleSpinBox>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QProgressBar>
#include <QPushButton>
#include <QSignalSpy>
#include <QtTest>

#include <numeric>

using namespace innergs;
using namespace innergs::ui;

namespace {

/// Labels of three boxes, and what the panel does with segments.
class TeachingHost : public FakeHost {
public:
  testing::BoxPhantom phantom;
  NamedLabels labels{phantom.labels, {{1, "liver"}, {2, "kidney_left"}, {3, "kidney_right"}}};
  vtkSmartPointer<vtkInnerGSDynamicModel> dynamic; // null: the model does not move
  double time = 0;                                 // s, that it is shown at
  QString refusal, failure;                        // of labels: at the start, on the worker
  MadeSegments shown;
  int previews = 0;
  QStringList kept;
  QString keepError;

  TeachingHost() { roles << Role::Labels; }
  QString addModel() {
    QString id = addBallModel("Boxes");
    auto core = std::make_shared<Model>();
    core->field = phantom.field;
    modelData[id]->SetCoreModel(core);
    Q_EMIT modelsChanged();
    return id;
  }
  std::function<NamedLabels(const std::stop_token&)> labelsFor(const QString&, const QString&, const QString&,
                                                               QString* error) override {
    *error = refusal;
    if (!refusal.isEmpty()) return {};
    return [this](const std::stop_token&) {
      if (!failure.isEmpty()) throw Error(ErrorCode::InvalidArgument, failure.toStdString());
      return labels;
    };
  }
  QString setFeatures(const QString& id, const std::shared_ptr<const FeatureModel>& features) override {
    if (dynamic) {
      dynamic->SetField(dynamic->GetField(), features);
      modelData[id] = vtkSmartPointer<vtkInnerGSModel>::Take(dynamic->NewModelAt(time));
    } else {
      modelData[id]->SetCoreModel(modelData[id]->GetCoreModel(), features);
    }
    Q_EMIT modelsChanged();
    return {};
  }
  void previewSegments(const QString&, const MadeSegments& made) override {
    shown = made;
    ++previews;
  }
  QString addSegments(const QString&, const MadeSegments& made, QString* error) override {
    *error = keepError;
    if (!keepError.isEmpty()) return {};
    for (const auto& [terms, segment] : made.segments)
      kept << QString::fromStdString(terms.name);
    return "Boxes segments";
  }
};

struct Shown {
  TeachingHost host;
  QString id;
  FindPanel panel;

  Shown() : id(host.addModel()), panel(&host) {
    panel.resize(420, 700);
    panel.show();
    if (!QTest::qWaitForWindowExposed(&panel)) qWarning("not exposed");
    panel.setModelId(id);
    panel.findChild<Selector*>("findLabels")->setCurrentId("head");
  }
  template <class Widget>
  Widget* part(const char* name) {
    return panel.findChild<Widget*>(name);
  }
  QString message(const char* name) {
    auto* line = part<MessageLine>(name);
    return line->isVisible() ? line->text() : QString();
  }
  void learn() {
    QTest::mouseClick(part<QPushButton>("findLearn"), Qt::LeftButton);
    TRY_VERIFY(!panel.isLearning());
  }
  /// Types a query and waits for the answer.
  void ask(const QString& text) {
    auto* line = part<QComboBox>("findText")->lineEdit();
    line->setFocus();
    line->selectAll();
    QTest::keyClicks(line, text);
    part<MessageLine>("findAnswer")->clear();
    QTest::keyClick(line, Qt::Key_Return);
    TRY_VERIFY(!message("findAnswer").isEmpty());
  }
  std::int64_t voxels() const {
    return std::accumulate(host.shown.segments.begin(), host.shown.segments.end(), std::int64_t{0},
                           [](std::int64_t sum, const auto& s) { return sum + s.second.voxels; });
  }
};

} // namespace

class FindPanelTest : public QObject {
  Q_OBJECT
private Q_SLOTS:
  void initTestCase() { qunsetenv("INNERGS_TEXT_MODEL"); } // the lexicon alone answers

  void choosesTheOnlyModelByItself() {
    TeachingHost host;
    FindPanel panel(&host);
    QVERIFY(panel.modelId().isEmpty());
    const QString first = host.addModel();
    QCOMPARE(panel.modelId(), first);
    panel.setModelId({}); // a person's choice
    QVERIFY(panel.modelId().isEmpty());
    Q_EMIT host.modelsChanged();
    QVERIFY(panel.modelId().isEmpty());
    FindPanel later(&host);
    QCOMPARE(later.modelId(), first);
    host.addModel();
    FindPanel undecided(&host);
    QVERIFY(undecided.modelId().isEmpty());
  }

  void aMovingModelLearnsAndIsFollowed() {
    const TimeSeries series = testing::movingPhantom(testing::evenTimes(5));
    Settings settings;
    settings.kind = DynamicKind::Motion;
    settings.gaussians = 400;
    const auto field = std::make_shared<const DynamicField>(*DynamicJob(series, settings).run().field);
    Shown shown;
    shown.host.dynamic = vtkSmartPointer<vtkInnerGSDynamicModel>::New();
    shown.host.dynamic->SetField(field);
    const auto showAt = [&](double time) {
      shown.host.time = time;
      shown.host.modelData[shown.id] =
          vtkSmartPointer<vtkInnerGSModel>::Take(shown.host.dynamic->NewModelAt(time));
      Q_EMIT shown.host.modelsChanged();
    };
    const auto diceAt = [&](double time) {
      Labelmap found{series.geometry, std::vector<std::uint16_t>(series.frames[0].size(), 0), {}};
      for (const auto& [terms, segment] : shown.host.shown.segments) {
        const auto& mask = segment.mask;
        forEachVoxel(segment, shown.host.shown.grid.size,
                     [&](std::size_t voxel, std::size_t part) { found.voxels[voxel] = mask[part]; });
      }
      return testing::dice(found, testing::movingLabels(series.geometry, time), 1);
    };
    showAt(0.5);
    QVERIFY(shown.part<QPushButton>("findLearn")->toolTip().contains("0.5 s"));
    shown.host.labels = {testing::movingLabels(series.geometry, 0.5), {{1, "lunate"}, {2, "capitate"}}};
    QTest::mouseClick(shown.part<QPushButton>("findLearn"), Qt::LeftButton);
    showAt(0); // meanwhile
    TRY_VERIFY(!shown.panel.isLearning());
    QVERIFY(shown.part<QLabel>("findState")->text().contains("knows 2 structures"));
    shown.ask("lunate");
    QVERIFY2(diceAt(0) > 0.9, qPrintable(QString::number(diceAt(0))));
    const int before = shown.host.previews;
    showAt(1.75); // asks again by itself
    TRY_VERIFY(shown.host.previews > before);
    QVERIFY2(diceAt(1.75) > 0.9, qPrintable(QString::number(diceAt(1.75))));
    QVERIFY(diceAt(1.75) > diceAt(0));
    QCOMPARE(shown.part<QListWidget>("findCandidates")->count(), 1);
  }

  void learnsFindsAndKeeps() {
    Shown shown;
    QVERIFY(!shown.part<QComboBox>("findText")->isEnabled());
    QVERIFY(shown.part<QLabel>("findState")->text().contains("knows no structures yet"));
    QSignalSpy models(&shown.host, &Host::modelsChanged);
    shown.learn();
    QCOMPARE(models.count(), 1);
    QVERIFY2(shown.message("findLearningMessage").startsWith("Learned 3 structures"),
             qPrintable(shown.message("findLearningMessage")));
    QCOMPARE(shown.part<QLabel>("findState")->text(), QString("This model knows 3 structures."));
    QVERIFY(!shown.part<QPushButton>("findAdd")->isEnabled());

    shown.ask("hepar");
    QCOMPARE(shown.message("findAnswer"), QString("\"hepar\" is liver."));
    QCOMPARE(shown.host.shown.segments.size(), std::size_t(1));
    const std::int64_t all = shown.voxels();
    QCOMPARE(all, std::int64_t(std::count(shown.host.phantom.labels.voxels.begin(),
                                          shown.host.phantom.labels.voxels.end(), 1)));
    QVERIFY(shown.part<QLabel>("findVolume")->text().contains("liver: "));
    // Options are seen at once.
    const int before = shown.host.previews;
    shown.part<QCheckBox>("findThresholdOn")->click();
    TRY_COMPARE(shown.host.previews, before + 1);
    shown.part<QCheckBox>("findThresholdOn")->click();
    TRY_COMPARE(shown.host.previews, before + 2);
    shown.part<QDoubleSpinBox>("findSmoothing")->setValue(2);
    TRY_VERIFY(shown.voxels() < all); // corners go
    shown.part<QDoubleSpinBox>("findSmoothing")->setValue(0);
    TRY_COMPARE(shown.voxels(), all);
    QTest::mouseClick(shown.part<QPushButton>("findAdd"), Qt::LeftButton);
    QCOMPARE(shown.host.kept, QStringList{"liver"});
    QCOMPARE(shown.message("findAnswer"), QString("Kept in 'Boxes segments'."));
    shown.host.keepError = "The scene is closed.";
    QTest::mouseClick(shown.part<QPushButton>("findAdd"), Qt::LeftButton);
    QCOMPARE(shown.message("findAnswer"), shown.host.keepError);
  }

  void anOpenSideShowsBothAndLetsChoose() {
    Shown shown;
    shown.learn();
    shown.ask("kidney");
    auto* list = shown.part<QListWidget>("findCandidates");
    QCOMPARE(list->count(), 2);
    QVERIFY(list->item(1)->text().startsWith("kidney_right"));
    QVERIFY(list->item(0)->font().bold() && list->item(1)->font().bold());
    QCOMPARE(shown.host.shown.segments.size(), std::size_t(2));
    list->setCurrentRow(1);
    TRY_COMPARE(shown.host.shown.segments.size(), std::size_t(1));
    QCOMPARE(shown.host.shown.segments[0].first.name, std::string("kidney_right"));
    QCOMPARE(list->count(), 2);                    // still to choose from
    shown.part<QCheckBox>("findLargest")->click(); // of the chosen one
    QTest::mouseClick(shown.part<QPushButton>("findAdd"), Qt::LeftButton);
    QCOMPARE(shown.host.kept, QStringList{"kidney_right"});
  }

  void saysWhatIsNotThere() {
    Shown shown;
    shown.learn();
    shown.ask("liver");
    for (const auto& [text, words] : {std::pair<QString, QString>{"spleen", "not in this volume"},
                                      {"bicycle", "matches no segment"},
                                      {"liver mass", "matches no segment"},
                                      {"---", "empty"},
                                      {QString(400, 'x'), "too long"}}) {
      shown.ask(text);
      QVERIFY2(shown.message("findAnswer").contains(words), qPrintable(shown.message("findAnswer")));
      QVERIFY(shown.host.shown.segments.empty());
      QVERIFY(!shown.part<QPushButton>("findAdd")->isEnabled());
    }
    shown.part<QComboBox>("findText")->setEditText("  ");
    QTest::mouseClick(shown.part<QPushButton>("findGo"), Qt::LeftButton);
    QVERIFY(shown.message("findAnswer").startsWith("Type a structure"));
    auto* minimum = shown.part<QDoubleSpinBox>("findMinimum");
    minimum->setValue(5000);
    shown.ask("liver");
    QVERIFY(shown.part<QLabel>("findVolume")->text().contains("lower the threshold"));
    QVERIFY(!shown.part<QPushButton>("findAdd")->isEnabled());
  }

  void remembersQueries() {
    Shown shown;
    shown.learn();
    for (const char* text : {"liver", "left kidney", "liver", "bicycle"})
      shown.ask(text);
    auto* text = shown.part<QComboBox>("findText");
    QCOMPARE(text->count(), 2);
    QCOMPARE(text->itemText(0), QString("liver"));
    QCOMPARE(text->itemText(1), QString("left kidney"));
  }

  void asksOnceForAnEarlierQuery() {
    Shown shown;
    shown.learn();
    shown.ask("left kidney");
    shown.ask("liver");
    const QSignalSpy answers(shown.panel.findChild<SegmentWorker*>(), &SegmentWorker::found);
    for (int n = 0; n < 20; ++n)
      shown.ask(n % 2 ? "liver" : "left kidney");
    QCOMPARE(answers.count(), 20);
  }

  void saysWhyItCannotLearn() {
    Shown shown;
    shown.host.refusal = "The labels are no longer open.";
    QTest::mouseClick(shown.part<QPushButton>("findLearn"), Qt::LeftButton);
    QCOMPARE(shown.message("findLearningMessage"), shown.host.refusal);
    shown.host.refusal.clear();
    shown.host.failure = "The labels have no names.";
    shown.learn();
    QCOMPARE(shown.message("findLearningMessage"), shown.host.failure);
    shown.host.failure.clear();
    shown.host.labels.labels.geometry.origin[0] += 900;
    shown.learn();
    QVERIFY(shown.message("findLearningMessage").contains("same patient"));
    QCOMPARE(shown.host.modelData[shown.id]->GetNumberOfSegments(), 0);
    shown.panel.findChild<Selector*>("findLabels")->setCurrentId(QString());
    QVERIFY(!shown.part<QPushButton>("findLearn")->isEnabled());
  }

  void canBeCancelled() {
    Shown shown;
    auto* button = shown.part<QPushButton>("findLearn");
    QTest::mouseClick(button, Qt::LeftButton);
    QVERIFY(shown.panel.isLearning());
    QVERIFY(shown.part<QProgressBar>("findProgress")->isVisible());
    QVERIFY(button->text().contains("Cancel"));
    QTest::mouseClick(button, Qt::LeftButton);
    TRY_VERIFY(!shown.panel.isLearning());
    QVERIFY(shown.message("findLearningMessage").startsWith("Stopped"));
    QVERIFY(!shown.part<QProgressBar>("findProgress")->isVisible());
    QCOMPARE(shown.host.modelData[shown.id]->GetNumberOfSegments(), 0);
  }

  void aModelReplacedMeanwhileLearnsNothing() {
    Shown shown;
    QTest::mouseClick(shown.part<QPushButton>("findLearn"), Qt::LeftButton);
    auto core = std::make_shared<Model>(*shown.host.modelData[shown.id]->GetCoreModel());
    core->field.gaussians.pop_back();
    shown.host.modelData[shown.id]->SetCoreModel(core);
    TRY_VERIFY(!shown.panel.isLearning());
    QVERIFY(shown.message("findLearningMessage").contains("replaced while learning"));
    QCOMPARE(shown.host.modelData[shown.id]->GetNumberOfSegments(), 0);
  }

  void anotherModelHasAnotherView() {
    Shown shown;
    shown.learn();
    shown.ask("liver");
    QVERIFY(!shown.host.shown.segments.empty());
    const QString other = shown.host.addBallModel("Ball");
    QSignalSpy changed(&shown.panel, &FindPanel::modelIdChanged);
    shown.panel.setModelId(other);
    QCOMPARE(changed.count(), 1);
    QVERIFY(shown.host.shown.segments.empty());
    QCOMPARE(shown.part<QListWidget>("findCandidates")->count(), 0);
    QVERIFY(shown.part<QLabel>("findState")->text().contains("knows no structures yet"));
    shown.panel.setModelId(shown.id);
    shown.panel.find("liver");
    TRY_COMPARE(shown.message("findAnswer"), QString("\"liver\" is liver."));
  }
};

QTEST_MAIN(FindPanelTest)
#include "FindPanelTest.moc"
