#pragma once
#include "Widgets/App/CommandLine.h"

#include <QLocale>

namespace innergs::app {

class MainWindow;

/// Carries out the command line once the event loop runs. With a screenshot, the program then ends, with exit
/// code 1 if something failed.
void carryOut(MainWindow* window, const CommandLine& line);

/// Loads texts in the user's language if a folder contains innergs_<language>.qm, together with Qt's own.
/// False: none does.
bool loadTranslations(const QLocale& locale, const QStringList& folders);
/// "translations" beside the program and in its share folder.
QStringList translationFolders();

/// Sets dark colours for the whole program.
void useDarkPalette();

/// Settings for Qt and the views that must precede the QApplication.
void prepare();

} // namespace innergs::app
