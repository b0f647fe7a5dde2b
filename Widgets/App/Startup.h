#pragma once
#include "Widgets/App/CommandLine.h"

namespace innergs::app {

class MainWindow;

/// Does what the command line asks for, once the event loop runs. With a screenshot the program ends after
/// it: exit code 1 when something failed.
void carryOut(MainWindow* window, const CommandLine& line);

/// Dark colours for the whole program.
void useDarkPalette();

/// What Qt and the views need to be told before there is a QApplication.
void prepare();

} // namespace innergs::app
