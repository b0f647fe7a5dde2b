#include "Widgets/App/MainWindow.h"

#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/DataList.h"
#include "Widgets/LogPanel.h"
#include "Widgets/ModelPanel.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ReconstructionPanel.h"

#include <QAction>
#include <QActionGroup>
#include <QDockWidget>
#include <QLabel>
#include <QMenuBar>
#include <QMessageBox>
#include <QProgressBar>
#include <QScreen>
#include <QScrollArea>
#include <QSettings>
#include <QStatusBar>
#include <QStyle>
#include <QVBoxLayout>

#include <utility>

namespace innergs::app {
namespace {

const QString kGeometry = QStringLiteral("window/geometry"), kState = QStringLiteral("window/state"),
              kLayout = QStringLiteral("window/layout");

/// As wide as its content: scrolls vertically only.
class PanelArea : public QScrollArea {
public:
  using QScrollArea::QScrollArea;
  QSize minimumSizeHint() const override {
    const int bar = style()->pixelMetric(QStyle::PM_ScrollBarExtent) + 2 * frameWidth();
    return {widget() ? widget()->minimumSizeHint().width() + bar : bar, 8 * fontMetrics().height()};
  }
};

} // namespace

MainWindow::MainWindow(QWidget* parent)
    : QMainWindow(parent), host_(new AppHost(this)), state_(new ViewState(&host_->document(), this)),
      views_(new ViewGrid(state_, this)) {
  setObjectName(QStringLiteral("mainWindow"));
  setWindowTitle(QStringLiteral("InnerGS"));
  setAcceptDrops(true);
  setDockNestingEnabled(true);
  setCentralWidget(views_);
  pointed_ = new QLabel(this);
  pointed_->setObjectName(QStringLiteral("pointed"));
  pointed_->setToolTip(tr(
      "Position (mm; R, L, A, P, S, I: the patient's sides) and value (scanner units) under the mouse, or\n"
      "at the crosshair while a slice view has the keyboard"));
  busyText_ = new QLabel(this);
  busyText_->setObjectName(QStringLiteral("busyText"));
  busy_ = new QProgressBar(this);
  busy_->setObjectName(QStringLiteral("busy"));
  busy_->setRange(0, 0);
  busy_->setToolTip(tr("A file is being read or written"));
  busy_->setMaximumWidth(12 * fontMetrics().averageCharWidth());
  statusBar()->addWidget(pointed_, 1);
  statusBar()->addPermanentWidget(busyText_);
  statusBar()->addPermanentWidget(busy_);
  busyText_->hide();
  busy_->hide();

  panels_ = new QMenu(tr("Show &Panels"), this);
  makeDocks();
  makeFileMenu();
  makeViewMenu();
  makeHelpMenu();

  connect(views_, &ViewGrid::pointed, pointed_, &QLabel::setText);
  connect(&host_->background(), &Background::busyChanged, this, [this](const QString& text) {
    busyText_->setText(text);
    busyText_->setVisible(!text.isEmpty());
    busy_->setVisible(!text.isEmpty());
    if (!text.isEmpty()) return;
    if (!std::exchange(closeWhenIdle_, false)) return tellErrors();
    delete busyBox_;
    QMetaObject::invokeMethod(
        this,
        [this] {
          if (!close()) tellErrors();
        },
        Qt::QueuedConnection);
  });
  connect(host_, &AppHost::opened, this, [this](const QString& id, const QString& path) {
    if (!path.isEmpty()) {
      addRecentFile(path);
      fillRecent();
    }
    if (host_->document().volume(id)) {
      state_->setVolumeId(id);
      reconstruction_->suggestInput(id);
    }
    list_->setCurrentId(id);
  });
  connect(host_, &AppHost::openFailed, this,
          [this](const QString&, const QString& sentence) { errors_ << sentence; });
  connect(host_, &AppHost::openFailed, list_, &DataList::frameFailed);
  connect(host_, &AppHost::logged, this, [this](const QString& line) {
    constexpr int shown = 8000; // ms
    statusBar()->showMessage(line, shown);
  });
  connect(host_, &AppHost::finished, this, &MainWindow::showFinished);
  connect(host_, &AppHost::failed, this, &MainWindow::reconstructionEnded);
  connect(host_, &AppHost::cancelled, this, &MainWindow::reconstructionEnded);
  connect(&host_->document(), &Document::volumesChanged, this, &MainWindow::updateActions);
  connect(&host_->document(), &Document::modelsChanged, this, &MainWindow::updateActions);
  connect(state_, &ViewState::volumeChanged, this, &MainWindow::updateActions);
  connect(state_, &ViewState::volumeChanged, this, [this] {
    if (const auto item = state_->volume(); item && item->role == VolumeRole::Scan)
      reconstruction_->suggestInput(item->id);
  });
  connect(model_, &ui::ModelPanel::modelIdChanged, this, &MainWindow::setModel);
  connect(query_, &ui::QueryPanel::modelIdChanged, this, &MainWindow::setModel);
  connect(views_->threeD(), &ThreeDView::failed, this, [this](const QString& id, const QString& sentence) {
    host_->showEllipsoids(id, false);
    Q_EMIT host_->logged(sentence);
    tell(sentence);
  });
  connect(query_, &ui::QueryPanel::pictureChanged, views_->threeD(), &ThreeDView::setQueryPicture);
  connect(query_, &ui::QueryPanel::windowChanged, views_->threeD(), &ThreeDView::setQueryWindow);
  connect(list_, &DataList::saveRequested, this, &MainWindow::saveAs);
  connect(list_, &DataList::frameChosen, host_, &AppHost::showFrame);
  connect(list_, &DataList::closeRequested, this, &MainWindow::closeItem);
  connect(list_, &DataList::currentIdChanged, this, [this](const QString& id) {
    if (!host_->document().model(id)) return;
    setModel(id);
  });
  updateActions();
  restoreLayout();
}

MainWindow::~MainWindow() {
  // Views and panels use the host's data.
  disconnect(host_, nullptr, this, nullptr);
  disconnect(&host_->document(), nullptr, this, nullptr);
  disconnect(state_, nullptr, this, nullptr);
  for (QDockWidget* dock : findChildren<QDockWidget*>())
    delete dock;
  delete takeCentralWidget();
  delete state_;
  delete host_;
}

QDockWidget* MainWindow::addDock(QWidget* content, const char* name, const QString& title, bool scrolled) {
  auto* dock = new QDockWidget(title, this);
  dock->setObjectName(QString::fromLatin1(name));
  if (scrolled) {
    if (QLayout* inner = content->layout(); inner && inner->contentsMargins().left() == 0) {
      const int gap = fontMetrics().averageCharWidth();
      inner->setContentsMargins(gap, gap, gap, gap);
    }
    auto* area = new PanelArea(dock);
    area->setWidgetResizable(true);
    area->setFrameShape(QFrame::NoFrame);
    area->setFocusPolicy(Qt::NoFocus); // it follows the keyboard
    area->setHorizontalScrollBarPolicy(Qt::ScrollBarAlwaysOff);
    area->setWidget(content);
    dock->setWidget(area);
  } else {
    dock->setWidget(content);
  }
  panels_->addAction(dock->toggleViewAction());
  return dock;
}

void MainWindow::makeDocks() {
  list_ = new DataList(state_, this);
  reconstruction_ = new ui::ReconstructionPanel(host_, this);
  query_ = new ui::QueryPanel(host_, this);
  model_ = new ui::ModelPanel(host_, this);
  auto* modelTop = new QWidget(this); // keeps its lines at the top
  auto* modelLayout = new QVBoxLayout(modelTop);
  modelLayout->setContentsMargins(0, 0, 0, 0);
  modelLayout->addWidget(model_);
  modelLayout->addStretch(1);
  QDockWidget* data = addDock(list_, "dataDock", tr("Data"), false);
  QDockWidget* panels[] = {addDock(reconstruction_, "reconstructDock", tr("Reconstruct"), true),
                           addDock(query_, "queryDock", tr("Slice query"), true),
                           addDock(modelTop, "modelDock", tr("Model"), true),
                           addDock(new ui::LogPanel(host_, this), "logDock", tr("Log"), false)};
  setTabPosition(Qt::AllDockWidgetAreas, QTabWidget::North);
  addDockWidget(Qt::LeftDockWidgetArea, data);
  for (QDockWidget* dock : panels) {
    addDockWidget(Qt::LeftDockWidgetArea, dock);
    if (dock != panels[0]) tabifyDockWidget(panels[0], dock);
  }
  panels[0]->raise();
  const int line = fontMetrics().height();
  resizeDocks({data, panels[0]}, {8 * line, 45 * line}, Qt::Vertical);
  resizeDocks({panels[0]}, {62 * fontMetrics().averageCharWidth()}, Qt::Horizontal);
}

void MainWindow::restoreLayout() {
  const auto settings = appSettings();
  if (!restoreGeometry(settings->value(kGeometry).toByteArray())) {
    const int h = fontMetrics().height();
    resize(QSize(92 * h, 58 * h).boundedTo(0.92 * screen()->availableSize())); // with the button to start
  }
  restoreState(settings->value(kState).toByteArray());
  const int layout = settings->value(kLayout, 0).toInt();
  if (layout > 0 && layout <= static_cast<int>(ViewGrid::Layout::ThreeD))
    views_->setLayoutShown(static_cast<ViewGrid::Layout>(layout));
}

void MainWindow::updateActions() {
  const bool volume = state_->volume() != nullptr;
  const auto& models = host_->document().models();
  if (!host_->document().model(modelId_)) modelId_ = models.empty() ? QString() : models.back()->id;
  const auto model = host_->document().model(modelId_);
  for (QAction* action : needVolume_)
    action->setEnabled(volume);
  saveVolume_->setEnabled(volume);
  saveModel_->setEnabled(model != nullptr);
  ellipsoids_->setEnabled(model != nullptr);
  ellipsoids_->setChecked(model && model->ellipsoidsShown);
  const auto shown = state_->volume();
  setWindowModified(host_->document().hasUnsaved());
  setWindowTitle(shown ? QStringLiteral("%1[*] — InnerGS").arg(shown->name) : QStringLiteral("InnerGS[*]"));
}

void MainWindow::reconstruct(bool all) {
  ui::Request request = reconstruction_->request();
  if (all) {
    request.inputs.clear();
    for (const auto& item : host_->document().volumes())
      request.inputs.push_back({item->id});
    reconstruction_->setRequest(request);
  }
  showPanel(QStringLiteral("reconstructDock"));
  reconstruction_->startOrCancel();
}

void MainWindow::showPanel(const QString& name) {
  if (auto* dock = findChild<QDockWidget*>(name)) {
    dock->show();
    dock->raise();
  }
}

void MainWindow::goToPanel(const QString& name) {
  showPanel(name);
  auto* dock = findChild<QDockWidget*>(name);
  QWidget* content = dock ? dock->widget() : nullptr;
  if (auto* area = qobject_cast<QScrollArea*>(content)) content = area->widget();
  if (!content) return;
  for (QWidget* next = content->nextInFocusChain(); next != content; next = next->nextInFocusChain())
    if (content->isAncestorOf(next) && next->isVisible() && next->isEnabled() && !next->focusProxy() &&
        (next->focusPolicy() & Qt::TabFocus)) {
      next->setFocus(Qt::ShortcutFocusReason);
      return;
    }
}

bool MainWindow::focusNextPrevChild(bool next) {
  const QWidget* first = focusWidget();
  while (QMainWindow::focusNextPrevChild(next)) {
    QWidget* now = focusWidget();
    const QDockWidget* dock = nullptr;
    for (QWidget* above = now; above && !dock; above = above->parentWidget()) {
      if (auto* area = dynamic_cast<PanelArea*>(above)) area->ensureWidgetVisible(now);
      dock = qobject_cast<QDockWidget*>(above);
    }
    // Qt counts docks behind tabs as visible: no place for the keyboard.
    if (!dock || !dock->visibleRegion().isEmpty() || now == first) return true;
  }
  return false;
}

void MainWindow::setModel(const QString& id) {
  if (id == modelId_) return updateActions();
  modelId_ = id; // first: the panels signal the change
  query_->setModelId(id);
  model_->setModelId(id);
  updateActions();
}

void MainWindow::showFinished(const ui::Report& report) {
  state_->setVolumeId(report.volumeId);
  views_->threeD()->frame();
  list_->setCurrentId(report.volumeId);
  setModel(report.modelId);
  reconstructionEnded();
}

} // namespace innergs::app
