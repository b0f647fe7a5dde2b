#include "Widgets/App/MainWindow.h"
#include "Widgets/App/Startup.h"

#include <QApplication>
#include <QIcon>

#include <clocale>

int main(int argc, char** argv) {
  innergs::app::CommandLine line;
  int exitCode = 0;
  if (!innergs::app::parse(argc, argv, line, &exitCode)) return exitCode;
  innergs::app::prepare();
  int one = 1; // the app parses the options, not Qt
  QApplication app(one, argv);
  std::setlocale(LC_NUMERIC, "C"); // Qt has set the user's; files need decimal points
  QApplication::setApplicationName(QStringLiteral("InnerGS"));
  QApplication::setApplicationVersion(QStringLiteral(INNERGS_VERSION));
  QApplication::setDesktopFileName(QStringLiteral("innergs-app"));
  QApplication::setWindowIcon(QIcon(QStringLiteral(":/Icons/InnerGS.png")));
  innergs::app::loadTranslations(QLocale::system(), innergs::app::translationFolders());
  if (line.dark) innergs::app::useDarkPalette();
  innergs::app::MainWindow window;
  window.show();
  innergs::app::carryOut(&window, line);
  return QApplication::exec();
}
