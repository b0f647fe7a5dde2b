#pragma once
#include "FakeHost.h"
#include "Patience.h"
#include "TestTools.h"
#include "Widgets/InputRow.h"
#include "Widgets/MessageLine.h"
#include "Widgets/ReconstructionPanel.h"

#include <QPushButton>
#include <QScrollArea>
#include <QScrollBar>
#include <QTimer>

/// A reconstruction panel, 400 pixels wide, on a fake host, with a user's actions.
class ReconstructionPanelFixture : public QObject {
  Q_OBJECT

private Q_SLOTS:
  void init() { make({}); }
  void cleanup() {
    area_.reset();
    host_.reset();
  }

protected:
  void make(const QVector<innergs::ui::Host::Role>& roles) {
    area_.reset();
    host_ = std::make_unique<FakeHost>();
    if (!roles.isEmpty()) host_->roles = roles;
    area_ = std::make_unique<QScrollArea>();
    panel_ = new innergs::ui::ReconstructionPanel(host_.get());
    area_->setWidget(panel_);
    area_->setWidgetResizable(true);
    area_->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    area_->resize(400, 760);
    QVERIFY(showActive(*area_));
  }
  template <class T>
  T* child(const char* name) {
    return panel_->findChild<T*>(name);
  }
  QPushButton* button() { return child<QPushButton>("reconstruct"); }
  /// Whether the estimate for the latest changes is still pending.
  bool isEstimateAwaited() { return child<QTimer>("estimateTimer")->isActive(); }
  QString label(const char* name) { return child<QLabel>(name)->text(); }
  QString line(const char* name) { return child<innergs::ui::MessageLine>(name)->text(); }
  bool isShown(const char* name) { return child<QWidget>(name)->isVisible(); }
  QVector<innergs::ui::InputRow*> rows() {
    QVector<innergs::ui::InputRow*> found;
    for (auto* row : panel_->findChildren<innergs::ui::InputRow*>())
      if (row->isVisible()) found << row;
    return found;
  }
  void select(innergs::ui::Selector* selector, const QString& id) {
    auto* combo = selector->findChild<QComboBox*>();
    combo->setFocus();
    QTest::keyClick(combo, Qt::Key_Home);
    for (int i = 0; i < combo->count() && selector->currentId() != id; ++i)
      QTest::keyClick(combo, Qt::Key_Down);
    QCOMPARE(selector->currentId(), id);
  }
  void choose(const QString& id) { select(rows()[0]->findChild<innergs::ui::Selector*>(), id); }
  void clickWhenEnabled() {
    TRY_VERIFY(button()->isEnabled());
    QTest::mouseClick(button(), Qt::LeftButton);
  }
  void start() {
    choose("head");
    clickWhenEnabled();
  }
  void finish(const innergs::ui::Report& report) {
    start();
    host_->sendFinished(report);
  }
  void scrollDown() {
    layOut();
    area_->verticalScrollBar()->setValue(area_->verticalScrollBar()->maximum());
  }
  std::unique_ptr<FakeHost> host_;
  std::unique_ptr<QScrollArea> area_;
  innergs::ui::ReconstructionPanel* panel_ = nullptr;
};
