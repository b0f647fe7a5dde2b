#pragma once
#include "Widgets/Host.h"
#include "Widgets/SegmentWorker.h"

class QCheckBox;
class QComboBox;
class QLabel;
class QLineEdit;
class QListWidget;
class QProgressBar;
class QPushButton;
class QDoubleSpinBox;

namespace innergs::ui {

class MessageLine;
class ValueSlider;

/// "Find a structure": a model learns segments from labels, and is asked for them in words. What is found is
/// shown in the host's views at once and kept on request.
class FindPanel : public QWidget {
  Q_OBJECT
public:
  explicit FindPanel(Host* host, QWidget* parent = nullptr);
  ~FindPanel() override;

  QString modelId() const { return modelId_; }
  void setModelId(const QString& id);
  bool isLearning() const { return learning_; }
  /// As if typed and entered.
  void find(const QString& text);

Q_SIGNALS:
  void modelIdChanged(const QString& id);

private:
  QWidget* buildLearning();
  QWidget* buildFinding();
  void chooseOnlyModel();
  void updateModel();
  void updateLearning();
  void learnOrCancel();
  void learned(const std::shared_ptr<const FeatureModel>& features);
  void endLearning();
  void chooseNames();
  void ask(int candidate);
  void showFound(const FindResult& result);
  void add();
  void clearFound();

  Host* host_;
  SegmentWorker* worker_;
  QString modelId_, learningId_;           // learningId_: of the model that learns
  QString lastId_;                         // of the last model that was chosen
  vtkSmartPointer<vtkInnerGSModel> model_; // as it was last seen; null: none
  bool learning_ = false;
  bool prepared_ = true; // the worker has been told to decode the model
  bool asking_ = false;  // an answer is pending
  MadeSegments made_;    // what is shown
  QString asked_;        // the query of what is listed

  Selector *selector_ = nullptr, *labels_ = nullptr;
  QLineEdit* names_ = nullptr;
  QCheckBox *sparse_ = nullptr, *largest_ = nullptr, *thresholded_ = nullptr;
  QPushButton *learn_ = nullptr, *find_ = nullptr, *add_ = nullptr;
  QProgressBar *progress_ = nullptr, *decoding_ = nullptr;
  QLabel *state_ = nullptr, *found_ = nullptr;
  QComboBox* text_ = nullptr; // with the earlier queries
  MessageLine *learningMessage_ = nullptr, *answer_ = nullptr;
  QListWidget* candidates_ = nullptr;
  ValueSlider* threshold_ = nullptr;
  QDoubleSpinBox *smoothing_ = nullptr, *minimum_ = nullptr;
  QWidget* finding_ = nullptr;
};

} // namespace innergs::ui
