#pragma once
#include "Patience.h"
#include "Widgets/App/AppHost.h"

#include <QTemporaryDir>

#include <memory>

class QWidget;

namespace apptest {

/// A separate folder for files and the app's settings: the user's are never touched.
class Sandbox {
public:
  Sandbox();
  ~Sandbox();
  QString path(const QString& name) const { return folder_.filePath(name); }

private:
  QTemporaryDir folder_;
};

/// The app's host, without a window, with separate settings for every test.
class HostTest : public QObject {
  Q_OBJECT
protected:
  std::unique_ptr<Sandbox> sandbox_;
  std::unique_ptr<innergs::app::AppHost> host_;

protected Q_SLOTS:
  void init();
  void cleanup();
};

/// A smooth ball (values 0 to about 100) of `size` voxels of `spacing` mm around the origin, on request
/// oblique to the patient's axes.
innergs::Volume ball(std::array<std::int64_t, 3> size, const innergs::Vec3& spacing, bool oblique = false);
/// Writes the ball to a NIfTI file; returns its path.
QString writeBall(const Sandbox& sandbox, const QString& name,
                  std::array<std::int64_t, 3> size = {24, 24, 10},
                  const innergs::Vec3& spacing = {1.5, 1.5, 4}, bool oblique = false);
/// Writes a NIfTI file with `frames` balls (8 slices each), each brighter than the last one, `seconds` apart;
/// returns its path.
QString writeFrames(const Sandbox& sandbox, const QString& name, int frames, float seconds);
/// Writes a tracked sweep: a fan of 33 images, 40 × 40 pixels of 1 mm, 75 degrees about the RAS x axis,
/// through a ball (values 0 to 200, radius 12 mm) around RAS (3, 10, 35); returns its path. Uncalibrated:
/// without ImageToProbe, which is sweepCalibration().
QString writeSweep(const Sandbox& sandbox, const QString& name, bool calibrated);
/// Writes that calibration to a text file; returns its path.
QString sweepCalibration(const Sandbox& sandbox);
/// A NIfTI file with 24-bit colour voxels.
QString writeRgb(const Sandbox& sandbox, const QString& name);

/// The file or folder of INNERGS_TEST_DATA; "" if missing.
QString testData(const QString& name);

/// Opens a file and waits; returns its ID, or "" with the message in *error.
QString openAndWait(innergs::app::AppHost& host, const QString& path, QString* error = nullptr);

/// Reconstructs and waits; the report has no IDs if it is rejected or fails.
innergs::ui::Report reconstructAndWait(innergs::app::AppHost& host, const innergs::ui::Request& request);

/// A fit that takes a second at most or, if long, minutes.
innergs::ui::Request request(const QString& id, bool longFit = false);

/// Clicks the button with this text (without &) in the message box with this object name ("": Qt's own) as
/// soon as it opens; *text receives the box's text.
void answerBox(const char* name, const QString& button, QString* text = nullptr);

} // namespace apptest
