// Writes the pictures of Docs/screenshots: drives the app as a person would, from the sample brain.
// Usage: innergs_screenshots FOLDER [all|scaled]
//        innergs_screenshots FOLDER find QUERY SCAN MODEL   a model that has learned segments, asked in words
//        innergs_screenshots FOLDER moving SCAN             a dynamic scan, while it is fitted and afterwards
//        innergs_screenshots FOLDER slices (SCAN MASK)...   scans with their masks, and where their slices
//        lie
#include "Widgets/App/AppMotionHost.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/FileDialogs.h"
#include "Widgets/App/MainWindow.h"
#include "Widgets/App/SegmentItems.h"
#include "Widgets/App/Startup.h"
#include "Widgets/FindPanel.h"
#include "Widgets/MotionPanel.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ReconstructionPanel.h"

#include <vtkMatrix4x4.h>
#include <vtkNew.h>

#include <QAbstractButton>
#include <QApplication>
#include <QDialog>
#include <QElapsedTimer>
#include <QPainter>
#include <QPixmap>
#include <QScrollArea>
#include <QTextStream>

#include <cmath>
#include <functional>

namespace {

using innergs::app::MainWindow;

bool waitFor(const std::function<bool()>& condition, int limit) {
  QElapsedTimer timer;
  timer.start();
  while (!condition() && timer.elapsed() < limit)
    QCoreApplication::processEvents(QEventLoop::AllEvents, 50);
  return condition();
}

bool waitUntilRead(MainWindow& window) {
  return waitFor([&] { return !window.host()->background().isBusy(); }, 60000);
}

/// Starts the reconstruction, and sets `ended` at its end.
void reconstruct(MainWindow& window, bool& ended) {
  QObject::connect(window.host(), &innergs::ui::Host::failed, [&] { ended = true; });
  QObject::connect(window.host(), &innergs::ui::Host::finished, [&] { ended = true; });
  window.reconstruct(false);
}

void settle() {
  waitFor([] { return false; }, 1200); // estimates, previews and views appear a moment later
}

bool save(QWidget* widget, const QString& file) {
  settle();
  const bool written = widget->grab().save(file, "PNG");
  QTextStream(written ? stdout : stderr) << (written ? "" : "cannot write ") << file << "\n";
  return written;
}

/// The part of a panel, brought into view.
QWidget* shown(MainWindow& window, const char* name) {
  auto* part = window.findChild<QWidget*>(QString::fromLatin1(name));
  for (QWidget* above = part; above; above = above->parentWidget())
    if (auto* area = qobject_cast<QScrollArea*>(above)) area->ensureWidgetVisible(part, 0, 0);
  return part;
}

void showObliquePlane(MainWindow& window) {
  window.showPanel(QStringLiteral("queryDock"));
  const double c = std::cos(0.5), s = std::sin(0.5);
  const double plane[16] = {-c, 0, s, 0, 0, 1, 0, -18, -s, 0, -c, 12, 0, 0, 0, 1};
  vtkNew<vtkMatrix4x4> matrix;
  matrix->DeepCopy(plane);
  window.query()->setPlane(matrix);
}

/// The panel Find with a query's answer over the scan.
bool showFound(MainWindow& window, const QString& query, const QStringList& files, const QString& picture) {
  auto* host = window.host();
  host->open(files);
  if (!waitUntilRead(window) || host->document().models().empty()) return false;
  window.showPanel(QStringLiteral("findDock"));
  window.find()->setModelId(host->document().models().front()->id);
  bool shown = false;
  QObject::connect(host, &innergs::app::AppHost::segmentsPreviewed, &window, [&](const auto& overlay) {
    if (!overlay) return;
    shown = true;
    double middle[4] = {0, 0, 0, 1};
    for (int a = 0; a < 3; ++a)
      middle[a] = 0.5 * (overlay->labels->GetDimensions()[a] - 1);
    overlay->ijkToRAS->MultiplyPoint(middle, middle);
    window.state()->setCrosshair({middle[0], middle[1], middle[2]});
  });
  window.find()->find(query);
  return waitFor([&] { return shown; }, 60000) && save(&window, picture);
}

/// The panel Dynamic with a dynamic scan that is fitted, and its result at a time between frames.
bool showDynamic(MainWindow& window, const QString& scan, const QString& folder) {
  auto* host = window.host();
  innergs::app::AppMotionHost& motion = host->motionHost();
  host->open({scan});
  if (!waitFor([&] { return !host->background().isBusy() && !host->document().volumes().empty(); }, 60000))
    return false;
  bool previewed = false, ended = false;
  QString model;
  QObject::connect(&motion, &innergs::ui::MotionHost::previewed, [&] { previewed = true; });
  QObject::connect(&motion, &innergs::ui::MotionHost::failed, [&] { ended = true; });
  QObject::connect(&motion, &innergs::ui::MotionHost::finished, [&](const innergs::ui::MotionReport& report) {
    model = report.modelId;
    ended = true;
  });
  innergs::ui::MotionRequest request;
  request.seriesId = host->document().volumes().front()->id;
  motion.start(request);
  bool good = waitFor([&] { return previewed || ended; }, 600000) && !ended;
  good = good && save(&window, folder + QStringLiteral("app-moving-running.png"));
  if (!waitFor([&] { return ended; }, 1200000) || model.isEmpty()) return false;
  const innergs::ui::MotionInfo info = motion.motionInfo(model);
  motion.setTime(model, 0.32 * info.last + 0.68 * info.first);
  window.motion()->setModelId(model);
  return save(&window, folder + QStringLiteral("app-moving.png")) && good;
}

/// Several scans, each with its mask: the panel with its choices, and with its result and the list of slices.
bool showSlices(MainWindow& window, const QStringList& scansAndMasks, const QString& folder) {
  auto* host = window.host();
  host->open(scansAndMasks);
  if (!waitUntilRead(window)) return false;
  innergs::ui::Request request = window.reconstruction()->request();
  request.inputs.clear();
  const auto& volumes = host->document().volumes();
  for (std::size_t n = 0; n + 1 < volumes.size(); n += 2) {
    innergs::ui::InputChoice choice{volumes[n]->id};
    choice.maskId = volumes[n + 1]->id;
    request.inputs.push_back(choice);
  }
  request.settings.preset = innergs::Preset::Fast;
  request.evaluateQuality = false;
  window.reconstruction()->setRequest(request);
  window.state()->setVolumeId(volumes.front()->id);
  bool good = save(&window, folder + QStringLiteral("app-scans.png"));
  bool ended = false;
  reconstruct(window, ended);
  if (!waitFor([&] { return ended; }, 1200000) || !host->sliceTable()) return false;
  shown(window, "slicesLine");
  window.findChild<QAbstractButton*>(QStringLiteral("showSlices"))->click();
  settle();
  auto* dialog = window.findChild<QDialog*>(QStringLiteral("slicesDialog"));
  QPixmap picture = window.grab();
  const QPixmap list = dialog->grab();
  QPainter painter(&picture);
  const QRect place(window.width() - dialog->width() - 40, window.height() - dialog->height() - 60,
                    dialog->width(), dialog->height());
  painter.drawPixmap(place, list);
  painter.drawRect(place);
  painter.end();
  dialog->close();
  return picture.save(folder + QStringLiteral("app-slices.png"), "PNG") && good;
}

} // namespace

int main(int argc, char** argv) {
  innergs::app::prepare();
  QApplication app(argc, argv);
  if (argc < 2) return 2;
  const QStringList arguments = QApplication::arguments().mid(1);
  const QString folder = arguments.value(0) + QLatin1Char('/'), what = arguments.value(1);
  const bool scaled = what == QLatin1String("scaled");
  MainWindow window;
  window.resize(1440, 900);
  window.show();
  auto* host = window.host();
  QObject::connect(host, &innergs::app::AppHost::failed,
                   [](const QString& sentence) { QTextStream(stderr) << sentence << "\n"; });
  if (argc > 5 && what == QLatin1String("find"))
    return !showFound(window, arguments[2], arguments.mid(3, 2), folder + QStringLiteral("app-find.png"));
  if (argc > 3 && what == QLatin1String("moving")) return !showDynamic(window, arguments[2], folder);
  if (argc > 4 && what == QLatin1String("slices")) return !showSlices(window, arguments.mid(2), folder);
  window.files()->openSample();
  if (!waitUntilRead(window) || host->document().volumes().empty()) return 1;
  innergs::ui::Request request = window.reconstruction()->request();
  request.settings.preset = innergs::Preset::Fast;
  request.evaluateQuality = !scaled;
  request.qualityGap = 2;
  window.reconstruction()->setRequest(request);
  bool good = scaled || save(&window, folder + QStringLiteral("app-start.png"));
  bool ended = false;
  reconstruct(window, ended);
  if (!scaled) {
    waitFor([&] { return ended; }, 6000);
    good = save(&window, folder + QStringLiteral("app-running.png")) && good;
  }
  if (!waitFor([&] { return ended; }, 1200000) || host->document().models().empty()) return 1;
  shown(window, "slicesLine");
  good = save(&window, folder + QString::fromLatin1(scaled ? "app-150.png" : "app-result.png")) && good;
  if (!scaled) good = save(shown(window, "qualityCard"), folder + QStringLiteral("quality-card.png")) && good;
  if (scaled) return good ? 0 : 1;
  showObliquePlane(window);
  good = save(&window, folder + QStringLiteral("app-query.png")) && good;
  window.showPanel(QStringLiteral("modelDock"));
  host->showEllipsoids(host->document().models().front()->id, true);
  window.views()->threeD()->setPlanesShown(false);
  good = save(&window, folder + QStringLiteral("app-model.png")) && good;
  host->showEllipsoids(host->document().models().front()->id, false);
  window.views()->threeD()->setPlanesShown(true);
  window.views()->threeD()->setVolumeRendered(true);
  innergs::app::useDarkPalette();
  window.showPanel(QStringLiteral("reconstructDock"));
  shown(window, "slicesLine");
  good = save(&window, folder + QStringLiteral("app-dark.png")) && good;
  return good ? 0 : 1;
}
