#pragma once
#include "Widgets/App/CommandLine.h"

#include <QLocale>

namespace innergs::app {

class MainWindow;

/// Does what the command line asks for, once the event loop runs. With a screenshot the program ends after
/// it: exit code 1 when something failed.
void carryOut(MainWindow* window, const CommandLine& line);

/// Words in the user's language, where a folder holds innergs_<language>.qm; Qt's own with them. False: none
/// does.
bool loadTranslations(const QLocale& locale, const QStringList& folders);
/// "translations" beside the program and in its share folder.
QStringList translationFolders();

/// Dark colours for the whole program.
void useDarkPalette();

/// What Qt and the views need to be told before there is a QApplication.
void prepare();

} // namespace innergs::app
