#include "Widgets/FindPanel.h"

#include "Core/Model/Model.h"
#include "Widgets/MessageLine.h"
#include "Widgets/PanelTools.h"
#include "Widgets/TextFormat.h"
#include "Widgets/ValueSlider.h"
#include "vtkInnerGSModel.h"

#include <QCheckBox>
#include <QComboBox>
#include <QCompleter>
#include <QDir>
#include <QDoubleSpinBox>
#include <QFormLayout>
#include <QGroupBox>
#include <QHBoxLayout>
#include <QLabel>
#include <QLineEdit>
#include <QListWidget>
#include <QLocale>
#include <QProgressBar>
#include <QPushButton>
#include <QSignalBlocker>
#include <QStringListModel>
#include <QTimer>
#include <QVBoxLayout>

#include <utility>

namespace innergs::ui {
namespace {

constexpr int kHistory = 20;  // queries
constexpr int kLongest = 300; // bytes of a query, as the lexicon has it

QDoubleSpinBox* numberBox(const char* name, const QString& suffix, double highest, double step,
                          const QString& toolTip) {
  auto* box = named(new QDoubleSpinBox, name, toolTip);
  box->setRange(0, highest);
  box->setSingleStep(step);
  box->setDecimals(1);
  box->setSuffix(suffix);
  box->setSpecialValueText(FindPanel::tr("none"));
  box->setKeyboardTracking(false);
  return box;
}

} // namespace

FindPanel::FindPanel(Host* host, QWidget* parent)
    : QWidget(parent), host_(host), worker_(new SegmentWorker(this)) {
  auto* all = layoutWithoutMargins<QVBoxLayout>(this);
  selector_ = named(host_->createSelector(Host::Role::Model, this), "findModel", tr("The model to search."));
  auto* choice = new QHBoxLayout;
  auto* label = new QLabel(tr("&Model"));
  label->setBuddy(selector_);
  choice->addWidget(label);
  choice->addWidget(selector_, 1);
  all->addLayout(choice);
  state_ = makeWrappedLabel(QStringLiteral("findState"), this);
  all->addWidget(state_);
  all->addWidget(buildFinding());
  all->addWidget(buildLearning());
  all->addStretch(1);
  guardWheel(this);

  connect(selector_, &Selector::currentIdChanged, this, &FindPanel::updateModel);
  connect(host_, &Host::modelsChanged, this, &FindPanel::updateModel);
  connect(worker_, &SegmentWorker::learningProgressed, this,
          [this](double fraction) { progress_->setValue(static_cast<int>(100 * fraction)); });
  connect(worker_, &SegmentWorker::learned, this, &FindPanel::learned);
  connect(worker_, &SegmentWorker::learningFailed, this, [this](const QString& sentence) {
    endLearning();
    learningMessage_->say(sentence, true);
    Q_EMIT host_->logged(sentence);
  });
  connect(worker_, &SegmentWorker::learningCancelled, this, [this] {
    endLearning();
    learningMessage_->say(tr("Stopped. The model is unchanged."));
  });
  connect(worker_, &SegmentWorker::decoding, this, [this](double fraction) {
    decoding_->setVisible(fraction < 1);
    decoding_->setValue(static_cast<int>(100 * fraction));
  });
  connect(worker_, &SegmentWorker::found, this,
          [this](const std::shared_ptr<const FindResult>& result) { showFound(*result); });
  updateModel();
}

// Its children outlive it, so their signals must no longer reach it.
FindPanel::~FindPanel() {
  for (QObject* part : findChildren<QObject*>())
    part->disconnect(this);
  delete worker_; // its thread calls the host
}

QWidget* FindPanel::buildFinding() {
  finding_ = new QWidget(this);
  auto* all = layoutWithoutMargins<QVBoxLayout>(finding_);
  text_ =
      named(new QComboBox, "findText",
            tr("A structure in words, in English, Latin, German, French or Spanish: 'liver', 'left kidney', "
               "'7th rib on the right', or a segment's own name; earlier queries in the list."));
  text_->setEditable(true);
  text_->setInsertPolicy(QComboBox::NoInsert);
  text_->setSizeAdjustPolicy(QComboBox::AdjustToMinimumContentsLengthWithIcon);
  text_->setMinimumContentsLength(10);
  text_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Fixed);
  text_->lineEdit()->setPlaceholderText(tr("e.g. liver, left kidney"));
  text_->lineEdit()->setClearButtonEnabled(true);
  auto* completer = new QCompleter(new QStringListModel(this), this);
  completer->setCaseSensitivity(Qt::CaseInsensitive);
  completer->setFilterMode(Qt::MatchContains);
  text_->setCompleter(completer);
  find_ = named(new QPushButton(tr("&Find")), "findGo", tr("Show the structure in the views."));
  auto* line = new QHBoxLayout;
  line->addWidget(labelFor(text_, tr("S&tructure")));
  line->addWidget(text_, 1);
  line->addWidget(find_);
  all->addLayout(line);
  decoding_ = named(new QProgressBar, "findDecoding",
                    tr("The model is decoded once; then each structure takes an instant."));
  decoding_->setFormat(tr("Preparing the model: %p %"));
  decoding_->hide();
  all->addWidget(decoding_);
  answer_ = named(new MessageLine, "findAnswer", {});
  all->addWidget(answer_);
  candidates_ = named(new QListWidget, "findCandidates",
                      tr("What fits the words, best first; choose one to see it alone."));
  candidates_->setSelectionMode(QAbstractItemView::SingleSelection);
  candidates_->setFixedHeight(candidates_->fontMetrics().height() * 6);
  all->addWidget(candidates_);

  auto* form = new QFormLayout;
  thresholded_ = named(new QCheckBox(tr("T&hreshold")), "findThresholdOn",
                       tr("Off: each voxel belongs to its likeliest segment. On: voxels with at least this "
                          "probability."));
  threshold_ = new ValueSlider(QString(), 2, this);
  threshold_->setRange(0.02, 1);
  threshold_->setSingleStep(0.05);
  threshold_->setValue(0.5);
  threshold_->setEnabled(false);
  threshold_->describe(QStringLiteral("findThreshold"), tr("Threshold"), thresholded_->toolTip());
  form->addRow(thresholded_, threshold_);
  smoothing_ = numberBox("findSmoothing", tr(" mm"), 20, 0.5,
                         tr("Standard deviation of a Gaussian that smooths the surface."));
  form->addRow(tr("S&moothing"), smoothing_);
  minimum_ = numberBox("findMinimum", tr(" ml"), 10000, 0.5, tr("Smaller connected parts are left out"));
  form->addRow(tr("M&inimum size"), minimum_);
  largest_ = named(new QCheckBox(tr("Largest &part only")), "findLargest",
                   tr("Only the largest connected part of each segment."));
  form->addRow(QString(), largest_);
  all->addLayout(form);
  found_ = makeWrappedLabel(QStringLiteral("findVolume"), this);
  all->addWidget(found_);
  add_ = named(new QPushButton(tr("&Keep as Segment")), "findAdd",
               tr("Make a segmentation or labelmap from what is shown."));
  add_->setEnabled(false);
  auto* buttons = new QHBoxLayout;
  buttons->addStretch(1);
  buttons->addWidget(add_);
  all->addLayout(buttons);

  connect(text_->lineEdit(), &QLineEdit::textEdited, this, [this] { // so that the first answer is quick
    if (std::exchange(prepared_, true) || !model_) return;
    worker_->find({model_->GetSegmented(), {}, -1, {}});
  });
  connect(find_, &QPushButton::clicked, this, [this] { ask(-1); });
  auto* entered = new QTimer(this); // Return on an earlier query emits both signals
  entered->setSingleShot(true);
  connect(entered, &QTimer::timeout, this, [this] { ask(-1); });
  connect(text_->lineEdit(), &QLineEdit::returnPressed, entered, QOverload<>::of(&QTimer::start));
  connect(text_, QOverload<int>::of(&QComboBox::activated), entered, QOverload<>::of(&QTimer::start));
  connect(candidates_, &QListWidget::currentRowChanged, this, [this](int row) {
    if (row >= 0) ask(row);
  });
  connect(thresholded_, &QCheckBox::toggled, threshold_, &QWidget::setEnabled);
  const auto again = [this] {
    if (!asked_.isEmpty()) ask(candidates_->currentRow());
  };
  connect(thresholded_, &QCheckBox::toggled, this, again);
  connect(threshold_, &ValueSlider::valueEdited, this, again);
  connect(largest_, &QCheckBox::toggled, this, again);
  for (QDoubleSpinBox* box : {smoothing_, minimum_})
    connect(box, QOverload<double>::of(&QDoubleSpinBox::valueChanged), this, again);
  connect(add_, &QPushButton::clicked, this, &FindPanel::add);
  return finding_;
}

QWidget* FindPanel::buildLearning() {
  auto* group = new QGroupBox(tr("Learn from labels"), this);
  auto* form = new QFormLayout(group);
  form->setFieldGrowthPolicy(QFormLayout::ExpandingFieldsGrow);
  labels_ = host_->createSelector(Host::Role::Labels, group);
  if (labels_) {
    named(labels_, "findLabels",
          tr("A segmentation or labelmap of the same patient, on any grid, e.g. from TotalSegmentator or "
             "drawn by hand."));
    form->addRow(tr("&Labels"), labels_);
    connect(labels_, &Selector::currentIdChanged, this, &FindPanel::updateLearning);
  }
  if (host_->asksForNames()) {
    names_ =
        named(new QLineEdit, "findNames",
              tr("A file with the labels' names: JSON {\"1\": \"liver\", \"2\": \"spleen\"} or a .seg.nrrd; "
                 "empty: the names in the labels' own file (.seg.nrrd)."));
    names_->setPlaceholderText(tr("from the labels' own file"));
    auto* choose = named(new QPushButton(tr("C&hoose…")), "findChooseNames", names_->toolTip());
    auto* line = new QHBoxLayout;
    line->addWidget(names_, 1);
    line->addWidget(choose);
    form->addRow(labelFor(names_, tr("&Names")), line);
    connect(choose, &QPushButton::clicked, this, &FindPanel::chooseNames);
  }
  sparse_ = named(new QCheckBox(tr("Only &some slices are labelled")), "findSparse",
                  tr("Unlabelled slices between labelled ones follow the scan; else they are background."));
  form->addRow(QString(), sparse_);
  progress_ = named(new QProgressBar, "findProgress", tr("Progress of learning."));
  progress_->hide();
  form->addRow(progress_);
  learningMessage_ = named(new MessageLine, "findLearningMessage", {});
  form->addRow(learningMessage_);
  learn_ = named(new QPushButton(tr("Learn")), "findLearn", {});
  auto* buttons = new QHBoxLayout;
  buttons->addStretch(1);
  buttons->addWidget(learn_);
  form->addRow(buttons);
  connect(learn_, &QPushButton::clicked, this, &FindPanel::learnOrCancel);
  return group;
}

void FindPanel::setModelId(const QString& id) {
  selector_->setCurrentId(id);
  updateModel();
}

/// Unless the user has just chosen none.
void FindPanel::chooseOnlyModel() {
  if (!selector_->currentId().isEmpty()) return;
  if (const QString only = host_->onlyModel(); !only.isEmpty() && only != lastId_)
    selector_->setCurrentId(only);
}

void FindPanel::updateModel() {
  chooseOnlyModel();
  const QString id = selector_->currentId();
  if (!id.isEmpty()) lastId_ = id;
  vtkInnerGSModel* const now = id.isEmpty() ? nullptr : host_->model(id);
  const bool same = id == modelId_ && (now ? model_ && now->HasContentOf(model_) : !model_);
  const auto sameScan = [](const SegmentedModel& a, const SegmentedModel& b) {
    return a.dynamic && a.dynamic == b.dynamic && a.features == b.features;
  };
  const bool moved =
      !same && now && model_ && id == modelId_ && sameScan(now->GetSegmented(), model_->GetSegmented());
  if (moved) { // the same model at another time
    model_->ShallowCopy(now);
    worker_->stopFinding();
    updateLearning();
    if (asking_ || !asked_.isEmpty()) ask(asking_ ? -1 : candidates_->currentRow());
    return;
  }
  if (!same) {
    model_ = nullptr;
    if (now) { // what it holds never changes
      model_ = vtkSmartPointer<vtkInnerGSModel>::New();
      model_->ShallowCopy(now);
    }
    worker_->stopFinding();
    clearFound();
  }
  const int segments = model_ ? model_->GetNumberOfSegments() : 0;
  state_->setText(!model_ ? tr("Choose a model, or reconstruct one first.")
                  : segments == 0
                      ? tr("This model knows no structures yet: let it learn some from labels below.")
                      : tr("This model knows %n structures.", nullptr, segments));
  finding_->setEnabled(segments > 0);
  if (!same) {
    QStringList names;
    for (int n = 0; n < segments; ++n)
      names << QString::fromStdString(model_->GetSegmentName(n));
    static_cast<QStringListModel*>(text_->completer()->model())->setStringList(names);
    prepared_ = segments == 0;
  }
  updateLearning();
  if (id == modelId_) return;
  modelId_ = id;
  learningMessage_->clear();
  Q_EMIT modelIdChanged(id);
}

void FindPanel::updateLearning() {
  learn_->setText(learning_ ? tr("Cancel") : tr("Learn"));
  learn_->setToolTip(learning_ ? tr("Stop and leave the model unchanged.")
                     : model_ && model_->GetSegmented().dynamic
                         ? tr("Learn the labelled structures; takes less than two minutes. The labels must "
                              "belong to the time shown now, %1 s.")
                               .arg(QLocale().toString(model_->GetSegmented().time))
                         : tr("Learn the labelled structures; takes less than two minutes."));
  learn_->setEnabled(learning_ || (model_ && labels_ && !labels_->currentId().isEmpty()));
  for (QWidget* part : QWidgetList{labels_, names_, sparse_})
    if (part) part->setEnabled(!learning_);
}

void FindPanel::chooseNames() {
  askForFile(this, host_, "findNamesDialog", tr("Names of the labels"),
             tr("Names (*.json *.seg.nrrd);;All files (*)"),
             [this](const QString& file) { names_->setText(QDir::toNativeSeparators(file)); });
}

void FindPanel::learnOrCancel() {
  if (learning_) {
    learn_->setEnabled(false); // until it has stopped
    worker_->cancelLearning();
    return;
  }
  if (!model_) return;
  QString problem;
  LearningTask task;
  task.model = model_->GetSegmented();
  task.sparse = sparse_->isChecked();
  task.labels =
      host_->labelsFor(modelId_, labels_->currentId(),
                       names_ ? QDir::fromNativeSeparators(names_->text().trimmed()) : QString(), &problem);
  if (!task.labels) {
    learningMessage_->say(problem, true);
    return;
  }
  learning_ = true;
  learningId_ = modelId_;
  learningMessage_->clear();
  progress_->setValue(0);
  progress_->show();
  updateLearning();
  worker_->learn(std::move(task));
}

void FindPanel::endLearning() {
  learning_ = false;
  progress_->hide();
  updateLearning();
}

void FindPanel::learned(const std::shared_ptr<const FeatureModel>& features) {
  endLearning();
  vtkInnerGSModel* const now = host_->model(learningId_);
  QString problem;
  if (!now ||
      static_cast<std::size_t>(now->GetNumberOfGaussians()) * features->channels != features->latents.size())
    problem = tr("The model was closed or replaced while learning: learn the structures again.");
  else
    problem = host_->setFeatures(learningId_, features);
  if (!problem.isEmpty()) {
    learningMessage_->say(problem, true);
    return;
  }
  learningMessage_->say(
      tr("Learned %n structures. Save the model to keep them.", nullptr, features->classes() - 1));
  updateModel();
}

void FindPanel::find(const QString& text) {
  text_->setEditText(text);
  ask(-1);
}

void FindPanel::ask(int candidate) {
  if (!model_ || model_->GetNumberOfSegments() == 0) return;
  const QString text = candidate >= 0 ? asked_ : text_->currentText().trimmed();
  const bool tooLong = text.toUtf8().size() > kLongest;
  if (text.isEmpty() || tooLong) {
    clearFound();
    answer_->setMessage(MessageLine::Kind::Warning,
                        tooLong ? tr("That is too long: name one structure, e.g. 'liver' or 'left kidney'.")
                                : tr("Type a structure, e.g. 'liver' or 'left kidney'."));
    return;
  }
  FindTask task{model_->GetSegmented(), text.toStdString(), candidate, {}};
  if (thresholded_->isChecked()) task.options.threshold = threshold_->value();
  task.options.smoothing = smoothing_->value();
  task.options.minimumSize = 1000 * minimum_->value(); // ml to mm³
  task.options.largestOnly = largest_->isChecked();
  asking_ = true;
  worker_->find(std::move(task));
}

void FindPanel::showFound(const FindResult& result) {
  decoding_->hide();
  if (!model_ || result.task.model != model_->GetSegmented()) return; // of an earlier model
  if (!result.error.isEmpty()) {
    clearFound();
    answer_->say(result.error, true);
    return;
  }
  if (result.task.query.empty()) return; // only decoded
  asking_ = false;
  const QString text = QString::fromStdString(result.task.query);
  const bool listed = text == asked_ && result.task.candidate >= 0;
  asked_ = text;
  made_ = result.made;
  if (!listed) {
    const QSignalBlocker blocker(candidates_);
    candidates_->clear();
    for (int n = 0; n < result.names.size(); ++n) {
      const SegmentCandidate& candidate = result.answer.candidates[static_cast<std::size_t>(n)];
      const QString score = QLocale().toString(100 * candidate.score, 'f', 0);
      auto* item =
          new QListWidgetItem(candidate.wider ? tr("%1 — %2 %, holds more").arg(result.names[n], score)
                                              : tr("%1 — %2 %").arg(result.names[n], score),
                              candidates_);
      QFont font = item->font();
      font.setBold(static_cast<std::size_t>(n) < result.answer.leading);
      item->setFont(font);
    }
    const QSignalBlocker textBlocker(text_);
    text_->removeItem(text_->findText(text, Qt::MatchFixedString));
    if (!made_.segments.empty()) text_->insertItem(0, text);
    while (text_->count() > kHistory)
      text_->removeItem(text_->count() - 1);
    text_->setEditText(text);
  }
  const AnswerKind kind = result.answer.kind;
  answer_->setMessage(kind == AnswerKind::Found ? MessageLine::Kind::Information : MessageLine::Kind::Warning,
                      QString::fromStdString(result.answer.sentence));
  answer_->setToolTip(QString::fromStdString(result.answer.note)); // why only names could be looked up
  QStringList lines;
  const Vec3& mm = made_.grid.spacing;
  bool empty = true;
  for (const auto& [terms, segment] : made_.segments) {
    const double ml = static_cast<double>(segment.voxels) * mm[0] * mm[1] * mm[2] / 1000;
    lines << tr("%1: %2 ml").arg(QString::fromStdString(terms.name), QLocale().toString(ml, 'f', 1));
    empty = empty && segment.voxels == 0;
  }
  if (!lines.isEmpty() && empty) lines << tr("Nothing is left: lower the threshold or the minimum size.");
  found_->setText(lines.join(QLatin1Char('\n')));
  add_->setEnabled(!empty);
  host_->previewSegments(modelId_, made_);
}

void FindPanel::clearFound() {
  asking_ = false;
  asked_.clear();
  made_ = {};
  {
    const QSignalBlocker blocker(candidates_);
    candidates_->clear();
  }
  answer_->clear();
  found_->clear();
  add_->setEnabled(false);
  host_->previewSegments(modelId_, {});
}

void FindPanel::add() {
  QString error;
  const QString name = host_->addSegments(modelId_, made_, &error);
  if (name.isEmpty())
    answer_->say(error, true);
  else
    answer_->say(tr("Kept in '%1'.").arg(name));
}

} // namespace innergs::ui
