#pragma once
#include <QThread>
#include <QWidget>

#include <functional>
#include <memory>
#include <vector>

class QComboBox;
class QLabel;

namespace innergs {
struct DeviceInfo;
struct DeviceList;
} // namespace innergs

namespace innergs::ui {

/// Chooses the device and says why it was chosen. Looks for GPUs in the background.
class DeviceBox : public QWidget {
  Q_OBJECT
public:
  /// find: lists the devices, on a separate thread; empty: innergs::otherDevices.
  explicit DeviceBox(QWidget* parent = nullptr, std::function<DeviceList()> find = {});
  ~DeviceBox() override;
  /// As in Settings: "auto", "cpu", "cuda:N".
  QString device() const;
  void setDevice(const QString& device);
  /// From an Estimate or a report; "" while unknown.
  void setReason(const QString& reason);
  bool isListing() const { return listing_ != nullptr; }

Q_SIGNALS:
  void changed();
  void listed();

private:
  void list(const std::vector<DeviceInfo>& devices, const QString& problem);
  void markMissing();

  QComboBox* combo_;
  QLabel* reason_;
  std::unique_ptr<QThread> listing_;
};

} // namespace innergs::ui
