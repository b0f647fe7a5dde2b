#include "Widgets/SettingsPanel.h"

#include <QCheckBox>
#include <QComboBox>
#include <QLineEdit>
#include <QPushButton>
#include <QSignalSpy>
#include <QTest>

#include "SettingTexts.h"
#include "TestTools.h"
#include "Widgets/NumberSpin.h"

using innergs::Settings;
using innergs::ui::NumberSpin;
using innergs::ui::SettingsPanel;

namespace {

/// Every field differs from its default.
Settings unusualSettings() {
  Settings s;
  for (const innergs::Setting& row : innergs::settingsTable())
    if (row.group != innergs::Setting::Group::Dynamic) row.setText(s, innergs::test::otherText(row));
  s.gaussians = 12345;
  s.plateau.threshold = 3e-5;
  s.threads = 3;
  return s;
}

void compare(const Settings& a, const Settings& b) {
  for (const innergs::Setting& row : innergs::settingsTable())
    QVERIFY2(row.textIn(a) == row.textIn(b), row.name);
}

} // namespace

class SettingsPanelTest : public QObject {
  Q_OBJECT

private Q_SLOTS:
  void init() {
    panel_ = std::make_unique<SettingsPanel>();
    QVERIFY(showActive(*panel_));
  }
  void cleanup() { panel_.reset(); }

  void defaultsAreTheProgramsOwn() { compare(panel_->settings(), Settings()); }

  void whatWasSetComesBack() {
    panel_->setSettings(unusualSettings());
    compare(panel_->settings(), unusualSettings());
    QCOMPARE(combo("loss")->currentText(), QString("Huber"));
    QCOMPARE(spin("gaussians")->text(), QString("12345"));
    QCOMPARE(spin("plateauThreshold")->text(), QString("3e-05"));
    QCOMPARE(spin("threads")->text(), QString("3"));
  }

  void anEditChangesItsFieldAlone() {
    panel_->setSettings(unusualSettings());
    type("iterations", "42");
    Settings expected = unusualSettings();
    expected.iterations = 42;
    compare(panel_->settings(), expected);
  }

  /// Every field is editable by keyboard, and an emptied one is automatic again.
  void numbersAreTypedAndEmptied() {
    for (const char* name : {"gaussians", "maxGaussians", "iterations", "ensembleSize", "cutoff",
                             "lossWeight", "ssimWeight", "beta1", "beta2", "densifyEvery"}) {
      const QString typed = QString(name).startsWith("beta") ? "0.5" : "2";
      type(name, typed);
      QVERIFY2(spin(name)->number() == typed.toDouble(), name);
      type(name, "");
      QVERIFY2(!spin(name)->number(), name);
      QVERIFY2(spin(name)->text().startsWith("automatic"), qPrintable(spin(name)->text()));
    }
    compare(panel_->settings(), Settings());
  }

  void stepsLeaveAndReachAutomatic() {
    NumberSpin* cutoff = spin("cutoff");
    QTest::keyClick(cutoff, Qt::Key_Up);
    QCOMPARE(panel_->settings().cutoff, std::optional<double>(2.2));
    for (int i = 0; i < 40 && cutoff->number(); ++i)
      QTest::keyClick(cutoff, Qt::Key_Down);
    QVERIFY(!panel_->settings().cutoff);
    NumberSpin* weight = spin("ssimWeight");
    weight->setNumber(0);
    QTest::keyClick(weight, Qt::Key_Up);
    QCOMPARE(panel_->settings().ssimWeight, std::optional<double>(0.1));
  }

  void outOfRangeIsBroughtBack() {
    type("cutoff", "99");
    QVERIFY(panel_->settings().cutoff.value_or(0) <= 5);
    type("beta1", "1.5");
    QVERIFY(panel_->settings().beta1.value_or(0) < 1);
    innergs::checkSettings(panel_->settings());
  }

  void automaticSaysWhatThePresetLeadsTo() {
    QCOMPARE(combo("loss")->currentText(), QString("automatic (L2)"));
    QCOMPARE(spin("densifyEvery")->text(), QString("automatic (never)"));
    Settings paper;
    paper.preset = innergs::Preset::Paper;
    panel_->setSettings(paper);
    QCOMPARE(combo("loss")->currentText(), QString("automatic (L1)"));
    QCOMPARE(combo("blending")->currentText(), QString("automatic (alpha)"));
    QCOMPARE(spin("densifyEvery")->text(), QString("automatic (10)"));
    QVERIFY(!panel_->settings().loss && !panel_->settings().densifyEvery);
  }

  void whatHasNoEffectIsGrey() {
    QVERIFY(!spin("huberDelta")->isEnabled());
    QVERIFY(!spin("plateauPatience")->isEnabled());
    QVERIFY(!spin("splitSize")->isEnabled());
    combo("loss")->setFocus();
    QTest::keyClick(combo("loss"), Qt::Key_End);
    QCOMPARE(panel_->settings().loss, std::optional(innergs::LossKind::Huber));
    QVERIFY(spin("huberDelta")->isEnabled());
    combo("schedule")->setCurrentIndex(2);
    QVERIFY(spin("plateauPatience")->isEnabled());
    type("densifyEvery", "5");
    QVERIFY(spin("splitSize")->isEnabled());
  }

  void defaultsAreRestoredButForPresetAndDevice() {
    panel_->setSettings(unusualSettings());
    QSignalSpy changed(panel_.get(), &SettingsPanel::settingsChanged);
    auto* button = panel_->findChild<QPushButton*>("restoreDefaults");
    button->setFocus();
    QTest::keyClick(button, Qt::Key_Space);
    QCOMPARE(changed.count(), 1);
    Settings expected;
    expected.preset = unusualSettings().preset;
    expected.device = unusualSettings().device;
    expected.fill = unusualSettings().fill;
    compare(panel_->settings(), expected);
    QVERIFY(combo("loss")->currentText().startsWith("automatic"));
    QVERIFY(panel_->findChild<QCheckBox*>("consistency")->isChecked());
  }

  /// Scrolling the panel must not edit the field under the pointer.
  void wheelEditsNothing() {
    panel_->findChild<QPushButton*>("restoreDefaults")->setFocus();
    for (QWidget* field :
         {static_cast<QWidget*>(combo("blending")), static_cast<QWidget*>(spin("threads"))}) {
      const QPointF centre(field->rect().center());
      QWheelEvent wheel(centre, field->mapToGlobal(centre.toPoint()), {}, {0, -120}, Qt::NoButton,
                        Qt::NoModifier, Qt::NoScrollPhase, false);
      QCoreApplication::sendEvent(field, &wheel);
    }
    compare(panel_->settings(), Settings());
  }

  void everySettingOfTheTableHasAField() {
    for (const innergs::Setting& row : innergs::settingsTable())
      if (row.group != innergs::Setting::Group::Basic && row.group != innergs::Setting::Group::Dynamic) {
        auto* field = panel_->findChild<QWidget*>(row.name);
        QVERIFY2(field, row.name);
        QVERIFY2(field->toolTip().contains(QString(row.text).toHtmlEscaped()), row.name);
      }
  }

private:
  QComboBox* combo(const char* name) { return panel_->findChild<QComboBox*>(name); }
  NumberSpin* spin(const char* name) { return panel_->findChild<NumberSpin*>(name); }
  void type(const char* name, const QString& text) {
    NumberSpin* field = spin(name);
    field->setFocus();
    field->selectAll();
    QTest::keyClick(field, Qt::Key_Delete);
    QTest::keyClicks(field, text);
    QTest::keyClick(field, Qt::Key_Return);
  }

  std::unique_ptr<SettingsPanel> panel_;
};

QTEST_MAIN(SettingsPanelTest)
#include "SettingsPanelTest.moc"
