#include "Widgets/SettingsPanel.h"

#include "Core/Render/Render.h"
#include "Widgets/FieldForm.h"
#include "Widgets/PanelTools.h"

#include <QGroupBox>
#include <QLabel>
#include <QPushButton>
#include <QVBoxLayout>

#include <iterator>

namespace innergs::ui {

SettingsPanel::SettingsPanel(QWidget* parent) : QWidget(parent), form_(new FieldForm(this)) {
  auto* layout = new QVBoxLayout(this);
  layout->setContentsMargins(0, 0, 0, 0);
  auto* hint = makeWrappedLabel("settingsHint", this);
  hint->setText(tr("\"automatic\" is chosen from the preset and the scans. Empty a field to return to it."));
  layout->addWidget(hint);
  addModel();
  addFit();
  addSchedule();
  addDensification();
  addComputation();
  auto* defaults = new QPushButton(tr("Restore defaul&ts"), this);
  defaults->setObjectName("restoreDefaults");
  defaults->setToolTip(tr("All advanced settings as they were at first. Preset and device stay."));
  layout->addWidget(defaults, 0, Qt::AlignLeft);
  guardWheel(this);
  form_->show();
  refresh();
  connect(defaults, &QPushButton::clicked, this, &SettingsPanel::restoreDefaults);
  connect(form_, &FieldForm::changed, this, [this] {
    refresh();
    Q_EMIT settingsChanged();
  });
}

Settings SettingsPanel::settings() const {
  return form_->settings;
}

void SettingsPanel::setSettings(const Settings& settings) {
  form_->settings = settings;
  form_->show();
  refresh();
  Q_EMIT settingsChanged();
}

void SettingsPanel::restoreDefaults() {
  Settings settings;
  settings.preset = form_->settings.preset;
  settings.device = form_->settings.device;
  setSettings(settings);
}

QWidget* SettingsPanel::makeGroup(const QString& title) {
  auto* group = new QGroupBox(title, this);
  auto* form = new QFormLayout(group);
  form->setFieldGrowthPolicy(QFormLayout::AllNonFixedFieldsGrow);
  form->setRowWrapPolicy(QFormLayout::WrapLongRows);
  form_->setLayout(form);
  layout()->addWidget(group);
  return group;
}

void SettingsPanel::addModel() {
  makeGroup(tr("Model"));
  form_->addChoice<Blending>(
      {"blending", tr("Blending:"),
       tr("How overlapping Gaussians add up.\n"
          "Normalised: their weighted mean; additive: their sum;\n"
          "alpha: one behind the other along the slices, as in the paper.")},
      {{tr("normalised"), Blending::Normalised},
       {tr("additive"), Blending::Additive},
       {tr("alpha"), Blending::Alpha}},
      [](auto& s) -> auto& { return s.blending; });
  form_->addYesNo(
      {"linearIntensity", tr("Linear intensity:"),
       tr("Each Gaussian's intensity may slope across it (normalised blending only).")},
      [](auto& s) -> auto& { return s.linearIntensity; });
  form_->addNumber(
      {"cutoff", tr("Cut-off radius (σ):"),
       tr("Where Gaussians end, in standard deviations, 1 to 5. Usual: 2.2; the paper: 3.")},
      {1, 5, false, true, 2.2}, [](auto& s) -> auto& { return s.cutoff; });
  form_->addChoice<Initialisation>(
      {"initialisation", tr("Start:"),
       tr("Where the Gaussians start.\nAdaptive: where the structure is; grid: evenly.")},
      {{tr("adaptive"), Initialisation::Adaptive}, {tr("even grid"), Initialisation::Grid}},
      [](auto& s) -> auto& { return s.initialisation; });
  form_->addNumber(
      {"gaussians", tr("Gaussians:"), tr("Gaussians of one field at its start.")},
      {1, 1e9, true, true, 10000}, [](auto& s) -> auto& { return s.gaussians; });
  form_->addNumber(
      {"members", tr("Merged fields:"),
       tr("Fields fitted independently and merged, 1 to 64: more is slower and less noisy\n"
          "between slices. Automatic: from the preset and the gap between slices.")},
      {1, 64, true, true, 1}, [](auto& s) -> auto& { return s.ensembleSize; });
}

void SettingsPanel::addFit() {
  makeGroup(tr("Fit"));
  form_->addNumber(
      {"iterations", tr("Iterations:"), tr("Iterations over the data for each field.")},
      {1, 1e6, true, true, 100}, [](auto& s) -> auto& { return s.iterations; });
  form_->addChoice<LossKind>(
      {"loss", tr("Loss:"), tr("What the fit minimises between scan and model.")},
      {{tr("L1"), LossKind::L1}, {tr("L2"), LossKind::L2}, {tr("Huber"), LossKind::Huber}},
      [](auto& s) -> auto& { return s.loss; });
  form_->addNumber(
      {"pointWeight", tr("Weight of the loss:"), tr("Usual: 1; the paper: 0.8.")}, {0, 1000, false, true, 1},
      [](auto& s) -> auto& { return s.pointWeight; });
  form_->addNumber(
      {"ssimWeight", tr("Weight of 1 − SSIM:"),
       tr("Weight of structural dissimilarity beside the loss. Usual: 0; the paper: 0.4.")},
      {0, 1000, false, true, 0.4}, [](auto& s) -> auto& { return s.ssimWeight; });
  form_->addNumber(
      {"huberDelta", tr("Huber's δ:"),
       tr("Where the Huber loss turns linear, as a fraction of the intensity range.")},
      {1e-6, 1, false, false, 0}, [](auto& s) -> auto& { return s.huberDelta; });
  form_->addYesNo(
      {"allAxes", tr("Slices of all axes:"),
       tr("Fit the slices of one scan along all three of its axes.\n"
          "Automatic: with alpha blending, where the voxels are nearly cubes.")},
      [](auto& s) -> auto& { return s.allAxes; });
  form_->addCheck(
      {"relocate", tr("Move useless Gaussians"),
       tr("On an even grid: prune Gaussians without use and split those where the error is.")},
      [](auto& s) -> auto& { return s.relocate; });
  form_->addCheck(
      {"consistency", tr("Data-consistency step"),
       tr("After the fit, put back what the slices still demand, as far as it is not noise\n"
          "(where slices are far apart or several scans are fitted).")},
      [](auto& s) -> auto& { return s.consistency; });
}

void SettingsPanel::addSchedule() {
  makeGroup(tr("Learning rates"));
  form_->addChoice<Schedule>(
      {"schedule", tr("Schedule:"),
       tr("Exponential: the rates decay over the iterations;\nplateau: they fall when the loss stops "
          "improving.")},
      {{tr("exponential"), Schedule::Exponential}, {tr("plateau"), Schedule::Plateau}},
      [](auto& s) -> auto& { return s.schedule; });
  form_->addNumber(
      {"plateauPatience", tr("Patience (iterations):"),
       tr("Plateau: iterations without improvement before the rates fall.")},
      {1, 1e6}, [](auto& s) -> auto& { return s.plateau.patience; });
  form_->addNumber(
      {"plateauFactor", tr("Factor:"), tr("Plateau: what the rates are multiplied by then.")},
      {1e-6, 0.999999}, [](auto& s) -> auto& { return s.plateau.factor; });
  form_->addNumber(
      {"plateauLowest", tr("Lowest share:"),
       tr("Plateau: the share of the first rates that they never fall below.")},
      {1e-9, 1}, [](auto& s) -> auto& { return s.plateau.lowest; });
  form_->addNumber(
      {"plateauThreshold", tr("Improvement:"),
       tr("Plateau: the relative fall of the loss that counts as an improvement.")},
      {0, 0.999999}, [](auto& s) -> auto& { return s.plateau.threshold; });
  form_->addNumber(
      {"beta1", tr("Adam's β₁:"),
       tr("Share of the old mean of the gradient in the new one, between 0 and 1. Usual: 0.8.")},
      {1e-6, 0.999999, false, true, 0.8}, [](auto& s) -> auto& { return s.beta1; });
  form_->addNumber(
      {"beta2", tr("Adam's β₂:"),
       tr("Share of the old mean of its square in the new one, between 0 and 1. Usual: 0.95.")},
      {1e-6, 0.9999999, false, true, 0.95}, [](auto& s) -> auto& { return s.beta2; });
  form_->addYesNo(
      {"paperStopRule", tr("Paper's stop rule:"),
       tr("Stop when the loss fell by less than 1e-4 over 100 iterations, after 1000 at the latest.")},
      [](auto& s) -> auto& { return s.paperStopRule; });
}

void SettingsPanel::addDensification() {
  makeGroup(tr("Densification"));
  form_->addNumber(
      {"densifyEvery", tr("Every (iterations):"),
       tr("Prune and densify Gaussians every so many iterations; 0: never.\n"
          "Automatic: 10 with the preset paper or with a largest number below, else never.")},
      {0, 1e6, true, true, 10}, [](auto& s) -> auto& { return s.densifyEvery; });
  form_->addNumber(
      {"maxGaussians", tr("Most Gaussians:"),
       tr("That densification may reach. Automatic: as many as at the start.")},
      {1, 1e9, true, true, 100000}, [](auto& s) -> auto& { return s.maxGaussians; });
  form_->addNumber(
      {"pruneOpacity", tr("Prune below opacity:"),
       tr("Gaussians of a lower opacity are pruned.\n"
          "Automatic: 0.3 for alpha blending, 0.01 for the others.")},
      {0, 0.999999, false, true, 0.01}, [](auto& s) -> auto& { return s.densify.opacity; });
  form_->addNumber(
      {"pruneSize", tr("Prune above σ (voxels):"),
       tr("Gaussians with a larger standard deviation, in voxels, are pruned.")},
      {1e-3, 1e4}, [](auto& s) -> auto& { return s.densify.size; });
  form_->addNumber(
      {"densifyGradient", tr("Densify above pull:"),
       tr("Gaussians whose move by one voxel would lower the loss by more than that of so many\n"
          "samples become two.")},
      {0, 1e6}, [](auto& s) -> auto& { return s.densify.gradient; });
  form_->addNumber(
      {"splitSize", tr("Split above (voxels²):"),
       tr("Those whose covariance has a larger norm, in voxels squared, are split;\n"
          "the others are cloned.")},
      {0, 1e8}, [](auto& s) -> auto& { return s.densify.split; });
}

void SettingsPanel::addComputation() {
  makeGroup(tr("Computation"));
  form_->addChoice<Selection>(
      {"selection", tr("Candidates:"),
       tr("Where a Gaussian is evaluated: exactly where it contributes, or as the paper's two methods do,\n"
          "to compare times (CPU only).")},
      {{tr("exact"), Selection::Exact},
       {tr("paper's method 1"), Selection::Method1},
       {tr("paper's method 2"), Selection::Method2}},
      [](auto& s) -> auto& { return s.selection; });
  NumberSpin* threads = form_->addNumber(
      {"threads", tr("Threads:"), tr("CPU threads to use; 0: all cores. The result does not depend on it.")},
      {0, 4096}, [](auto& s) -> auto& { return s.threads; });
  threads->setSpecialValueText(tr("all cores"));
  FieldForm::Choices<std::string> sets{{tr("best available"), std::string()}};
  for (const std::string& name : instructionSets())
    sets.emplace_back(QString::fromStdString(name), name);
  form_->addChoice<std::string>(
      {"instructionSet", tr("Instruction set:"),
       tr("Of the CPU's vector units; \"scalar\" is the plain reference.")},
      sets, [](auto& s) -> auto& { return s.instructionSet; });
  form_->addNumber(
      {"seed", tr("Seed:"), tr("The same seed gives the same result, bit for bit.")}, {0, 9007199254740992.0},
      [](auto& s) -> auto& { return s.seed; });
}

void SettingsPanel::refresh() {
  const Settings& s = form_->settings;
  const bool paper = s.preset == Preset::Paper;
  const bool alpha = chosenBlending(s) == Blending::Alpha;
  const auto automatic = [this](const char* name, const QString& what) {
    const QString text = tr("automatic (%1)").arg(what);
    if (auto* combo = findChild<QComboBox*>(name)) {
      combo->setItemText(0, text);
      combo->setMinimumWidth(combo->sizeHint().width()); // Qt keeps the minimum of the old text
    }
    if (auto* spin = findChild<NumberSpin*>(name)) {
      spin->setSpecialValueText(text);
      spin->updateGeometry();
    }
  };
  automatic("blending", paper ? tr("alpha") : tr("normalised"));
  automatic("initialisation", paper ? tr("even grid") : tr("adaptive"));
  automatic("loss", paper ? tr("L1") : tr("L2"));
  automatic("pointWeight", locale().toString(paper ? 0.8 : 1.0));
  automatic("ssimWeight", locale().toString(paper ? 0.4 : 0.0));
  automatic("schedule", paper ? tr("plateau") : tr("exponential"));
  automatic("densifyEvery", paper || s.maxGaussians ? locale().toString(10) : tr("never"));
  automatic("pruneOpacity", locale().toString(alpha ? 0.3 : 0.01));

  const auto enable = [this](std::initializer_list<const char*> names, bool on) {
    for (const char* name : names) {
      auto* field = findChild<QWidget*>(name);
      field->setEnabled(on);
      auto* form = static_cast<QFormLayout*>(field->parentWidget()->layout());
      if (QWidget* label = form->labelForField(field)) label->setEnabled(on);
    }
  };
  enable({"huberDelta"}, s.loss == LossKind::Huber);
  enable({"plateauPatience", "plateauFactor", "plateauLowest", "plateauThreshold"},
         s.schedule.value_or(paper ? Schedule::Plateau : Schedule::Exponential) == Schedule::Plateau);
  enable({"pruneOpacity", "pruneSize", "densifyGradient", "splitSize"},
         s.densifyEvery.value_or(paper || s.maxGaussians ? 10 : 0) > 0);
}

} // namespace innergs::ui
