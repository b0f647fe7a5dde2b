#include "Widgets/App/AppSettings.h"

#include <QDir>
#include <QFileInfo>
#include <QStandardPaths>

namespace innergs::app {
namespace {

constexpr int kRecentFiles = 10;
const QString kRecent = QStringLiteral("recentFiles");

} // namespace

std::unique_ptr<QSettings> appSettings() {
  const QString file = qEnvironmentVariable("INNERGS_SETTINGS");
  if (!file.isEmpty()) return std::make_unique<QSettings>(file, QSettings::IniFormat);
  return std::make_unique<QSettings>(QStringLiteral("InnerGS"), QStringLiteral("InnerGS"));
}

QString recoveryFolder() {
  const QString file = qEnvironmentVariable("INNERGS_SETTINGS");
  if (!file.isEmpty()) return QFileInfo(file).absolutePath() + QStringLiteral("/recovery");
  return QStandardPaths::writableLocation(QStandardPaths::GenericDataLocation) +
         QStringLiteral("/InnerGS/recovery");
}

QStringList recentFiles() {
  return appSettings()->value(kRecent).toStringList();
}

void addRecentFile(const QString& path) {
  const QString absolute = QDir::cleanPath(QFileInfo(path).absoluteFilePath());
  QStringList files = recentFiles();
  files.removeAll(absolute);
  files.prepend(absolute);
  while (files.size() > kRecentFiles)
    files.removeLast();
  appSettings()->setValue(kRecent, files);
}

void clearRecentFiles() {
  appSettings()->remove(kRecent);
}

} // namespace innergs::app
