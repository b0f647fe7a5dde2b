#include "Widgets/App/Files.h"

#include "Core/Base/Error.h"
#include "Core/Base/Failure.h"
#include "IO/DicomSeries.h"
#include "IO/DynamicModelFile.h"
#include "IO/FilePath.h"
#include "IO/ImageReading.h"
#include "IO/ModelFile.h"
#include "IO/Ply.h"
#include "IO/TimeSeriesIO.h"
#include "IO/TrackedSweep.h"
#include "Widgets/App/Translate.h"

#include <QDir>
#include <QFile>
#include <QFileInfo>

#include <algorithm>
#include <cmath>
#include <exception>
#include <limits>

namespace innergs::app {
namespace {

std::size_t nonFinite(const Volume& volume) {
  return static_cast<std::size_t>(
      std::count_if(volume.voxels.begin(), volume.voxels.end(), [](float v) { return !std::isfinite(v); }));
}

/// A tracked sweep with its images in place, where it is known: in the stack, or why it is not.
struct SweepPlaces {
  Stack stack;
  QString unknown; // a sentence
};

SweepPlaces placesOf(LoadedImage& image, const QString& path, const QString& calibration) {
  const NamedTransforms given =
      calibration.isEmpty() ? NamedTransforms{} : readCalibration(pathOf(calibration));
  const std::string what = quoted(pathOf(path));
  SweepPlaces found;
  const std::string why = whyNotPlaced(image.sweepFields, given, what);
  if (!why.empty() && !calibration.isEmpty()) throw Error(ErrorCode::UnsupportedImage, why);
  found.unknown = QString::fromStdString(why);
  if (!why.empty()) return found;
  found.stack = placedSweep(std::move(image.volume), image.sweepFields, given, what);
  auto& voxels = found.stack.image.voxels;
  for (std::size_t v = 0; v < found.stack.observed.size(); ++v)
    if (!found.stack.observed[v]) voxels[v] = std::numeric_limits<float>::quiet_NaN(); // left out of the fit
  return found;
}

ModelItem readModelItem(const QString& path) {
  AnyModel read = readAnyModel(pathOf(path));
  if (read.field)
    return makeItem(read.field, nameOf(path), path, std::move(read.notes), std::move(read.features));
  if (read.model->field.gaussians.empty())
    throw Error(ErrorCode::NoData,
                tr("The model '%1' has no Gaussians: choose another.").arg(path).toStdString());
  return makeItem(std::move(read.model), nameOf(path), path, std::move(read.notes), std::move(read.features));
}

} // namespace

std::filesystem::path pathOf(const QString& path) {
  return innergs::pathOf(path.toStdString());
}

QString nameOf(const QString& path) {
  QString name = QFileInfo(QDir::cleanPath(path)).fileName();
  if (QFileInfo(path).isDir()) return name;
  if (name.endsWith(QLatin1String(".gz"), Qt::CaseInsensitive)) name.chop(3);
  const int dot = name.lastIndexOf(QLatin1Char('.'));
  return dot > 0 ? name.left(dot) : name;
}

bool isModelFile(const QString& path) {
  return path.endsWith(QLatin1String(".innergs"), Qt::CaseInsensitive) || isPly(path);
}

bool isPly(const QString& path) {
  return innergs::isPly(pathOf(path));
}

QString nameOfFrame(QString name, int before, int frame) {
  const auto ending = [](int shown) { return tr(" frame %1").arg(shown + 1); };
  if (const int at = name.lastIndexOf(ending(before)); before >= 0 && at > 0) name.truncate(at);
  return name + ending(frame);
}

std::vector<Loaded> readItems(const QString& path, QStringList* leftOut) {
  std::vector<DicomEntry> series;
  if (QFileInfo(path).isDir() && frameFiles(pathOf(path)).empty()) series = listDicomSeries(pathOf(path));
  if (series.size() < 2) return {readItem(path)};
  std::vector<Loaded> items;
  std::exception_ptr failed;
  for (std::size_t n = 0; n < series.size(); ++n) {
    const DicomEntry& entry = series[n];
    QString name = QString::fromStdString(entry.description);
    if (name.isEmpty()) name = tr("%1 series %2").arg(nameOf(path)).arg(n + 1);
    if (!entry.detail.empty()) name += QStringLiteral(", ") + QString::fromStdString(entry.detail);
    try {
      items.push_back(readItem(path, 0, static_cast<int>(n) + 1));
      items.back().volume->name = name;
    } catch (...) {
      *leftOut << tr("'%1' was left out. %2").arg(name, QString::fromStdString(failureOf().sentence));
      if (!failed) failed = std::current_exception();
    }
  }
  if (items.empty()) std::rethrow_exception(failed);
  return items;
}

Loaded readItem(const QString& path, int frame, std::optional<int> series, const QString& calibration) {
  Loaded loaded;
  if (isModelFile(path)) {
    loaded.model = readModelItem(path);
    return loaded;
  }
  const auto files = frameFiles(pathOf(path)); // of a folder with a dynamic scan
  if (!files.empty() && (frame < 0 || static_cast<std::size_t>(frame) >= files.size()))
    throw Error(ErrorCode::InvalidArgument,
                tr("'%1' has no frame %2.").arg(path).arg(frame + 1).toStdString());
  LoadedImage image = files.empty() ? loadImage(pathOf(path), {frame, series}) : loadImage(files[frame], {});
  if (!files.empty()) image.frames = static_cast<std::int64_t>(files.size());
  SweepPlaces places;
  if (image.tracked) places = placesOf(image, path, calibration);
  if (!places.stack.poses.empty()) {
    image.volume = std::move(places.stack.image);
    image.poses = std::move(places.stack.poses);
    image.remarks = std::move(places.stack.remarks);
    image.slicesAreAlongK = true;
    if (!(image.sliceThickness > 0)) image.sliceThickness = places.stack.thickness;
  }
  const auto& size = image.volume.geometry.size;
  if (*std::min_element(size.begin(), size.end()) < 2)
    throw Error(ErrorCode::UnsupportedImage,
                (image.slicesAreAlongK
                     ? tr("'%1' has a single slice; at least two are needed (open the folder with all "
                          "slices of the DICOM series).")
                     : tr("'%1' has a single slice; at least two are needed."))
                    .arg(path)
                    .toStdString());
  loaded.volume = makeItem(std::move(image.volume), nameOf(path), path, image.sliceThickness,
                           image.slicesAreAlongK ? 2 : -1);
  VolumeItem& item = *loaded.volume;
  if (std::ssize(image.sliceTimes) == item.volume->geometry.size[item.sliceAxis])
    item.times = std::move(image.sliceTimes);
  item.poses = std::move(image.poses);
  item.unplaced = places.unknown;
  QStringList notes;
  for (const std::string& remark : image.remarks)
    notes << QString::fromStdString(remark);
  if (!item.poses.empty())
    notes
        << tr("The views show the slices of '%1' as parallel ones, evenly apart: a reconstruction puts each "
              "where it lies.")
               .arg(item.name);
  if (image.frames > 1) {
    item.frames = {path,
                   static_cast<int>(std::min<std::int64_t>(image.frames, std::numeric_limits<int>::max())),
                   frame, image.frameSeconds};
    notes << tr("'%1' holds %n frames: frame %2 is open; choose another below the list of data, or make a "
                "continuous "
                "volume in space and time of all in the panel Dynamic scan.",
                nullptr, item.frames.count)
                 .arg(item.name)
                 .arg(frame + 1);
    item.name = nameOfFrame(item.name, -1, frame);
  }
  if (const std::size_t unknown = nonFinite(*item.volume); unknown == item.volume->voxels.size())
    throw Error(ErrorCode::NoData,
                tr("'%1' has no voxel with a finite value: export it again.").arg(path).toStdString());
  else if (unknown > 0)
    notes << tr("%Ln of %L1 voxels of '%2' are not finite (NaN or infinity): they are left out of the "
                "reconstruction.",
                nullptr, static_cast<int>(std::min<std::size_t>(unknown, std::numeric_limits<int>::max())))
                 .arg(item.volume->voxels.size())
                 .arg(item.name);
  if (!item.unplaced.isEmpty())
    notes << item.unplaced
          << tr("Open it again to choose the file: until then its images are shown as parallel slices and "
                "cannot be reconstructed.");
  item.note = notes.join(QLatin1Char('\n'));
  return loaded;
}

void saveItem(const VolumeItem& item, const QString& file) {
  const auto path = pathOf(file);
  if (hasNoGrid(item)) throw noGridError(item);
  if (item.segments.empty()) {
    writeVolume(*item.volume, path);
    return;
  }
  writeVolume(*item.volume, path, item.segments.size() > 255 ? OutputType::UInt16 : OutputType::UInt8, {},
              fullExtension(path) == ".nrrd" ? segmentFields(item.segments, item.volume->geometry)
                                             : std::map<std::string, std::string>{});
}

void saveItem(const ModelItem& item, const QString& file) {
  if (isPly(file))
    writePly(item.model->GetCoreModel()->field, pathOf(file));
  else if (file.endsWith(QLatin1String(".innergs"), Qt::CaseInsensitive))
    item.dynamic
        ? writeDynamicModel(*item.dynamic->GetField(), pathOf(file), item.notes, {},
                            item.dynamic->GetFeatures().get())
        : writeModel(*item.model->GetCoreModel(), pathOf(file), item.notes, item.model->GetFeatures().get());
  else
    throw Error(ErrorCode::InvalidArgument,
                tr("'%1' has no extension of a model: name it .innergs (keeps everything) "
                   "or .ply.")
                    .arg(file)
                    .toStdString());
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

} // namespace innergs::app
