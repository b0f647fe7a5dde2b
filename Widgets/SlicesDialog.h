#pragma once
#include <QDialog>

class QTableView;
class vtkTable;

namespace innergs::ui {

/// Where the slices of several scans lie, as rows that sort by any column.
class SlicesDialog : public QDialog {
  Q_OBJECT
public:
  /// slices: as vtkInnerGSReconstruct::GetSliceTable(). saved: whether there is a button to save them.
  SlicesDialog(vtkTable* slices, bool saved, QWidget* parent);

Q_SIGNALS:
  void saveRequested();

private:
  void fill(vtkTable* slices);

  QTableView* table_;
};

} // namespace innergs::ui
