#include "Widgets/OutputBox.h"

#include "Widgets/NumberSpin.h"
#include "Widgets/PanelTools.h"
#include "Widgets/TextFormat.h"

#include <QComboBox>
#include <QFormLayout>
#include <QLabel>
#include <QSignalBlocker>
#include <QVBoxLayout>

#include <algorithm>

namespace innergs::ui {

OutputBox::OutputBox(Host* host, QWidget* parent)
    : QWidget(parent), host_(host), grid_(new QComboBox(this)),
      explanation_(makeWrappedLabel("gridExplanation", this)), spacing_(new NumberSpin({1e-3, 1000}, this)) {
  named(grid_, "outputGrid", tr("The voxels that the result is computed on."));
  grid_->addItem(tr("Automatic"), static_cast<int>(OutputGrid::Automatic));
  grid_->addItem(tr("Voxels of the first scan"), static_cast<int>(OutputGrid::Input));
  grid_->addItem(tr("Cubes of a given size"), static_cast<int>(OutputGrid::Spacing));
  if (host->offers(Host::Role::Reference))
    grid_->addItem(tr("Voxels of another volume"), static_cast<int>(OutputGrid::Reference));

  named(spacing_, "outputSpacing", tr("Edge of the result's voxels in mm."));
  spacing_->setSuffix(tr(" mm"));
  spacing_->setValue(asked_);

  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  const auto addForm = [&](QWidget* parent) {
    QFormLayout* form = makeForm(parent);
    form->setContentsMargins(0, 0, 0, 0);
    return form;
  };
  const auto addSelector = [&](QFormLayout* form, Host::Role role, const char* name, const QString& label,
                               const QString& tip) {
    if (!host->offers(role)) return static_cast<Selector*>(nullptr);
    Selector* selector = named(host->createSelector(role, this), name, tip);
    form->addRow(label, selector);
    connect(selector, &Selector::currentIdChanged, this, &OutputBox::changed);
    return selector;
  };
  QFormLayout* gridForm = addForm(nullptr);
  gridForm->addRow(tr("Result &grid:"), grid_);
  layout->addLayout(gridForm);
  layout->addWidget(explanation_);
  // A hidden row of a form leaves a gap, so each row that is shown on demand is a separate widget.
  spacingRow_ = new QWidget(this);
  addForm(spacingRow_)->addRow(tr("Voxel s&ize:"), spacing_);
  layout->addWidget(spacingRow_);
  referenceRow_ = new QWidget(this);
  reference_ = addSelector(addForm(referenceRow_), Host::Role::Reference, "referenceSelector",
                           tr("Reference vo&lume:"), tr("The result uses this volume's voxel grid."));
  layout->addWidget(referenceRow_);
  QFormLayout* outputs = addForm(nullptr);
  volume_ = addSelector(outputs, Host::Role::OutputVolume, "outputVolumeSelector", tr("Result vol&ume:"),
                        tr("The volume that the result is written to, or a new one."));
  model_ = addSelector(outputs, Host::Role::OutputModel, "outputModelSelector", tr("Result m&odel:"),
                       tr("The Gaussian model that the result is written to, or a new one."));
  if (volume_ || model_)
    layout->addLayout(outputs);
  else
    delete outputs;
  guardWheel(this);
  showFields();

  connect(grid_, QOverload<int>::of(&QComboBox::currentIndexChanged), this, [this] {
    showFields();
    Q_EMIT changed();
  });
  connect(spacing_, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, [this](double mm) {
    asked_ = mm;
    Q_EMIT changed();
  });
}

void OutputBox::fill(Request& request) const {
  request.grid = static_cast<OutputGrid>(grid_->currentData().toInt());
  request.spacing = asked_;
  request.referenceId = reference_ ? reference_->currentId() : QString();
  request.outputVolumeId = volume_ ? volume_->currentId() : QString();
  request.outputModelId = model_ ? model_->currentId() : QString();
}

void OutputBox::set(const Request& request) {
  const QSignalBlocker quiet(this), quietSpacing(spacing_);
  grid_->setCurrentIndex(std::max(0, grid_->findData(static_cast<int>(request.grid))));
  spacing_->setValue(asked_ = request.spacing);
  if (reference_) reference_->setCurrentId(request.referenceId);
  if (volume_) volume_->setCurrentId(request.outputVolumeId);
  if (model_) model_->setCurrentId(request.outputModelId);
  showFields();
}

void OutputBox::explain(const QVector<InputChoice>& inputs) {
  QString text;
  const auto grid = static_cast<OutputGrid>(grid_->currentData().toInt());
  if (grid == OutputGrid::Automatic) {
    double finest = 0;
    for (const InputChoice& input : inputs)
      for (const double mm : host_->volumeInfo(input.id).spacing)
        if (mm > 0 && (finest == 0 || mm < finest)) finest = mm;
    text = inputs.isEmpty() || finest == 0
               ? tr("Cubes at the finest spacing of all scans.")
               : tr("Cubes of %1 mm, the finest spacing of all scans.").arg(lengthText(finest));
  } else if (grid == OutputGrid::Input) {
    text = tr("The same voxels as the first scan: for denoising, or to compare.");
  }
  explanation_->setText(text);
  explanation_->setVisible(!text.isEmpty());
}

void OutputBox::showFields() {
  const auto grid = static_cast<OutputGrid>(grid_->currentData().toInt());
  spacingRow_->setVisible(grid == OutputGrid::Spacing);
  referenceRow_->setVisible(grid == OutputGrid::Reference);
}

} // namespace innergs::ui
