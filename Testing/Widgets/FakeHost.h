#pragma once
#include "Widgets/Host.h"

#include <QMap>

#include <vtkSmartPointer.h>
#include <vtkTable.h>

#include <functional>

namespace innergs {
struct GaussianField;
}
class QComboBox;

/// A Host with made-up volumes and a made-up reconstruction, for the panels' tests. The test is the worker:
/// it sends progress, previews and the end itself.
class FakeHost : public innergs::ui::Host {
  Q_OBJECT
public:
  /// Volumes "head" (axial, 256×256×30 at 0.9×0.9×4 mm), "side" (sagittal) and "thin" (1 mm cubes), the
  /// mask "brain" and the region "box".
  explicit FakeHost(QObject* parent = nullptr);
  ~FakeHost() override;

  ///@{
  /// What there is. Roles: what offers() says; all but OutputModel by default.
  void addVolume(const QString& id, const innergs::ui::VolumeInfo& info);
  void removeVolume(const QString& id);
  QVector<Role> roles;
  QMap<QString, QString> masks, regions, slicePoses; // ID → name
  bool hasSlicePoses() const override { return !slicePoses.isEmpty(); }
  /// A ball of Gaussians of 40 mm around the origin (RAS), values 0 to 100.
  QString addBallModel(const QString& name = "Ball", int gaussians = 400);
  ///@}

  ///@{
  /// The reconstruction.
  innergs::ui::Estimate nextEstimate;
  QString refusal;             // start() fails with it
  bool cancelsByItself = true; // once events are processed; otherwise the test calls sendCancelled()
  QVector<innergs::ui::Request> estimated, requests; // what was asked for, in order
  int cancels = 0;
  void sendProgress(innergs::Phase phase, double fraction, int iteration = 0, double loss = 0,
                    double psnr = 0, double remaining = 0, const std::string& note = {});
  int members = 1, coarseIterations = 0; // of every progress sent
  /// A ball of n³ voxels, values 0 to 100.
  void sendPreview(int n = 48);
  void sendFinished(const innergs::ui::Report& report);
  void sendFailed(const QString& sentence);
  void sendCancelled();
  void sendEnded(const QString& why);
  /// A report with everything in it.
  static innergs::ui::Report exampleReport();
  ///@}

  ///@{
  /// The last result's slices.
  bool result = false;
  vtkSmartPointer<vtkTable> slices; // null: none was moved
  bool slicesInFiles = false;
  QString slicesError; // what creating and saving fails with; "" = they work
  QStringList transformFolders, savedTables;
  /// Two scans of three slices, the last of which was left out.
  static vtkSmartPointer<vtkTable> exampleSlices();
  ///@}

  ///@{
  /// What was done with models and volumes.
  QMap<QString, innergs::ui::ModelInfo> models;
  QMap<QString, vtkSmartPointer<vtkInnerGSModel>> modelData;
  QMap<QString, std::shared_ptr<const innergs::ui::UncertaintyVolume>> uncertainties; // by model
  QStringList savedFiles, loadedFiles, addedVolumes;                                  // addedVolumes: names
  vtkSmartPointer<vtkImageData> lastAddedImage;
  vtkSmartPointer<vtkMatrix4x4> lastAddedMatrix;
  QString modelError; // what load, save, show and addVolume fail with; "" = they work
  QMap<QString, innergs::ui::VolumeInfo> volumes;
  ///@}

  bool offers(Role role) const override;
  innergs::ui::Selector* createSelector(Role role, QWidget* parent) override;
  innergs::ui::VolumeInfo volumeInfo(const QString& id) const override;
  innergs::ui::Estimate estimate(const innergs::ui::Request& request) override;
  bool start(const innergs::ui::Request& request) override;
  void cancel() override;
  bool isRunning() const override { return running_; }
  bool hasResult() const override { return result; }
  vtkTable* sliceTable() const override { return slices; }
  bool keepsSlicesInFiles() const override { return slicesInFiles; }
  QString createSliceTransforms(const QString& folder, QString* error) override;
  QString saveSliceTable(const QString& file) override;
  innergs::ui::ModelInfo modelInfo(const QString& id) const override;
  QString onlyModel() const override { return models.size() == 1 ? models.firstKey() : QString(); }
  vtkInnerGSModel* model(const QString& id) const override;
  std::shared_ptr<const innergs::ui::UncertaintyVolume> uncertaintyOf(const QString& id) const override {
    return uncertainties.value(id);
  }
  QString loadModel(const QString& file, QString* error) override;
  QString saveModel(const QString& id, const QString& file) override;
  QString showEllipsoids(const QString& id, bool shown) override;
  QString addVolume(vtkImageData* image, vtkMatrix4x4* ijkToRAS, const QString& name,
                    QString* error) override;
  innergs::ui::MotionHost* motion() override { return motionHost; }
  innergs::ui::MotionHost* motionHost = nullptr; // the test's own
  QMap<QString, QString> series;                 // ID → name
  QString folder() const override { return folder_; }
  QString recovery; // the folder of recovered fits
  QString recoveryFolder() const override { return recovery; }
  void setFolder(const QString& folder) override { folder_ = folder; }

  /// ID → name of what a role can choose from.
  QMap<QString, QString> choices(Role role) const;

private:
  void end();

  bool running_ = false;
  QString folder_;
};

/// A combo box of the fake's objects; keeps its choice when the list changes.
class FakeSelector : public innergs::ui::Selector {
  Q_OBJECT
public:
  FakeSelector(FakeHost* host, innergs::ui::Host::Role role, QWidget* parent);
  QString currentId() const override;
  void setCurrentId(const QString& id) override;

private:
  void refill();

  FakeHost* host_;
  innergs::ui::Host::Role role_;
  QComboBox* combo_;
};
