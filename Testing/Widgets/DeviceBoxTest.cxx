#include "Widgets/DeviceBox.h"

#include "Core/Device/DevicePlugin.h"
#include "Patience.h"
#include "TestTools.h"

#include <QSemaphore>
#include <QSignalSpy>

#include <memory>

using innergs::ui::DeviceBox;

namespace {

innergs::DeviceInfo device(const char* name, std::int64_t freeMemory) {
  innergs::DeviceInfo info;
  info.name = name;
  info.freeMemory = freeMemory;
  return info;
}

innergs::DeviceList twoDevices() {
  return {{device("GPU A", 79'000'000'000), device("GPU B", 500'000'000)}, {}};
}

/// Like a driver that starts up: it answers when told to.
class SlowDriver {
public:
  innergs::DeviceList find() {
    asked_.release();
    answer_.acquire();
    return twoDevices();
  }
  void waitUntilAsked() { asked_.acquire(); }
  void answer() { answer_.release(); }

private:
  QSemaphore asked_, answer_;
};

} // namespace

class DeviceBoxTest : public QObject {
  Q_OBJECT

private Q_SLOTS:
  void listingHoldsNothingUp() {
    SlowDriver driver;
    DeviceBox box(nullptr, [&] { return driver.find(); });
    driver.waitUntilAsked();
    QVERIFY(box.isListing());
    auto* combo = box.findChild<QComboBox*>("device");
    QCOMPARE(combo->count(), 2);
    box.setDevice("cpu"); // while it is searching
    QSignalSpy listed(&box, &DeviceBox::listed);
    driver.answer();
    QVERIFY(listed.wait(kPatience));
    QCOMPARE(combo->count(), 4);
    QCOMPARE(box.device(), QString("cpu"));
    QCOMPARE(combo->itemText(2), QString("GPU A (cuda:0, 79.0 GB free)"));
    QCOMPARE(combo->itemText(3), QString("GPU B (cuda:1, 500 MB free)"));
    combo->setFocus();
    QTest::keyClick(combo, Qt::Key_End);
    QCOMPARE(box.device(), QString("cuda:1"));
  }

  void aDeviceOfASavedRequestIsKept() {
    DeviceBox box(nullptr, twoDevices);
    box.setDevice("cuda:1");
    QCOMPARE(box.device(), QString("cuda:1"));
    QSignalSpy listed(&box, &DeviceBox::listed);
    QVERIFY(listed.wait(kPatience));
    auto* combo = box.findChild<QComboBox*>("device");
    QCOMPARE(combo->currentText(), QString("GPU B (cuda:1, 500 MB free)"));
    box.setDevice("cuda:7");
    QCOMPARE(box.device(), QString("cuda:7"));
    QCOMPARE(combo->currentText(), QString("cuda:7 (not found)"));
    box.setDevice("auto");
    QCOMPARE(combo->currentIndex(), 0);
  }

  void saysWhyThereIsNone() {
    DeviceBox box(nullptr, [] { return innergs::DeviceList{{}, "The CUDA backend is not installed."}; });
    QSignalSpy listed(&box, &DeviceBox::listed);
    QVERIFY(listed.wait(kPatience));
    auto* combo = box.findChild<QComboBox*>("device");
    QCOMPARE(combo->count(), 2);
    QCOMPARE(combo->itemData(0, Qt::ToolTipRole).toString(), QString("The CUDA backend is not installed."));
  }

  void saysWhichIsNotUsed() {
    DeviceBox box(nullptr, [] {
      innergs::DeviceList list{{device("GPU A", 79'000'000'000)}, {}};
      list.devices[0].refused = "GPU A (cuda:0) computes otherwise than the CPU";
      return list;
    });
    QSignalSpy listed(&box, &DeviceBox::listed);
    QVERIFY(listed.wait(kPatience));
    auto* combo = box.findChild<QComboBox*>("device");
    QCOMPARE(combo->itemText(2), QString("GPU A (cuda:0, not used)"));
    QCOMPARE(combo->itemData(2, Qt::ToolTipRole).toString(),
             QString("GPU A (cuda:0) computes otherwise than the CPU."));
  }

  void goesWhileItLooks() {
    SlowDriver driver;
    auto box = std::make_unique<DeviceBox>(nullptr, [&] { return driver.find(); });
    driver.waitUntilAsked();
    QVERIFY(box->isListing());
    driver.answer(); // the box waits for it
    box.reset();
  }
};

QTEST_MAIN(DeviceBoxTest)
#include "DeviceBoxTest.moc"
