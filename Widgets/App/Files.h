#pragma once
#include "Widgets/App/Document.h"

#include <optional>

/// Files and folders to items and back. For worker threads; everything throws Error with one sentence.
namespace innergs::app {

/// What was found in a file or DICOM folder: one of the two.
struct Loaded {
  std::optional<VolumeItem> volume;
  std::optional<ModelItem> model;
  QString note; // a sentence for the log; may be ""
};
Loaded readItem(const QString& path);

void saveItem(const VolumeItem& item, const QString& file);
void saveItem(const ModelItem& item, const QString& file);

/// Whether a file is read as a model.
bool isModelFile(const QString& path);
/// Gaussians alone: without the detail grid and the training state of a model.
bool isPly(const QString& path);

///@{
/// Filters of file dialogs.
QString openFilter();
QString volumeFilter();
QString modelFilter();
///@}

/// The packaged brain of the demo; "" where it is not installed.
QString sampleBrain();
/// A scan with 5 mm axial slices, simulated from that brain, and the brain itself to compare with.
std::vector<VolumeItem> makeSample(const QString& brain);
/// How to get it, a sentence.
QString howToGetSampleBrain();

} // namespace innergs::app
