#pragma once
#include "Widgets/App/ViewState.h"

#include <QWidget>

class QTreeWidget;
class QTreeWidgetItem;
class QPushButton;

namespace innergs::app {

/// Volumes and models of the document: what the views show, names, saving, closing.
class DataList : public QWidget {
  Q_OBJECT
public:
  explicit DataList(ViewState* state, QWidget* parent = nullptr);
  /// Of the selected line; "" none.
  QString currentId() const;
  void setCurrentId(const QString& id);

Q_SIGNALS:
  void saveRequested(const QString& id);
  void closeRequested(const QString& id);
  void currentIdChanged(const QString& id);

private:
  void fill();
  void showDetails();
  void choose();
  void changed(QTreeWidgetItem* item);
  ViewState* state_;
  QTreeWidget* tree_;
  QPushButton *save_, *rename_, *close_;
};

} // namespace innergs::app
