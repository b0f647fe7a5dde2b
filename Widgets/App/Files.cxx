#include "Widgets/App/Files.h"

#include "Core/Error.h"
#include "Core/Simulate.h"
#include "IO/ImageReading.h"
#include "IO/ModelFile.h"
#include "IO/Ply.h"

#include <QCoreApplication>
#include <QDir>
#include <QFile>
#include <QFileInfo>

#include <algorithm>

namespace innergs::app {
namespace {

QString tr(const char* text) {
  return QCoreApplication::translate("innergs::app", text);
}

std::filesystem::path pathOf(const QString& path) {
  const QByteArray utf8 = path.toUtf8();
  return std::filesystem::path(std::u8string(utf8.begin(), utf8.end()));
}

/// A name for people: the file's without folder and extension.
QString nameOf(const QString& path) {
  QString name = QFileInfo(QDir::cleanPath(path)).fileName();
  if (QFileInfo(path).isDir()) return name;
  if (name.endsWith(QLatin1String(".gz"), Qt::CaseInsensitive)) name.chop(3);
  const int dot = name.lastIndexOf(QLatin1Char('.'));
  return dot > 0 ? name.left(dot) : name;
}

ModelItem readModelItem(const QString& path) {
  std::shared_ptr<const Checkpoint> model;
  if (isPly(path)) {
    Checkpoint checkpoint;
    checkpoint.field = readPly(pathOf(path));
    checkpoint.finished = checkpoint.field.size();
    model = std::make_shared<const Checkpoint>(std::move(checkpoint));
  } else {
    model = std::make_shared<const Checkpoint>(readModel(pathOf(path)));
  }
  if (model->field.gaussians.empty())
    throw Error(ErrorCode::NoData,
                "The model '" + path.toStdString() + "' has no Gaussians: choose another.");
  return makeItem(std::move(model), nameOf(path), path);
}

} // namespace

bool isModelFile(const QString& path) {
  return path.endsWith(QLatin1String(".innergs"), Qt::CaseInsensitive) || isPly(path);
}

bool isPly(const QString& path) {
  return path.endsWith(QLatin1String(".ply"), Qt::CaseInsensitive);
}

Loaded readItem(const QString& path) {
  Loaded loaded;
  if (isModelFile(path)) {
    loaded.model = readModelItem(path);
    return loaded;
  }
  LoadedImage image = loadImage(pathOf(path), {0});
  const auto& size = image.volume.geometry.size;
  if (*std::min_element(size.begin(), size.end()) < 2)
    throw Error(
        ErrorCode::UnsupportedImage,
        "'" + path.toStdString() + "' has a single slice; at least two are needed" +
            (image.slicesAreAlongK ? " (open the folder with all slices of the DICOM series)." : "."));
  if (image.frames > 1)
    loaded.note = tr("'%1' holds %2 frames: the first one was opened.").arg(path).arg(image.frames);
  loaded.volume = makeItem(std::move(image.volume), nameOf(path), path, image.sliceThickness,
                           image.slicesAreAlongK ? 2 : -1);
  return loaded;
}

void saveItem(const VolumeItem& item, const QString& file) {
  writeVolume(*item.volume, pathOf(file));
}

void saveItem(const ModelItem& item, const QString& file) {
  if (isPly(file))
    writePly(item.model->GetCheckpoint()->field, pathOf(file));
  else if (file.endsWith(QLatin1String(".innergs"), Qt::CaseInsensitive))
    writeModel(*item.model->GetCheckpoint(), pathOf(file));
  else
    throw Error(ErrorCode::InvalidArgument, "'" + file.toStdString() +
                                                "' has no extension of a model: name it .innergs (keeps "
                                                "everything) or .ply.");
}

QString openFilter() {
  return tr("Volumes and models (*.nii *.nii.gz *.nrrd *.nhdr *.mha *.mhd *.mnc *.innergs *.ply);;"
            "Volumes (*.nii *.nii.gz *.nrrd *.nhdr *.mha *.mhd *.mnc);;Models (*.innergs *.ply);;"
            "All files (*)");
}

QString volumeFilter() {
  return tr("NIfTI, compressed (*.nii.gz);;NIfTI (*.nii);;NRRD (*.nrrd);;MetaImage (*.mha)");
}

QString modelFilter() {
  return tr("InnerGS model (*.innergs);;PLY, Gaussians alone (*.ply)");
}

QString sampleBrain() {
  for (const char* folder : {"/usr/share/mricron/templates", "/usr/local/share/mricron/templates"}) {
    const QString file = QString::fromLatin1(folder) + QStringLiteral("/ch2.nii.gz");
    if (QFileInfo(file).isReadable()) return file;
  }
  return {};
}

std::vector<VolumeItem> makeSample(const QString& brain) {
  constexpr int thickness = 5; // voxels of 1 mm
  Volume head = readVolume(pathOf(brain));
  Stack scan = simulateThickStack(head, 2, thickness);
  std::vector<VolumeItem> items;
  items.push_back(makeItem(std::move(scan.image), tr("Brain, 5 mm slices"), {}, scan.thickness, 2));
  items.push_back(makeItem(std::move(head), tr("Brain, 1 mm"), brain));
  return items;
}

QString howToGetSampleBrain() {
  return tr("The sample brain (Colin 27) is not on this computer. On Debian or Ubuntu install the package "
            "mricron-data; "
            "elsewhere get MRIcron (www.nitrc.org/projects/mricron) and open ch2.nii.gz from its folder of "
            "templates. Or "
            "open a scan of your own.");
}

} // namespace innergs::app
