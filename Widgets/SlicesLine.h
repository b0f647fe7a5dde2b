#pragma once
#include "Widgets/Host.h"

#include <QPointer>
#include <QWidget>

class QPushButton;
class vtkTable;

namespace innergs::ui {

class MessageLine;
class SlicesDialog;

/// Where the slices of the last result lie: a table, and a transform of each. Hidden without a result.
class SlicesLine : public QWidget {
  Q_OBJECT
public:
  explicit SlicesLine(Host* host, QWidget* parent = nullptr);
  void refresh();

private:
  void showTable();
  void createTransforms();
  void createIn(const QString& folder);
  void saveTable();
  void say(const QString& done, const QString& error);

  Host* host_;
  QPushButton *show_, *create_;
  MessageLine* message_;
  QPointer<SlicesDialog> dialog_;
  vtkSmartPointer<vtkTable> slices_; // that the buttons are about
};

} // namespace innergs::ui
