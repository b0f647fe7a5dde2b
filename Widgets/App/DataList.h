#pragma once
#include "Widgets/App/ViewState.h"

#include <QWidget>

class QLabel;
class QSpinBox;
class QTreeWidget;
class QTreeWidgetItem;
class QPushButton;

namespace innergs::app {

/// The document's volumes and models: what the views show, names, frames of 4D files, saving, closing.
class DataList : public QWidget {
  Q_OBJECT
public:
  explicit DataList(ViewState* state, QWidget* parent = nullptr);
  /// Of the selected line; "" if none.
  QString currentId() const;
  void setCurrentId(const QString& id);
  /// The frame chosen last could not be read.
  void frameFailed();

Q_SIGNALS:
  void saveRequested(const QString& id);
  void closeRequested(const QString& id);
  void currentIdChanged(const QString& id);
  /// From 0.
  void frameChosen(const QString& id, int frame);

private:
  void fill();
  void showDetails();
  void choose();
  void changed(QTreeWidgetItem* item);
  void showFrame();
  ViewState* state_;
  QTreeWidget* tree_;
  QWidget* frameRow_;
  QSpinBox* frame_;
  QLabel* time_;
  QString waitingFor_; // the item whose chosen frame is being read
  QPushButton *save_, *rename_, *close_;
};

} // namespace innergs::app
