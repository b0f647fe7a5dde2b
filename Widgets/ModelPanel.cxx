#include "Widgets/ModelPanel.h"

#include "IO/Ply.h"
#include "Widgets/MessageLine.h"
#include "Widgets/PanelTools.h"
#include "Widgets/TextFormat.h"

#include "vtkInnerGSModel.h"

#include <QCheckBox>
#include <QDir>
#include <QFileInfo>
#include <QFormLayout>
#include <QHBoxLayout>
#include <QLabel>
#include <QLocale>
#include <QPushButton>
#include <QSignalBlocker>

namespace innergs::ui {

namespace {

QString filters(bool both) {
  const QString model = ModelPanel::tr("InnerGS model (*.innergs)"),
                ply = ModelPanel::tr("Gaussians as PLY (*.ply)");
  const QString each = model + QStringLiteral(";;") + ply;
  return both ? ModelPanel::tr("Models (*.innergs *.ply)") + QStringLiteral(";;") + each : each;
}

} // namespace

ModelPanel::ModelPanel(Host* host, QWidget* parent) : QWidget(parent), host_(host) {
  build();
  connect(selector_, &Selector::currentIdChanged, this, &ModelPanel::refresh);
  connect(host_, &Host::modelsChanged, this, &ModelPanel::refresh);
  connect(load_, &QPushButton::clicked, this, &ModelPanel::load);
  connect(save_, &QPushButton::clicked, this, &ModelPanel::save);
  connect(ellipsoids_, &QCheckBox::clicked, this, [this](bool shown) {
    message_->say(host_->showEllipsoids(modelId_, shown), true);
    refresh(); // shows what is, not what was asked for
  });
  refresh();
}

void ModelPanel::build() {
  auto* all = layoutWithoutMargins<QVBoxLayout>(this);
  selector_ = named(host_->createSelector(Host::Role::Model, this), "modelSelector",
                    tr("The model that this panel shows."));
  auto* choice = new QHBoxLayout;
  auto* label = new QLabel(tr("&Model"));
  label->setBuddy(selector_);
  choice->addWidget(label);
  choice->addWidget(selector_, 1);
  all->addLayout(choice);

  auto* form = new QFormLayout;
  form->setLabelAlignment(Qt::AlignLeft);
  form->setRowWrapPolicy(QFormLayout::DontWrapRows);
  const auto row = [&](QLabel*& value, const char* name, const QString& text, const QString& toolTip) {
    value = named(new QLabel, name, toolTip);
    value->setWordWrap(true);
    value->setTextFormat(Qt::PlainText);
    value->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
    auto* title = new QLabel(text);
    title->setToolTip(toolTip);
    title->setAlignment(Qt::AlignLeft | Qt::AlignTop);
    title->setSizePolicy(QSizePolicy::Preferred, QSizePolicy::Expanding);
    form->addRow(title, value);
  };
  row(state_, "modelState", tr("State"), tr("Whether the model is saved in a file."));
  row(gaussians_, "modelGaussians", tr("Gaussians"), tr("Number of Gaussians in the model."));
  row(memory_, "modelMemory", tr("Memory"), tr("Memory that the model uses."));
  row(size_, "modelSize", tr("Extent"),
      tr("Size of the box that holds the fitted region, along right–left, anterior–posterior and "
         "superior–inferior."));
  row(origin_, "modelOrigin", tr("From"), tr("The scans or the file it comes from."));
  row(file_, "modelFile", tr("File"), tr("The file it was last read from or saved to, and its size."));
  row(description_, "modelDescription", tr("Summary"), tr("Its Gaussians, blending, extent and memory."));
  all->addLayout(form);

  ellipsoids_ = named(new QCheckBox(tr("Show &ellipsoids")), "modelEllipsoids",
                      tr("Show the Gaussians with the largest weights as ellipsoids (one standard deviation) "
                         "in the 3D view."));
  load_ = named(new QPushButton(tr("&Load…")), "modelLoad",
                tr("Read a model (.innergs) or Gaussians (.ply) from a file."));
  save_ = named(new QPushButton(tr("&Save…")), "modelSave",
                tr("Save the model (.innergs: all of it; .ply: its Gaussians for other programs)."));
  auto* buttons = new QHBoxLayout;
  buttons->addWidget(ellipsoids_);
  buttons->addStretch(1);
  buttons->addWidget(load_);
  buttons->addWidget(save_);
  all->addLayout(buttons);
  shown_ = makeWrappedLabel(QStringLiteral("modelEllipsoidsShown"), this);
  shown_->setToolTip(tr("Those with the largest weights, except those close to the background."));
  all->addWidget(shown_);

  message_ = named(new MessageLine, "modelMessage");
  all->addWidget(message_);
}

void ModelPanel::setModelId(const QString& id) {
  selector_->setCurrentId(id);
  refresh();
}

void ModelPanel::refresh() {
  const QString id = selector_->currentId();
  const bool known = !id.isEmpty() && host_->model(id);
  const ModelInfo info = known ? host_->modelInfo(id) : ModelInfo();
  const QLocale locale;
  const QString none = QStringLiteral("–");
  QFont font = state_->font();
  font.setBold(known && !info.saved);
  state_->setFont(font);
  state_->setText(!known ? tr("No model chosen") : info.saved ? tr("Saved") : tr("Not saved yet"));
  gaussians_->setText(known ? countText(info.gaussians) : none);
  memory_->setText(known ? memorySize(info.bytes) : none);
  const auto length = [&](int axis) {
    return locale.toString(info.bounds[2 * axis + 1] - info.bounds[2 * axis], 'f', 1);
  };
  size_->setText(known && info.bounds[1] >= info.bounds[0]
                     ? tr("%1 × %2 × %3 mm along R, A, S").arg(length(0), length(1), length(2))
                     : none);
  origin_->setText(info.origin.isEmpty() ? none : info.origin);
  const QFileInfo file(info.file);
  file_->setText(info.file.isEmpty() ? none
                 : file.exists()
                     ? tr("%1 (%2)").arg(QDir::toNativeSeparators(info.file), memorySize(file.size()))
                     : tr("%1 (no longer there)").arg(QDir::toNativeSeparators(info.file)));
  description_->setText(info.description.isEmpty() ? none : info.description);
  ellipsoids_->setChecked(info.ellipsoidsShown);
  ellipsoids_->setEnabled(known);
  shown_->setText(shownGaussiansText(info.ellipsoids, info.gaussians) + QLatin1Char('.'));
  shown_->setVisible(info.ellipsoidsShown && info.ellipsoids > 0);
  save_->setEnabled(known);
  if (id == modelId_) return;
  modelId_ = id;
  message_->say({});
  Q_EMIT modelIdChanged(id);
}

void ModelPanel::load() {
  askForFile(this, host_, "modelLoadDialog", tr("Load a model"), filters(true),
             [this](const QString& file) { loadFile(file); });
}

void ModelPanel::save() {
  QString name = host_->modelInfo(modelId_).name;
  name.replace(QLatin1Char('/'), QLatin1Char('-'));
  askWhereToSave(this, host_, "modelSaveDialog", tr("Save the model"), filters(false),
                 name + QStringLiteral(".innergs"), [this](const QString& file) { saveFile(file); });
}

void ModelPanel::loadFile(const QString& file) {
  QString error;
  const QString id = host_->loadModel(file, &error);
  if (id.isEmpty()) {
    message_->say(error.isEmpty() ? tr("'%1' could not be read.").arg(QDir::toNativeSeparators(file)) : error,
                  true);
    return;
  }
  setModelId(id);
  message_->say(tr("Loaded '%1'.").arg(QDir::toNativeSeparators(file)));
}

void ModelPanel::saveFile(const QString& file) {
  const QString error = host_->saveModel(modelId_, file);
  refresh();
  if (!error.isEmpty()) return message_->say(error, true);
  QString done = tr("Saved to '%1'.").arg(QDir::toNativeSeparators(file));
  vtkInnerGSModel* const model = host_->model(modelId_);
  if (model && model->GetField() && file.endsWith(QLatin1String(".ply"), Qt::CaseInsensitive))
    done += QLatin1Char(' ') +
            QString::fromStdString(droppedByPly(*model->GetField(), model->GetNumberOfSegments()));
  message_->say(done);
}

} // namespace innergs::ui
