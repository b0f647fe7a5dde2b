#pragma once
#include "Widgets/App/DataItems.h"

#include <QStringList>

#include <filesystem>
#include <optional>

/// Converts files and folders to items and back. For worker threads; all functions throw Error with one
/// sentence.
namespace innergs::app {

/// The content of a file or DICOM folder: one of the two.
struct Loaded {
  std::optional<VolumeItem> volume;
  std::optional<ModelItem> model;
};
/// frame: of a 4D file, from 0. series: of a DICOM folder with several, from 1. calibration: of a tracked
/// sweep that lacks it, a file.
Loaded readItem(const QString& path, int frame = 0, std::optional<int> series = {},
                const QString& calibration = {});
/// Likewise for each series of a DICOM folder, named by its description. Skips those that cannot be read,
/// with a sentence for each in `*leftOut`; throws the first one's Error if none can be read.
std::vector<Loaded> readItems(const QString& path, QStringList* leftOut);
/// The name of an item that is one frame of a 4D file, from its name for another one (−1: none yet).
QString nameOfFrame(QString name, int before, int frame);

void saveItem(const VolumeItem& item, const QString& file);
void saveItem(const ModelItem& item, const QString& file);

/// Whether a file is read as a model.
bool isModelFile(const QString& path);
/// Gaussians only: without a model's residual grid and training state.
bool isPly(const QString& path);

///@{
/// Filters of file dialogs.
QString openFilter();
QString volumeFilter();
QString modelFilter();
///@}

std::filesystem::path pathOf(const QString& path);
/// A readable name: the file's, without folder and extension.
QString nameOf(const QString& path);

} // namespace innergs::app
