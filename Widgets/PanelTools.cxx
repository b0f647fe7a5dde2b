#include "Widgets/PanelTools.h"

#include "Widgets/HeightForWidth.h"
#include "Widgets/Host.h"
#include "Widgets/SaveDialog.h"

#include <QAbstractSpinBox>
#include <QComboBox>
#include <QEvent>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QLabel>
#include <QScrollArea>
#include <QScrollBar>
#include <QSlider>
#include <QTimer>

#include <algorithm>

namespace innergs::ui {

namespace {

constexpr int kLayoutDelays[] = {50, 400}; // ms: the layout takes longer on a busy machine

void open(QFileDialog* dialog, const char* name, Host* host, const FileChosen& chosen) {
  named(dialog, name);
  dialog->setAttribute(Qt::WA_DeleteOnClose);
  QObject::connect(dialog, &QFileDialog::fileSelected, dialog->parentWidget(), [=](const QString& selected) {
    auto* save = qobject_cast<SaveDialog*>(dialog);
    const QString file = save ? save->complete(selected) : selected;
    if (file.isEmpty()) return;
    host->setFolder(QFileInfo(file).absolutePath());
    chosen(file);
  });
  dialog->open();
}

} // namespace

QFormLayout* makeForm(QWidget* parent) {
  auto* form = new QFormLayout(parent);
  form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  form->setRowWrapPolicy(QFormLayout::WrapLongRows);
  return form;
}

QLabel* labelFor(QWidget* field, const QString& text) {
  auto* label = new QLabel(text);
  label->setBuddy(field);
  label->setToolTip(field->toolTip());
  return label;
}

QLabel* makeWrappedLabel(const QString& objectName, QWidget* parent) {
  auto* label = new HeightForWidth<QLabel>(parent);
  label->setWordWrap(true);
  label->setObjectName(objectName);
  label->setTextFormat(Qt::PlainText);
  label->setTextInteractionFlags(Qt::TextSelectableByMouse);
  return label;
}

namespace {

class WheelGuard : public QObject {
public:
  using QObject::QObject;
  bool eventFilter(QObject* watched, QEvent* event) override {
    if (event->type() != QEvent::Wheel || static_cast<QWidget*>(watched)->hasFocus()) return false;
    event->ignore();
    return true;
  }
};

} // namespace

void guardWheel(QWidget* parent) {
  auto* guard = new WheelGuard(parent);
  const auto add = [guard](QWidget* widget) {
    widget->setFocusPolicy(Qt::StrongFocus);
    widget->installEventFilter(guard);
  };
  for (auto* spin : parent->findChildren<QAbstractSpinBox*>())
    add(spin);
  for (auto* combo : parent->findChildren<QComboBox*>())
    add(combo);
  for (auto* slider : parent->findChildren<QSlider*>())
    add(slider);
}

void reveal(QWidget* first, QWidget* last) {
  for (const int delay : kLayoutDelays)
    QTimer::singleShot(delay, last, [first, last] {
      for (QWidget* parent = last->parentWidget(); parent; parent = parent->parentWidget())
        if (auto* area = qobject_cast<QScrollArea*>(parent)) {
          const int top = first->mapTo(area->widget(), QPoint(0, 0)).y();
          const int bottom = last->mapTo(area->widget(), QPoint(0, last->height())).y();
          QScrollBar* bar = area->verticalScrollBar();
          bar->setValue(std::min(std::max(bar->value(), bottom - area->viewport()->height()), top));
          return;
        }
    });
}

void askForFile(QWidget* parent, Host* host, const char* name, const QString& title, const QString& filters,
                const FileChosen& chosen) {
  auto* dialog = new QFileDialog(parent, title, host->folder(), filters);
  dialog->setFileMode(QFileDialog::ExistingFile);
  open(dialog, name, host, chosen);
}

void askWhereToSave(QWidget* parent, Host* host, const char* name, const QString& title,
                    const QString& filters, const QString& proposed, const FileChosen& chosen) {
  open(new SaveDialog(parent, title, host->folder(), filters, proposed), name, host, chosen);
}

} // namespace innergs::ui
