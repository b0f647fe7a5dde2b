#include "Widgets/InputsTable.h"

#include "Widgets/InputRow.h"
#include "Widgets/PanelTools.h"

#include <QSignalBlocker>
#include <QToolButton>
#include <QVBoxLayout>

#include <algorithm>
#include <utility>

namespace innergs::ui {

InputsTable::InputsTable(Host* host, QWidget* parent)
    : QWidget(parent), host_(host), rowsLayout_(new QVBoxLayout), add_(new QToolButton(this)) {
  named(add_, "addInput",
        tr("Add a scan of the same patient in another orientation:\n"
           "together they give a sharper result."));
  add_->setText(tr("&Add another scan"));
  add_->setFocusPolicy(Qt::StrongFocus);
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  layout->addLayout(rowsLayout_);
  layout->addWidget(add_, 0, Qt::AlignLeft);
  addRow();
  number();
  connect(add_, &QToolButton::clicked, this, [this] {
    InputRow* row = addRow();
    row->setChoice({}); // not the first scan again
    number();
    row->setFocus();
    tell();
  });
  connect(host, &Host::volumesChanged, this, [this] {
    for (InputRow* row : std::as_const(rows_))
      row->refresh();
    if (inputs() != lastInputs_)
      tell();
    else
      Q_EMIT refreshed();
  });
  lastInputs_ = inputs();
}

void InputsTable::tell() {
  lastInputs_ = inputs();
  Q_EMIT changed();
}

void InputsTable::suggest(const QString& id) {
  if (rows_.size() != 1) return;
  InputChoice now = rows_.first()->choice();
  const bool free = now.id.isEmpty() || now.id == suggested_;
  now.id.clear();
  if (!free || now != InputChoice{}) return;
  suggested_ = id;
  rows_.first()->setChoice({id});
}

QVector<InputChoice> InputsTable::inputs() const {
  QVector<InputChoice> chosen;
  for (const InputRow* row : rows_)
    if (const InputChoice choice = row->choice(); !choice.id.isEmpty()) chosen << choice;
  return chosen;
}

void InputsTable::setInputs(const QVector<InputChoice>& inputs) {
  if (inputs == this->inputs()) return;
  {
    const QSignalBlocker quiet(this);
    while (rows_.size() > std::max<qsizetype>(1, inputs.size()))
      removeRow(rows_.last());
    while (rows_.size() < inputs.size())
      addRow();
    for (int i = 0; i < rows_.size(); ++i)
      rows_[i]->setChoice(inputs.value(i));
    number();
  }
  tell();
}

InputRow* InputsTable::addRow() {
  auto* row = new InputRow(host_, this);
  rows_ << row;
  rowsLayout_->addWidget(row);
  row->setVisible(true);
  connect(row, &InputRow::changed, this, &InputsTable::tell);
  connect(row, &InputRow::removeRequested, this, [this, row] {
    const int place = rows_.indexOf(row);
    removeRow(row);
    number();
    rows_[std::min<int>(place, rows_.size() - 1)]->setFocus();
    tell();
  });
  return row;
}

void InputsTable::removeRow(InputRow* row) {
  rows_.removeOne(row);
  rowsLayout_->removeWidget(row);
  row->hide();
  row->deleteLater();
}

void InputsTable::number() {
  for (int i = 0; i < rows_.size(); ++i)
    rows_[i]->setPlace(i + 1, rows_.size() == 1);
  chainTabs();
}

void InputsTable::chainTabs() {
  QVector<QWidget*> fields;
  for (const InputRow* row : rows_)
    fields << row->fields();
  for (int i = 1; i < fields.size(); ++i)
    setTabOrder(fields[i - 1], fields[i]);
  setTabOrder(fields.last(), add_);
}

} // namespace innergs::ui
