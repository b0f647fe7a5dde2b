#include "Widgets/App/Startup.h"

#include "Widgets/App/Background.h"
#include "Widgets/App/FileDialogs.h"
#include "Widgets/App/MainWindow.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QApplication>
#include <QLibraryInfo>
#include <QPalette>
#include <QPixmap>
#include <QStyleFactory>
#include <QSurfaceFormat>
#include <QTextStream>
#include <QTimer>
#include <QTranslator>

#include <algorithm>
#include <memory>

namespace innergs::app {
namespace {

// The views are drawn shortly after the request.
constexpr int kDrawn = 500; // ms

void takePicture(MainWindow* window, const QString& file, bool failed) {
  QTimer::singleShot(kDrawn, window, [window, file, failed] {
    const bool written = window->grab().save(file, "PNG");
    if (!written) QTextStream(stderr) << "innergs-app: cannot write " << file << "\n";
    QApplication::exit(failed || !written ? 1 : 0);
  });
}

} // namespace

void carryOut(MainWindow* window, const CommandLine& line) {
  AppHost* host = window->host();
  QStringList files = line.files;
  files.removeAll(QString());
  auto failed = std::make_shared<bool>(false);
  const auto complain = [failed](const QString& sentence) {
    *failed = true;
    QTextStream(stderr) << "innergs-app: " << sentence << "\n";
  };
  QObject::connect(host, &AppHost::openFailed, window,
                   [complain](const QString&, const QString& sentence) { complain(sentence); });
  const auto end = [window, line, failed] {
    if (!line.screenshot.isEmpty()) takePicture(window, line.screenshot, *failed);
  };
  const auto afterOpening = [=] {
    if (!line.reconstruct) {
      end();
      return;
    }
    QObject::connect(host, &AppHost::finished, window, end);
    QObject::connect(host, &AppHost::cancelled, window, end);
    QObject::connect(host, &AppHost::failed, window, [complain, end](const QString& sentence) {
      complain(sentence);
      end();
    });
    window->reconstruct(!line.sample);
    if (!host->isRunning()) { // the panel says why
      complain(QObject::tr("The reconstruction cannot start: open a volume first."));
      end();
    }
  };
  if (files.isEmpty() && !line.sample) {
    QTimer::singleShot(0, window, afterOpening);
    return;
  }
  auto* once = new QObject(window);
  QObject::connect(&host->background(), &Background::busyChanged, once, [=](const QString& text) {
    if (!text.isEmpty()) return;
    once->deleteLater();
    afterOpening();
  });
  if (line.sample && line.screenshot.isEmpty()) window->files()->openSample();
  if (line.sample && !line.screenshot.isEmpty()) host->openSample(); // a script cannot choose files
  window->host()->open(files);
}

void prepare() {
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
#if QT_VERSION < QT_VERSION_CHECK(6, 0, 0)
  QApplication::setAttribute(Qt::AA_EnableHighDpiScaling);
  QApplication::setAttribute(Qt::AA_UseHighDpiPixmaps);
#endif
}

QStringList translationFolders() {
  const QString program = QCoreApplication::applicationDirPath();
  return {program + QStringLiteral("/translations"),
          program + QStringLiteral("/../share/innergs/translations")};
}

bool loadTranslations(const QLocale& locale, const QStringList& folders) {
  const auto load = [&](const QString& name, const QString& folder) {
    auto* translator = new QTranslator(QCoreApplication::instance());
    if (translator->load(locale, name, QStringLiteral("_"), folder) &&
        QCoreApplication::installTranslator(translator))
      return true;
    delete translator;
    return false;
  };
  const auto loaded = [&](const QString& folder) { return load(QStringLiteral("innergs"), folder); };
  if (!std::any_of(folders.begin(), folders.end(), loaded)) return false;
#if QT_VERSION < QT_VERSION_CHECK(6, 0, 0)
  load(QStringLiteral("qtbase"), QLibraryInfo::location(QLibraryInfo::TranslationsPath));
#else
  load(QStringLiteral("qtbase"), QLibraryInfo::path(QLibraryInfo::TranslationsPath));
#endif
  return true;
}

void useDarkPalette() {
  QApplication::setStyle(QStyleFactory::create(QStringLiteral("Fusion")));
  QPalette palette;
  const QColor window(45, 46, 50), base(30, 31, 34), text(228, 228, 230), accent(88, 140, 220);
  palette.setColor(QPalette::Window, window);
  palette.setColor(QPalette::WindowText, text);
  palette.setColor(QPalette::Base, base);
  palette.setColor(QPalette::AlternateBase, window);
  palette.setColor(QPalette::ToolTipBase, base);
  palette.setColor(QPalette::ToolTipText, text);
  palette.setColor(QPalette::PlaceholderText, QColor(150, 150, 155));
  palette.setColor(QPalette::Text, text);
  palette.setColor(QPalette::Button, QColor(58, 59, 64));
  palette.setColor(QPalette::ButtonText, text);
  palette.setColor(QPalette::BrightText, Qt::white);
  palette.setColor(QPalette::Link, accent);
  palette.setColor(QPalette::Highlight, accent);
  palette.setColor(QPalette::HighlightedText, Qt::white);
  for (const QPalette::ColorRole role : {QPalette::Text, QPalette::WindowText, QPalette::ButtonText})
    palette.setColor(QPalette::Disabled, role, QColor(125, 125, 130));
  QApplication::setPalette(palette);
}

} // namespace innergs::app
