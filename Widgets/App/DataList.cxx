#include "Widgets/App/DataList.h"

#include "Widgets/PanelTools.h"
#include "Widgets/TextFormat.h"

#include <QHBoxLayout>
#include <QHeaderView>
#include <QLabel>
#include <QLocale>
#include <QMenu>
#include <QPushButton>
#include <QShortcut>
#include <QSignalBlocker>
#include <QSpinBox>
#include <QStyle>
#include <QTreeWidget>
#include <QVBoxLayout>

namespace innergs::app {
namespace {

constexpr int kIdRole = Qt::UserRole;

QString sizeOf(const VolumeItem& item) {
  const GridGeometry& g = item.volume->geometry;
  return QStringLiteral("%1×%2×%3").arg(g.size[0]).arg(g.size[1]).arg(g.size[2]);
}

QString tipOf(const VolumeItem& item) {
  const GridGeometry& g = item.volume->geometry;
  QString tip =
      DataList::tr("%1 voxels of %2 × %3 × %4 mm, %5 slices\n%6")
          .arg(sizeOf(item))
          .arg(ui::lengthText(g.spacing[0]), ui::lengthText(g.spacing[1]), ui::lengthText(g.spacing[2]))
          .arg(orientationOf(g, item.sliceAxis), item.saved ? item.file : DataList::tr("Not saved yet"));
  return item.note.isEmpty() ? tip : tip + QLatin1Char('\n') + item.note;
}

} // namespace

DataList::DataList(ViewState* state, QWidget* parent)
    : QWidget(parent), state_(state), tree_(new QTreeWidget(this)), frameRow_(new QWidget(this)),
      frame_(new QSpinBox(frameRow_)), time_(new QLabel(frameRow_)),
      save_(new QPushButton(tr("Save…"), this)), rename_(new QPushButton(tr("Rename"), this)),
      close_(new QPushButton(tr("Close"), this)) {
  ui::named(tree_, "dataTree", tr("Select a volume to show it in the views; F2 renames, Del closes."));
  tree_->setAccessibleName(tr("Volumes and models"));
  tree_->setColumnCount(2);
  tree_->setHeaderLabels({tr("Name"), tr("Size")}); // for screen readers
  tree_->setHeaderHidden(true);
  tree_->header()->setStretchLastSection(false);
  tree_->header()->setSectionResizeMode(0, QHeaderView::Stretch);
  tree_->header()->setSectionResizeMode(1, QHeaderView::ResizeToContents);
  tree_->setRootIsDecorated(false);
  tree_->setTextElideMode(Qt::ElideMiddle); // the frame is at the end
  tree_->setEditTriggers(QAbstractItemView::EditKeyPressed);
  tree_->setContextMenuPolicy(Qt::CustomContextMenu);
  tree_->setMinimumHeight(9 * fontMetrics().height() / 2); // scan, head, result, model
  ui::named(frame_, "frame", tr("Which image of the 4D file is shown and reconstructed."));
  frame_->setAccessibleName(tr("Frame"));
  frame_->setKeyboardTracking(false);
  frame_->setMinimum(1);
  ui::named(time_, "frameTime", tr("Time since the first frame, as the file says."));
  auto* frameLayout = ui::layoutWithoutMargins<QHBoxLayout>(frameRow_);
  frameLayout->addWidget(new QLabel(tr("Frame"), frameRow_));
  frameLayout->addWidget(frame_);
  frameLayout->addWidget(time_, 1);
  ui::named(save_, "saveItem", tr("Save the selected volume or model to a file."));
  ui::named(rename_, "renameItem", tr("Rename the selected volume or model (F2)."));
  ui::named(close_, "closeItem",
            tr("Remove the selected volume or model from the list (Del); its file is kept."));
  auto* buttons = new QHBoxLayout;
  for (QPushButton* button : {save_, rename_, close_})
    buttons->addWidget(button);
  auto* layout = new QVBoxLayout(this);
  layout->addWidget(tree_, 1);
  layout->addWidget(frameRow_);
  layout->addLayout(buttons);

  connect(frame_, QOverload<int>::of(&QSpinBox::valueChanged), this, [this](int frame) {
    waitingFor_ = currentId();
    Q_EMIT frameChosen(waitingFor_, frame - 1);
  });
  connect(save_, &QPushButton::clicked, this, [this] { Q_EMIT saveRequested(currentId()); });
  connect(close_, &QPushButton::clicked, this, [this] { Q_EMIT closeRequested(currentId()); });
  // Without mnemonics, as the list is visible next to every panel.
  auto* del = new QShortcut(QKeySequence::Delete, tree_, nullptr, nullptr, Qt::WidgetShortcut);
  connect(del, &QShortcut::activated, close_, &QPushButton::click);
  connect(rename_, &QPushButton::clicked, this, [this] { tree_->editItem(tree_->currentItem(), 0); });
  connect(tree_, &QTreeWidget::itemSelectionChanged, this, &DataList::choose);
  connect(tree_, &QTreeWidget::itemChanged, this, &DataList::changed);
  connect(tree_, &QTreeWidget::customContextMenuRequested, this, [this](const QPoint& at) {
    if (!tree_->itemAt(at)) return;
    QMenu menu(this);
    menu.addAction(tr("Save…"), save_, &QPushButton::click);
    menu.addAction(tr("Rename"), rename_, &QPushButton::click);
    menu.addAction(tr("Close"), close_, &QPushButton::click);
    menu.exec(tree_->viewport()->mapToGlobal(at));
  });
  connect(state->document(), &Document::volumesChanged, this, &DataList::fill);
  connect(state->document(), &Document::modelsChanged, this, &DataList::fill);
  connect(state, &ViewState::volumeChanged, this, [this] {
    if (!state_->document()->model(currentId())) setCurrentId(state_->volumeId());
    showDetails();
  });
  fill();
}

QString DataList::currentId() const {
  const QTreeWidgetItem* item = tree_->currentItem();
  return item ? item->data(0, kIdRole).toString() : QString();
}

void DataList::setCurrentId(const QString& id) {
  for (int n = 0; n < tree_->topLevelItemCount(); ++n)
    if (tree_->topLevelItem(n)->data(0, kIdRole).toString() == id)
      tree_->setCurrentItem(tree_->topLevelItem(n));
}

void DataList::fill() {
  const QString before = currentId();
  {
    const QSignalBlocker blocker(tree_);
    tree_->clear();
    const auto add = [&](const QString& id, const QString& name, const QString& size, const QString& tip) {
      auto* line = new QTreeWidgetItem(tree_, {name, size});
      line->setData(0, kIdRole, id);
      line->setFlags(line->flags() | Qt::ItemIsEditable);
      line->setToolTip(0, tip);
      line->setToolTip(1, tip);
    };
    for (const auto& item : state_->document()->volumes())
      add(item->id, item->name, sizeOf(*item), tipOf(*item));
    for (const auto& item : state_->document()->models())
      add(item->id, item->name, ui::gaussiansText(item->model->GetNumberOfGaussians()),
          item->saved ? item->file : tr("Not saved yet"));
    setCurrentId(before.isEmpty() ? state_->volumeId() : before);
    if (!tree_->currentItem()) setCurrentId(state_->volumeId());
  }
  showDetails();
}

void DataList::showDetails() {
  const QSignalBlocker blocker(tree_);
  for (int n = 0; n < tree_->topLevelItemCount(); ++n) {
    QTreeWidgetItem* line = tree_->topLevelItem(n);
    const QString id = line->data(0, kIdRole).toString();
    const auto volume = state_->document()->volume(id);
    const auto model = state_->document()->model(id);
    QFont font = tree_->font();
    font.setBold(id == state_->volumeId());                                 // shown in the views
    font.setItalic((volume && !volume->saved) || (model && !model->saved)); // not saved yet
    line->setFont(0, font);
  }
  const bool any = tree_->currentItem() != nullptr;
  for (QPushButton* button : {save_, rename_, close_})
    button->setEnabled(any);
  showFrame();
}

void DataList::frameFailed() {
  waitingFor_.clear();
  showFrame();
}

void DataList::showFrame() {
  const auto item = state_->document()->volume(currentId());
  const bool several = item && item->frames.count > 1;
  frameRow_->setVisible(several);
  if (!several) return;
  const Frames& frames = item->frames;
  const QSignalBlocker blocker(frame_);
  frame_->setSuffix(tr(" of %1").arg(frames.count));
  frame_->setMaximum(frames.count);
  // While frames are read one after another, the last choice is kept.
  if (waitingFor_ != item->id || frame_->value() == frames.shown + 1) waitingFor_.clear();
  if (waitingFor_.isEmpty()) frame_->setValue(frames.shown + 1);
  time_->setText(frames.seconds > 0
                     ? tr("at %1 s").arg(QLocale().toString(frames.shown * frames.seconds, 'g', 6))
                     : QString());
}

void DataList::choose() {
  const QString id = currentId();
  if (state_->document()->volume(id)) state_->setVolumeId(id);
  showDetails();
  Q_EMIT currentIdChanged(id);
}

void DataList::changed(QTreeWidgetItem* item) {
  const QString id = item->data(0, kIdRole).toString(), name = item->text(0);
  // Later: this rebuilds the list, and the editor still uses this line.
  QMetaObject::invokeMethod(
      this,
      [this, id, name] {
        state_->document()->rename(id, name);
        fill();
      },
      Qt::QueuedConnection);
}

} // namespace innergs::app
