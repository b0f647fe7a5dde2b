#pragma once
#include "Widgets/Host.h"

class QCheckBox;
class QLabel;
class QPushButton;

namespace innergs::ui {

class MessageLine;

/// Describes a model, its origin and whether it is saved; loads and saves models and shows their Gaussians.
class ModelPanel : public QWidget {
  Q_OBJECT
public:
  explicit ModelPanel(Host* host, QWidget* parent = nullptr);

  QString modelId() const { return modelId_; }
  void setModelId(const QString& id);

Q_SIGNALS:
  void modelIdChanged(const QString& id);

private:
  void build();
  void refresh();
  void load();
  void save();
  void loadFile(const QString& file);
  void saveFile(const QString& file);

  Host* host_;
  QString modelId_;
  Selector* selector_ = nullptr;
  QLabel *state_ = nullptr, *gaussians_ = nullptr, *memory_ = nullptr, *size_ = nullptr, *origin_ = nullptr,
         *file_ = nullptr, *description_ = nullptr, *shown_ = nullptr;
  MessageLine* message_ = nullptr;
  QCheckBox* ellipsoids_ = nullptr;
  QPushButton *load_ = nullptr, *save_ = nullptr;
};

} // namespace innergs::ui
