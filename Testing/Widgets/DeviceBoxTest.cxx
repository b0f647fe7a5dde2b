#include "Widgets/DeviceBox.h"

#include "Core/DevicePlugin.h"
#include "TestTools.h"

#include <QElapsedTimer>
#include <QSignalSpy>

#include <chrono>
#include <thread>

using innergs::ui::DeviceBox;

namespace {

innergs::DeviceInfo device(const char* name, std::int64_t freeMemory) {
  innergs::DeviceInfo info;
  info.name = name;
  info.freeMemory = freeMemory;
  return info;
}

innergs::DeviceList twoDevices() {
  std::this_thread::sleep_for(std::chrono::milliseconds(300)); // as a driver that wakes up
  return {{device("GPU A", 79'000'000'000), device("GPU B", 500'000'000)}, {}};
}

} // namespace

class DeviceBoxTest : public QObject {
  Q_OBJECT

private Q_SLOTS:
  void listingHoldsNothingUp() {
    QElapsedTimer clock;
    clock.start();
    DeviceBox box(nullptr, twoDevices);
    QVERIFY(clock.elapsed() < 200);
    QVERIFY(box.isListing());
    auto* combo = box.findChild<QComboBox*>("device");
    QCOMPARE(combo->count(), 2);
    box.setDevice("cpu"); // while it looks
    QSignalSpy listed(&box, &DeviceBox::listed);
    QVERIFY(listed.wait());
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
    QVERIFY(listed.wait());
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
    QVERIFY(listed.wait());
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
    QVERIFY(listed.wait());
    auto* combo = box.findChild<QComboBox*>("device");
    QCOMPARE(combo->itemText(2), QString("GPU A (cuda:0, not used)"));
    QCOMPARE(combo->itemData(2, Qt::ToolTipRole).toString(),
             QString("GPU A (cuda:0) computes otherwise than the CPU."));
  }

  void goesWhileItLooks() {
    DeviceBox box(nullptr, twoDevices);
    QVERIFY(box.isListing());
  }
};

QTEST_MAIN(DeviceBoxTest)
#include "DeviceBoxTest.moc"
