#include "Widgets/DeviceBox.h"

#include "Core/Base/Failure.h"
#include "Core/Device/DevicePlugin.h"
#include "Core/Device/Devices.h"
#include "Widgets/PanelTools.h"
#include "Widgets/TextFormat.h"

#include <QComboBox>
#include <QLabel>
#include <QSignalBlocker>
#include <QVBoxLayout>

#include <algorithm>
#include <utility>

namespace innergs::ui {

DeviceBox::DeviceBox(QWidget* parent, std::function<DeviceList()> find)
    : QWidget(parent), combo_(new QComboBox(this)), reason_(makeWrappedLabel("deviceReason", this)) {
  named(combo_, "device",
        tr("Where the fit runs. Automatic: on a GPU when one is found and has enough memory,\n"
           "else on the CPU."));
  combo_->addItem(tr("Automatic"), "auto");
  combo_->addItem(tr("CPU"), "cpu");
  combo_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  combo_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  combo_->setMinimumContentsLength(12);
  reason_->hide();
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  layout->addWidget(combo_);
  layout->addWidget(reason_);
  setFocusProxy(combo_);
  guardWheel(this);
  connect(combo_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, &DeviceBox::changed);

  auto found = std::make_shared<DeviceList>();
  listing_.reset(QThread::create([found, find = std::move(find)] {
    const std::string problem = sentenceOf([&] { *found = find ? find() : otherDevices(); });
    if (!problem.empty()) found->problem = problem;
  }));
  connect(listing_.get(), &QThread::finished, this, [this, found] {
    listing_->wait();
    listing_.reset();
    list(found->devices, QString::fromStdString(found->problem));
    Q_EMIT listed();
  });
  listing_->start(QThread::LowPriority);
}

DeviceBox::~DeviceBox() {
  if (listing_) listing_->wait();
}

QString DeviceBox::device() const {
  return combo_->currentData().toString();
}

void DeviceBox::setDevice(const QString& device) {
  const QString id = device.isEmpty() ? QStringLiteral("auto") : device;
  if (combo_->findData(id) < 0) combo_->addItem(id == "cuda" ? tr("Any GPU") : id, id);
  combo_->setCurrentIndex(combo_->findData(id));
  if (!listing_) markMissing();
}

void DeviceBox::setReason(const QString& reason) {
  reason_->setText(reason);
  reason_->setVisible(!reason.isEmpty());
}

void DeviceBox::list(const std::vector<DeviceInfo>& devices, const QString& problem) {
  for (std::size_t n = 0; n < devices.size(); ++n) {
    const QString id = QString("cuda:%1").arg(n), name = QString::fromStdString(devices[n].name);
    const QString refused = sentence(QString::fromStdString(devices[n].refused));
    const QString text = refused.isEmpty()
                             ? tr("%1 (%2, %3 free)").arg(name, id, memorySize(devices[n].freeMemory))
                             : tr("%1 (%2, not used)").arg(name, id);
    if (combo_->findData(id) < 0) combo_->addItem(text, id);
    const int item = combo_->findData(id);
    combo_->setItemText(item, text);
    combo_->setItemData(item, refused, Qt::ToolTipRole);
  }
  markMissing();
  if (!problem.isEmpty()) combo_->setItemData(0, sentence(problem), Qt::ToolTipRole);
}

void DeviceBox::markMissing() {
  for (int i = 2; i < combo_->count(); ++i)
    if (combo_->itemText(i) == combo_->itemData(i).toString())
      combo_->setItemText(i, tr("%1 (not found)").arg(combo_->itemText(i)));
}

} // namespace innergs::ui
