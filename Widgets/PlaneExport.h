#pragma once
#include "Widgets/PlaneWorker.h"
#include "Widgets/Request.h"

#include <QList>
#include <QObject>
#include <QString>

#include <functional>

class QWidget;

namespace innergs::ui {

class Host;

/// A plane and the model that it cuts.
struct ModelPlane {
  PlaneTask task;
  QString modelId;
  ModelInfo model;
};

/// Exports a plane: to the host's volumes, to a picture, or to the clipboard as a command line.
class PlaneExport : public QObject {
  Q_OBJECT
public:
  /// current: returns the plane to export; without a model, nothing is exported. Nothing else may export with
  /// the worker.
  PlaneExport(Host* host, PlaneWorker* worker, std::function<ModelPlane()> current, QWidget* parent);

  void addToVolumes();
  /// Asks for a file; the plane is the one shown when the dialog is accepted.
  void savePicture();
  void copyCommand();

Q_SIGNALS:
  /// What was done, or why nothing was: a sentence.
  void said(const QString& sentence, bool error);

private:
  void exportPlane(const QString& picture);
  void finish(const PlaneImage& image);

  Host* host_;
  PlaneWorker* worker_;
  std::function<ModelPlane()> current_;
  QWidget* parent_;
  struct Pending {
    QString name, modelId;
  };
  QList<Pending> pending_; // in the worker's order
};

} // namespace innergs::ui
