#pragma once
#include <QSettings>
#include <QStringList>

#include <memory>

namespace innergs::app {

/// The app's stored settings: the user's own, or the INI file named by the environment variable
/// INNERGS_SETTINGS (tests, scripts).
std::unique_ptr<QSettings> appSettings();

/// The folder that keeps the state of fits that were stopped by the end of the app; with INNERGS_SETTINGS,
/// one beside that file.
QString recoveryFolder();

/// Recently opened files and folders, newest first.
QStringList recentFiles();
void addRecentFile(const QString& path);
void clearRecentFiles();

} // namespace innergs::app
