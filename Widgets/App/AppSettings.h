#pragma once
#include <QSettings>
#include <QStringList>

#include <memory>

namespace innergs::app {

/// What the app remembers: the user's own, or the INI file that the environment variable INNERGS_SETTINGS
/// names (tests, scripts).
std::unique_ptr<QSettings> appSettings();

/// Files and folders opened last, newest first.
QStringList recentFiles();
void addRecentFile(const QString& path);
void clearRecentFiles();

} // namespace innergs::app
