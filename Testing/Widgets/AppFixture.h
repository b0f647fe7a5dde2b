#pragma once
#include "Widgets/App/AppHost.h"

#include <QTemporaryDir>

#include <memory>

class QWidget;

namespace apptest {

/// A folder of its own for files and for the app's settings: the user's are never touched.
class Sandbox {
public:
  Sandbox();
  ~Sandbox();
  QString path(const QString& name) const { return folder_.filePath(name); }

private:
  QTemporaryDir folder_;
};

/// The app's host, without a window, with settings of its own for every test.
class HostTest : public QObject {
  Q_OBJECT
protected:
  std::unique_ptr<Sandbox> sandbox_;
  std::unique_ptr<innergs::app::AppHost> host_;

protected Q_SLOTS:
  void init();
  void cleanup();
};

/// A smooth ball (values 0 to about 100) of `size` voxels of `spacing` mm around the origin, oblique to the
/// patient's axes when asked.
innergs::Volume ball(std::array<std::int64_t, 3> size, const innergs::Vec3& spacing, bool oblique = false);
/// The ball in a NIfTI file; its path.
QString writeBall(const Sandbox& sandbox, const QString& name,
                  std::array<std::int64_t, 3> size = {24, 24, 10},
                  const innergs::Vec3& spacing = {1.5, 1.5, 4}, bool oblique = false);
/// A NIfTI file of so many balls (8 slices each) one after another, each brighter than the last one,
/// `seconds` apart; its path.
QString writeFrames(const Sandbox& sandbox, const QString& name, int frames, float seconds);
/// A NIfTI file with 24-bit colour voxels.
QString writeRgb(const Sandbox& sandbox, const QString& name);

/// The file or folder of INNERGS_TEST_DATA; "" when absent.
QString testData(const QString& name);

/// Opens a file and waits; its ID, or "" with the sentence in *error.
QString openAndWait(innergs::app::AppHost& host, const QString& path, QString* error = nullptr);

/// Reconstructs and waits; without IDs when it is refused or fails.
innergs::ui::Report reconstructAndWait(innergs::app::AppHost& host, const innergs::ui::Request& request);

/// A fit that takes a second at most; or, long: one that goes on for minutes.
innergs::ui::Request request(const QString& id, bool longFit = false);

/// Clicks the button with this text (without &) in the open message box with this object name ("": Qt's own),
/// as soon as there is one; what the box said comes back through *text.
void answerBox(const char* name, const QString& button, QString* text = nullptr);

} // namespace apptest
