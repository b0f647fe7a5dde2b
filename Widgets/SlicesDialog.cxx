#include "Widgets/SlicesDialog.h"

#include "Widgets/PanelTools.h"

#include <vtkTable.h>
#include <vtkVariant.h>

#include <QDialogButtonBox>
#include <QHeaderView>
#include <QLabel>
#include <QLocale>
#include <QPushButton>
#include <QStandardItemModel>
#include <QTableView>
#include <QVBoxLayout>

#include <cmath>

namespace innergs::ui {
namespace {

struct Column {
  const char* name; // in the table
  QString title, toolTip;
  int digits; // after the point
};

QVector<Column> columns() {
  return {{"Scan", SlicesDialog::tr("Scan"), SlicesDialog::tr("The scan, in the order of the list."), 0},
          {"Slice", SlicesDialog::tr("Slice"), SlicesDialog::tr("The slice of that scan, from 0."), 0},
          {"Displacement (mm)", SlicesDialog::tr("Moved by (mm)"),
           SlicesDialog::tr(
               "How far the slice moved relative to its scan (root mean square over what it shows)."),
           2},
          {"Angle (degrees)", SlicesDialog::tr("Turned by (°)"),
           SlicesDialog::tr("How far the slice turned relative to its scan."), 2},
          {"Weight", SlicesDialog::tr("Weight"),
           SlicesDialog::tr("How much the slice counts; 0: it fits nowhere and was left out."), 2},
          {"Gain", SlicesDialog::tr("Gain"),
           SlicesDialog::tr("The factor that its values were multiplied by."), 3},
          {"Residual", SlicesDialog::tr("Residual"),
           SlicesDialog::tr("How much it differs from what the other scans show there (scanner units)."), 2}};
}

QStandardItem* cell(double value, int digits) {
  auto* item = new QStandardItem(std::isfinite(value) ? QLocale().toString(value, 'f', digits)
                                                      : QString::fromUtf8("–"));
  item->setData(std::isfinite(value) ? value : -1.0, Qt::UserRole);
  item->setTextAlignment(Qt::AlignRight | Qt::AlignVCenter);
  item->setEditable(false);
  return item;
}

} // namespace

SlicesDialog::SlicesDialog(vtkTable* slices, bool saved, QWidget* parent)
    : QDialog(parent), table_(new QTableView(this)) {
  setObjectName(QStringLiteral("slicesDialog"));
  setWindowTitle(tr("Slices of the result"));
  table_->setObjectName(QStringLiteral("slicesTable"));
  table_->setAccessibleName(windowTitle());
  table_->setSelectionBehavior(QAbstractItemView::SelectRows);
  table_->verticalHeader()->hide();
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Close, this);
  auto* layout = new QVBoxLayout(this);
  QLabel* line = makeWrappedLabel(QStringLiteral("slicesExplanation"), this);
  line->setText(tr("Each slice was moved to where it fits the other scans best. Click a title to sort."));
  layout->addWidget(line);
  layout->addWidget(table_, 1);
  layout->addWidget(buttons);
  if (saved) {
    QPushButton* save =
        named(buttons->addButton(tr("&Save…"), QDialogButtonBox::ActionRole), "saveSlices",
              tr("Save this table, with the place of every slice, as tab-separated values (.tsv)."));
    connect(save, &QPushButton::clicked, this, &SlicesDialog::saveRequested);
  }
  connect(buttons, &QDialogButtonBox::rejected, this, &QDialog::reject);
  fill(slices);
}

void SlicesDialog::fill(vtkTable* slices) {
  auto* model = new QStandardItemModel(this);
  model->setSortRole(Qt::UserRole);
  const QVector<Column> shown = columns();
  const auto rows = static_cast<int>(slices->GetNumberOfRows());
  for (int c = 0; c < shown.size(); ++c) {
    for (int row = 0; row < rows; ++row)
      model->setItem(row, c, cell(slices->GetValueByName(row, shown[c].name).ToDouble(), shown[c].digits));
    model->setHorizontalHeaderItem(c, new QStandardItem(shown[c].title));
    model->horizontalHeaderItem(c)->setToolTip(shown[c].toolTip);
  }
  table_->setModel(model);
  table_->horizontalHeader()->setSortIndicator(-1, Qt::AscendingOrder); // at first in the table's order
  table_->setSortingEnabled(true);
  table_->resizeColumnsToContents();
  const int width = table_->horizontalHeader()->length() + 6 * fontMetrics().averageCharWidth();
  table_->setMinimumWidth(width);
  resize(width, 28 * fontMetrics().lineSpacing());
}

} // namespace innergs::ui
