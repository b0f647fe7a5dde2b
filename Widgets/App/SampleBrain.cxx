#include "Widgets/App/SampleBrain.h"

#include "Core/Base/Error.h"
#include "Core/Image/Simulate.h"
#include "IO/VolumeIO.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Files.h"
#include "Widgets/App/Translate.h"
#include "Widgets/TextFormat.h"

#include <QCoreApplication>
#include <QFileInfo>
#include <QStandardPaths>

#include <cmath>

namespace innergs::app {
namespace {

const QString kChosen = QStringLiteral("sampleBrain");

/// Folders that may hold ch2.nii.gz.
QStringList places() {
  const QString program = QCoreApplication::applicationDirPath();
  QStringList folders{program, program + QStringLiteral("/data"), program + QStringLiteral("/../Resources"),
                      program + QStringLiteral("/../share/innergs"),
                      program + QStringLiteral("/../share/mricron/templates")};
  for (const QString& data : QStandardPaths::standardLocations(QStandardPaths::GenericDataLocation))
    folders << data + QStringLiteral("/innergs") << data + QStringLiteral("/mricron/templates");
  QStringList programs = QStandardPaths::standardLocations(QStandardPaths::ApplicationsLocation);
  for (const char* variable : {"ProgramFiles", "ProgramFiles(x86)", "LOCALAPPDATA"})
    if (const QString folder = qEnvironmentVariable(variable); !folder.isEmpty()) programs << folder;
  for (const QString& folder : programs)
    for (const char* inside :
         {"/MRIcron.app/Contents/Resources/templates", "/MRIcron/Resources/templates", "/MRIcron/templates"})
      folders << folder + QLatin1String(inside);
  return folders;
}

} // namespace

QString sampleBrain() {
  QString chosen = appSettings()->value(kChosen).toString();
  if (!chosen.isEmpty() && QFileInfo(chosen).isReadable()) return chosen;
  for (const QString& folder : places()) {
    const QFileInfo file(folder + QStringLiteral("/ch2.nii.gz"));
    if (file.isFile() && file.isReadable()) return file.canonicalFilePath();
  }
  return {};
}

void rememberSampleBrain(const QString& file) {
  appSettings()->setValue(kChosen, file);
}

QString whatIsTheSampleBrain() {
  return tr("The sample brain (Colin 27) is not on this computer: choose the file ch2.nii.gz from the folder "
            "'templates' of MRIcron (www.nitrc.org/projects/mricron; on Debian and Ubuntu the package "
            "mricron-data), or any T1 head with voxels of about 1 mm.");
}

std::vector<VolumeItem> makeSample(const QString& brain) {
  constexpr double thickness = 5, coarsest = 2; // mm
  Volume head = readVolume(pathOf(brain));
  const double step = head.geometry.spacing[2];
  const int slices = static_cast<int>(std::lround(thickness / step));
  if (step > coarsest || head.geometry.size[2] < 4 * slices)
    throw Error(ErrorCode::InvalidArgument,
                tr("'%1' is too coarse to make a sample from: choose a whole head with slices about 1 mm "
                   "apart.")
                    .arg(brain)
                    .toStdString());
  Stack scan = simulateThickStack(head, 2, slices);
  const bool colin27 = QFileInfo(brain).fileName().startsWith(QLatin1String("ch2"));
  const QString name = colin27 ? tr("Brain") : nameOf(brain);
  std::vector<VolumeItem> items;
  items.push_back(makeItem(std::move(scan.image),
                           tr("%1, %2 mm slices").arg(name, ui::lengthText(scan.thickness)), {},
                           scan.thickness, 2));
  if (colin27)
    items.back().caveat =
        tr("The start weights of InnerGS were learned from this head, among others: its figures "
           "here are not held out. On your own scans they are.");
  items.push_back(makeItem(std::move(head), tr("%1, %2 mm").arg(name, ui::lengthText(step)), brain));
  items.back().role = VolumeRole::Truth;
  return items;
}

} // namespace innergs::app
