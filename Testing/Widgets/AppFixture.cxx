#include "AppFixture.h"

#include "IO/VolumeIO.h"

#include <QAbstractButton>
#include <QApplication>
#include <QElapsedTimer>
#include <QFile>
#include <QFileInfo>
#include <QMessageBox>
#include <QSignalSpy>
#include <QTest>
#include <QTimer>

#include <cmath>

using namespace innergs;

namespace apptest {

Sandbox::Sandbox() {
  qputenv("INNERGS_SETTINGS", folder_.filePath(QStringLiteral("settings.ini")).toUtf8());
}

Sandbox::~Sandbox() {
  qunsetenv("INNERGS_SETTINGS");
}

void HostTest::init() {
  sandbox_ = std::make_unique<Sandbox>();
  host_ = std::make_unique<innergs::app::AppHost>();
}

void HostTest::cleanup() {
  host_.reset();
  sandbox_.reset();
}

Volume ball(std::array<std::int64_t, 3> size, const Vec3& spacing, bool oblique) {
  Volume volume;
  GridGeometry& g = volume.geometry;
  g.size = size;
  g.spacing = spacing;
  if (oblique) {
    const double c = std::cos(0.4), s = std::sin(0.4);
    g.direction = {};
    g.direction[0] = {c, 0, s};
    g.direction[1] = {0, 1, 0};
    g.direction[2] = {-s, 0, c};
  }
  const Vec3 middle{0.5 * double(size[0] - 1), 0.5 * double(size[1] - 1), 0.5 * double(size[2] - 1)};
  const Vec3 to = g.indexToWorld()(middle);
  g.origin = {-to[0], -to[1], -to[2]};
  const Affine3 map = g.indexToWorld();
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i) {
        const Vec3 x = map({double(i), double(j), double(k)});
        const double r = norm(x), wave = 1 + 0.3 * std::sin(0.5 * x[0]) * std::cos(0.4 * x[1]);
        volume.voxels.push_back(static_cast<float>(80 * wave / (1 + std::exp(r - 12))));
      }
  return volume;
}

QString writeBall(const Sandbox& sandbox, const QString& name, std::array<std::int64_t, 3> size,
                  const Vec3& spacing, bool oblique) {
  QString path = sandbox.path(name);
  writeVolume(ball(size, spacing, oblique), path.toStdString());
  return path;
}

QString writeFrames(const Sandbox& sandbox, const QString& name, int frames, float seconds) {
  constexpr std::int16_t slices = 8;
  Volume all = ball({16, 16, slices}, {2, 2, 4});
  const std::vector<float> one = all.voxels;
  for (int frame = 1; frame < frames; ++frame)
    for (const float value : one)
      all.voxels.push_back(value * float(1 + frame));
  all.geometry.size[2] *= frames;
  QString path = sandbox.path(name);
  writeVolume(all, path.toStdString());
  QFile file(path);
  if (!file.open(QIODevice::ReadWrite)) return {};
  const auto put = [&](qint64 at, const auto& value) {
    file.seek(at);
    file.write(reinterpret_cast<const char*>(&value), sizeof value);
  };
  put(40, std::int16_t(4)); // dimensions, where NIfTI has them
  put(46, slices);
  put(48, std::int16_t(frames));
  put(92, seconds);
  put(123, char(2 | 8)); // mm, s
  return path;
}

QString writeRgb(const Sandbox& sandbox, const QString& name) {
  QString path = writeBall(sandbox, name, {8, 8, 8});
  QFile file(path);
  if (!file.open(QIODevice::ReadWrite)) return {};
  const char type[] = {char(128), 0, 24, 0}; // datatype RGB24 and bits per voxel, where NIfTI has them
  file.seek(70);
  file.write(type, sizeof type);
  return path;
}

namespace {

constexpr const char* kImageToProbe = "1 0 0 -19.5 0 1 0 15 0 0 1 0 0 0 0 1"; // the first line is 15 mm away

} // namespace

QString writeSweep(const Sandbox& sandbox, const QString& name, bool calibrated) {
  constexpr int images = 33, pixels = 40;
  QByteArray header = "ObjectType = Image\nNDims = 3\nBinaryData = True\nElementType = MET_UCHAR\n"
                      "DimSize = 40 40 33\n";
  if (calibrated) header += QByteArray("ImageToProbeTransform = ") + kImageToProbe + "\n";
  QByteArray voxels;
  for (int n = 0; n < images; ++n) {
    const double angle = (-37.5 + 75.0 * n / (images - 1)) * 0.017453292519943295;
    const double c = std::cos(angle), s = std::sin(angle);
    header += QString::asprintf("Seq_Frame%04d_", n).toLatin1() + "ProbeToReferenceTransform = " +
              QString("1 0 0 0 0 %1 %2 0 0 %3 %4 0 0 0 0 1").arg(s).arg(-c).arg(c).arg(s).toLatin1() + "\n";
    for (int j = 0; j < pixels; ++j)
      for (int i = 0; i < pixels; ++i) {
        const double depth = j + 15.0;
        const double distance = std::hypot(i - 19.5 - 3, depth * s - 10, depth * c - 35);
        voxels += static_cast<char>(distance < 12 ? 200 * (1 - distance / 12) : 0);
      }
  }
  QString path = sandbox.path(name);
  QFile file(path);
  if (!file.open(QIODevice::WriteOnly)) return {};
  file.write(header + "ElementDataFile = LOCAL\n" + voxels);
  return path;
}

QString sweepCalibration(const Sandbox& sandbox) {
  QString path = sandbox.path("calibration.txt");
  QFile file(path);
  if (!file.open(QIODevice::WriteOnly)) return {};
  file.write(kImageToProbe);
  return path;
}

QString testData(const QString& name) {
  const QString path = QStringLiteral(INNERGS_TEST_DATA) + QLatin1Char('/') + name;
  return QFileInfo::exists(path) ? path : QString();
}

QString openAndWait(app::AppHost& host, const QString& path, QString* error) {
  QString id, sentence;
  bool done = false;
  QObject context;
  QObject::connect(&host, &app::AppHost::opened, &context, [&](const QString& opened) {
    id = opened;
    done = true;
  });
  QObject::connect(&host, &app::AppHost::openFailed, &context, [&](const QString&, const QString& text) {
    sentence = text;
    done = true;
  });
  host.open({path});
  if (!QTest::qWaitFor([&] { return done; }, kPatience)) sentence = "nothing happened";
  if (error) *error = sentence;
  return id;
}

ui::Report reconstructAndWait(app::AppHost& host, const ui::Request& request) {
  QSignalSpy finished(&host, &app::AppHost::finished);
  if (!host.start(request)) return {};
  finished.wait(kPatience);
  return finished.isEmpty() ? ui::Report() : finished.first().first().value<ui::Report>();
}

ui::Request request(const QString& id, bool longFit) {
  ui::Request request;
  request.inputs.push_back({id});
  request.evaluateQuality = false;
  request.settings.preset = Preset::Fast;
  request.settings.gaussians = 300;
  request.settings.iterations = longFit ? 200000 : 15;
  request.settings.ensembleSize = 1;
  request.settings.device = "cpu";
  return request;
}

void answerBox(const char* name, const QString& button, QString* text) {
  auto* timer = new QTimer(qApp);
  auto clock = std::make_shared<QElapsedTimer>();
  clock->start();
  QObject::connect(timer, &QTimer::timeout, timer, [=] {
    if (clock->elapsed() > kPatience) {
      timer->deleteLater();
      QFAIL(qPrintable(QString("'%1' was never asked").arg(name)));
    }
    for (QWidget* widget : QApplication::topLevelWidgets()) {
      auto* box = qobject_cast<QMessageBox*>(widget);
      if (!box || !box->isVisible() || box->objectName() != QLatin1String(name)) continue;
      for (QAbstractButton* candidate : box->buttons())
        if (candidate->text().remove(QLatin1Char('&')) == button) {
          if (text) *text = box->text();
          timer->deleteLater();
          QTest::mouseClick(candidate, Qt::LeftButton);
          return;
        }
    }
  });
  timer->start(10);
}

} // namespace apptest
