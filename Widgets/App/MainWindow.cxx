#include "Widgets/App/MainWindow.h"

#include "Widgets/App/AppMotionHost.h"
#include "Widgets/App/AppSettings.h"
#include "Widgets/App/Background.h"
#include "Widgets/App/DataList.h"
#include "Widgets/App/FileDialogs.h"
#include "Widgets/App/SegmentItems.h"
#include "Widgets/FindPanel.h"
#include "Widgets/LogPanel.h"
#include "Widgets/ModelPanel.h"
#include "Widgets/MotionPanel.h"
#include "Widgets/PanelTools.h"
#include "Widgets/QueryPanel.h"
#include "Widgets/ReconstructionPanel.h"

#include <QAction>
#include <QActionGroup>
#include <QCloseEvent>
#include <QDockWidget>
#include <QDropEvent>
#include <QFileInfo>
#include <QLabel>
#include <QMenuBar>
#include <QMessageBox>
#include <QMimeData>
#include <QProgressBar>
#include <QPushButton>
#include <QScreen>
#include <QScrollArea>
#include <QSettings>
#include <QStatusBar>
#include <QStyle>
#include <QUrl>
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

QKeySequence ctrl(const char* key) {
  return QKeySequence(QStringLiteral("Ctrl+") + QString::fromLatin1(key));
}

/// Qt says that docks behind tabs are visible.
bool isInFront(const QDockWidget* dock) {
  return dock->isVisible() && !dock->visibleRegion().isEmpty();
}

QStringList pathsOf(const QMimeData* data) {
  QStringList paths;
  for (const QUrl& url : data->urls())
    if (url.isLocalFile()) paths << url.toLocalFile();
  return paths;
}

} // namespace

MainWindow::MainWindow(QWidget* parent)
    : QMainWindow(parent), host_(new AppHost(this)), state_(new ViewState(&host_->document(), this)),
      files_(new FileDialogs(host_, this)), views_(new ViewGrid(state_, this)) {
  setObjectName(QStringLiteral("mainWindow"));
  setWindowTitle(QStringLiteral("InnerGS"));
  setAcceptDrops(true);
  setDockNestingEnabled(true);
  setCentralWidget(views_);
  pointed_ = ui::named(new QLabel(this), "pointed",
                       tr("Position (mm; R, L, A, P, S, I: the patient's sides) and value (scanner units) "
                          "under the mouse, or\n"
                          "at the crosshair while a slice view has the keyboard focus."));
  busyText_ = ui::named(new QLabel(this), "busyText");
  busy_ = ui::named(new QProgressBar(this), "busy", tr("A file is being read or written."));
  busy_->setRange(0, 0);
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
    if (!path.isEmpty()) remember(path);
    if (host_->document().volume(id)) {
      state_->setVolumeId(id);
      reconstruction_->suggestInput(id);
    }
    const auto volume = host_->document().volume(id);
    const auto model = host_->document().model(id);
    if (volume && volume->frames.count > 1) {
      motion_->setSeriesId(id);
      showPanel(QStringLiteral("motionDock"));
    } else if (model && model->dynamic) {
      motion_->setModelId(id);
      showPanel(QStringLiteral("motionDock"));
      host_->motion()->setTime(id, model->time);
    }
    list_->setCurrentId(id);
    if (volume && !volume->unplaced.isEmpty()) files_->askCalibration(id);
  });
  connect(host_, &AppHost::openFailed, this,
          [this](const QString&, const QString& sentence) { errors_ << sentence; });
  connect(host_, &AppHost::openFailed, list_, &DataList::frameFailed);
  connect(host_, &AppHost::logged, this, [this](const QString& line) {
    constexpr int shown = 8000; // ms
    statusBar()->showMessage(line, shown);
  });
  connect(files_, &FileDialogs::saved, this, &MainWindow::remember);
  connect(host_, &AppHost::finished, this, &MainWindow::showFinished);
  connect(host_, &AppHost::failed, this, [this] { closeWhenEnded_ = false; }); // its sentence is to be read
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
  connect(find_, &ui::FindPanel::modelIdChanged, this, &MainWindow::setModel);
  connect(host_, &AppHost::segmentsPreviewed, state_, &ViewState::setOverlay);
  connect(views_->threeD(), &ThreeDView::failed, this, [this](const QString& id, const QString& sentence) {
    host_->showEllipsoids(id, false);
    Q_EMIT host_->logged(sentence);
    files_->tell(sentence);
  });
  connect(query_, &ui::QueryPanel::pictureChanged, views_->threeD(), &ThreeDView::setQueryPicture);
  connect(query_, &ui::QueryPanel::windowChanged, views_->threeD(), &ThreeDView::setQueryWindow);
  connect(list_, &DataList::saveRequested, files_, &FileDialogs::saveAs);
  connect(list_, &DataList::frameChosen, host_, &AppHost::showFrame);
  connect(list_, &DataList::closeRequested, files_, &FileDialogs::closeItem);
  connect(list_, &DataList::currentIdChanged, this, [this](const QString& id) {
    if (host_->document().model(id)) setModel(id);
  });
  connect(motion_, &ui::MotionPanel::modelIdChanged, this, &MainWindow::setModel);
  AppMotionHost& motionHost = host_->motionHost();
  connect(&motionHost, &AppMotionHost::frameShown, state_, &ViewState::setVolumeId);
  connect(&motionHost, &AppMotionHost::finished, this, [this](const ui::MotionReport& report) {
    list_->setCurrentId(report.modelId);
    reconstructionEnded();
  });
  connect(&motionHost, &AppMotionHost::failed, this, [this] { closeWhenEnded_ = false; });
  connect(&motionHost, &AppMotionHost::cancelled, this, &MainWindow::reconstructionEnded);
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
  auto* dock = ui::named(new QDockWidget(title, this), name);
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
  find_ = new ui::FindPanel(host_, this);
  model_ = new ui::ModelPanel(host_, this);
  motion_ = new ui::MotionPanel(host_, this);
  auto* modelTop = new QWidget(this); // keeps its lines at the top
  auto* modelLayout = ui::layoutWithoutMargins<QVBoxLayout>(modelTop);
  modelLayout->addWidget(model_);
  modelLayout->addStretch(1);
  QDockWidget* data = addDock(list_, "dataDock", tr("Data"), false);
  QDockWidget* panels[] = {addDock(reconstruction_, "reconstructDock", tr("Reconstruct"), true),
                           addDock(motion_, "motionDock", tr("Dynamic"), true),
                           addDock(query_, "queryDock", tr("Query"), true),
                           addDock(find_, "findDock", tr("Find"), true),
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

QAction* MainWindow::add(QMenu* menu, const char* name, const QString& text, const QString& tip,
                         const QKeySequence& keys, const std::function<void()>& call) {
  auto* action = ui::named(new QAction(text, this), name, tip);
  action->setStatusTip(tip);
  action->setShortcut(keys);
  if (call) connect(action, &QAction::triggered, this, [call] { call(); });
  menu->addAction(action);
  return action;
}

void MainWindow::makeFileMenu() {
  QMenu* menu = menuBar()->addMenu(tr("&File"));
  menu->setObjectName(QStringLiteral("fileMenu"));
  add(menu, "openFiles", tr("&Open Volume or Model…"),
      tr("NIfTI, NRRD, MetaImage, MINC; InnerGS models, PLY"), QKeySequence::Open,
      [this] { files_->openFiles(); });
  add(menu, "openFolder", tr("Open &DICOM or Frames Folder…"),
      tr("A folder with the files of one DICOM series, or with one image per frame and times.txt"), ctrl("D"),
      [this] { files_->openFolder(); });
  recent_ = menu->addMenu(tr("Open &Recent"));
  recent_->setObjectName(QStringLiteral("recentMenu"));
  fillRecent();
  add(menu, "openSample", tr("Open Sample &Brain"),
      tr("A scan with 5 mm slices made from a T1 head (Colin 27), and the head to compare with"), {},
      [this] { files_->openSample(); });
  menu->addSeparator();
  saveVolume_ = add(menu, "saveVolume", tr("&Save Volume As…"), tr("The volume that the views show"),
                    QKeySequence::Save, [this] { files_->saveAs(state_->volumeId()); });
  saveModel_ = add(menu, "saveModel", tr("Save &Model As…"), tr("The model selected or made last"),
                   ctrl("Shift+S"), [this] { files_->saveAs(modelId_); });
  menu->addSeparator();
  add(menu, "quit", tr("&Quit"), tr("Asks before unsaved items are lost"), ctrl("Q"), [this] { close(); });
}

void MainWindow::remember(const QString& file) {
  addRecentFile(file);
  fillRecent();
}

void MainWindow::fillRecent() {
  recent_->clear();
  const QStringList files = recentFiles();
  for (int n = 0; n < files.size(); ++n) {
    const QString& file = files[n];
    QAction* action = recent_->addAction(QStringLiteral("&%1 %2").arg(n + 1).arg(
        QFileInfo(file).fileName().replace(QLatin1Char('&'), QLatin1String("&&"))));
    action->setToolTip(file);
    action->setStatusTip(file);
    connect(action, &QAction::triggered, this, [this, file] { host_->open({file}); });
  }
  recent_->setEnabled(!files.isEmpty());
  if (files.isEmpty()) return;
  recent_->addSeparator();
  connect(recent_->addAction(tr("&Clear")), &QAction::triggered, this, [this] {
    clearRecentFiles();
    fillRecent();
  });
}

void MainWindow::makeViewMenu() {
  QMenu* menu = menuBar()->addMenu(tr("&View"));
  menu->setObjectName(QStringLiteral("viewMenu"));
  layouts_ = new QActionGroup(this);
  using Layout = ViewGrid::Layout;
  const std::pair<Layout, QString> layouts[] = {{Layout::All, tr("&All Views")},
                                                {Layout::Axial, tr("A&xial")},
                                                {Layout::Coronal, tr("&Coronal")},
                                                {Layout::Sagittal, tr("&Sagittal")},
                                                {Layout::ThreeD, tr("&3D")}};
  int key = 1;
  for (const auto& [layout, text] : layouts) {
    QAction* action = add(menu, "", text, tr("Double-clicking a view does the same"),
                          QKeySequence(QStringLiteral("Ctrl+%1").arg(key++)),
                          [this, layout = layout] { views_->setLayoutShown(layout); });
    action->setObjectName(QStringLiteral("layout%1").arg(static_cast<int>(layout)));
    action->setData(static_cast<int>(layout));
    action->setCheckable(true);
    layouts_->addAction(action);
  }
  const auto check = [this] {
    for (QAction* action : layouts_->actions())
      action->setChecked(action->data().toInt() == static_cast<int>(views_->layoutShown()));
  };
  connect(views_, &ViewGrid::layoutChanged, this, check);
  check();
  menu->addSeparator();
  rendering_ = add(menu, "volumeRendering", tr("3D &Volume Rendering"),
                   tr("Show the whole volume in the 3D view; smooth only on a good graphics card"), ctrl("R"),
                   [this] { views_->threeD()->setVolumeRendered(rendering_->isChecked()); });
  rendering_->setCheckable(true);
  QAction* planes = add(menu, "planes", tr("P&lanes in 3D"), tr("Show the three slices in the 3D view"), {});
  planes->setCheckable(true);
  planes->setChecked(true);
  connect(planes, &QAction::toggled, views_->threeD(), &ThreeDView::setPlanesShown);
  QAction* query = add(menu, "queryPlane", tr("&Query Plane in 3D"),
                       tr("Show the plane of the panel Query in the 3D view while that panel is open"), {});
  query->setCheckable(true);
  query->setChecked(true);
  auto* panel = findChild<QDockWidget*>(QStringLiteral("queryDock"));
  const auto showQuery = [this, query](bool inFront) {
    views_->threeD()->setQueryShown(inFront && query->isChecked());
  };
  connect(query, &QAction::toggled, this, [showQuery, panel] { showQuery(isInFront(panel)); });
  connect(panel, &QDockWidget::visibilityChanged, this, showQuery);
  ellipsoids_ = add(menu, "ellipsoids", tr("&Ellipsoids"),
                    tr("Show the Gaussians of the model selected or made last in the 3D view"), ctrl("E"),
                    [this] { host_->showEllipsoids(modelId_, ellipsoids_->isChecked()); });
  ellipsoids_->setCheckable(true);
  menu->addSeparator();
  needVolume_ = {add(menu, "resetWindow", tr("Reset &Window and Level"),
                     tr("Restore window and level as they were when the volume was opened"), ctrl("W"),
                     [this] { state_->resetWindow(); }),
                 add(menu, "fit", tr("&Fit to Views"), tr("Show the whole volume in every view"), ctrl("0"),
                     [this] { views_->fit(); }),
                 add(menu, "nextVolume", tr("&Next Volume"),
                     tr("Show the next volume at the same place, to compare"), ctrl("PgDown"),
                     [this] { state_->step(1); }),
                 add(menu, "previousVolume", tr("Previo&us Volume"),
                     tr("Show the previous volume at the same place, to compare"), ctrl("PgUp"),
                     [this] { state_->step(-1); })};
  menu->addSeparator();
  QMenu* panels = menu->addMenu(tr("&Go to Panel"));
  const std::pair<const char*, int> docks[] = {{"dataDock", Qt::Key_F4},   {"reconstructDock", Qt::Key_F5},
                                               {"queryDock", Qt::Key_F6},  {"modelDock", Qt::Key_F7},
                                               {"logDock", Qt::Key_F8},    {"findDock", Qt::Key_F9},
                                               {"motionDock", Qt::Key_F12}};
  for (const auto& [dock, panelKey] : docks) {
    const QString name = QString::fromLatin1(dock);
    add(panels, "", findChild<QDockWidget*>(name)->windowTitle(),
        tr("Show this panel and move the keyboard focus to it"), QKeySequence(panelKey),
        [this, name] { goToPanel(name); });
  }
  menu->addMenu(panels_);
}

void MainWindow::makeHelpMenu() {
  QMenu* menu = menuBar()->addMenu(tr("&Help"));
  menu->setObjectName(QStringLiteral("helpMenu"));
  const auto show = [this](const char* name, const QString& title, const QString& text) {
    auto* box = ui::named(new QMessageBox(QMessageBox::NoIcon, title, text, QMessageBox::Close, this), name);
    box->setAttribute(Qt::WA_DeleteOnClose);
    box->setTextInteractionFlags(Qt::TextBrowserInteraction);
    box->open();
  };
  add(menu, "citation", tr("How to &Cite"), tr("The paper behind the method"), {}, [show] {
    show("citationBox", tr("How to cite"),
         tr("S. Liang, Y. Xiao, W. Tang: <i>InnerGS: Internal Scenes Rendering via Factorized 3D Gaussian "
            "Splatting.</i> arXiv:2508.13287, 2025.<br><br>This program is an independent implementation: "
            "name "
            "it as InnerGS %1 beside the paper.")
             .arg(QStringLiteral(INNERGS_VERSION)));
  });
  add(menu, "about", tr("&About InnerGS"), tr("Version and licence"), {}, [show] {
    show(
        "aboutBox", tr("About InnerGS"),
        tr("<h3>InnerGS %1</h3><p>Medical image slices become a continuous volume of 3D Gaussians.</p>"
           "<p><b>Research software. It is not a medical device and must not be used for diagnosis or "
           "treatment; not for clinical use.</b></p><p>Apache License 2.0. Made with Qt %2, VTK and ITK.</p>")
            .arg(QStringLiteral(INNERGS_VERSION), QString::fromLatin1(qVersion())));
  });
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
  find_->setModelId(id);
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

void MainWindow::tellErrors() {
  if (!errors_.isEmpty()) files_->tell(std::exchange(errors_, {}).join(QStringLiteral("\n\n")));
}

void MainWindow::closeEvent(QCloseEvent* event) {
  event->ignore();
  if (closeWhenEnded_) return;
  if (host_->background().isBusy()) {
    if (closeWhenIdle_) return;
    closeWhenIdle_ = true;
    busyBox_ = new QMessageBox(QMessageBox::Information, QStringLiteral("InnerGS"),
                               tr("A file is being read or written. The window closes when that is done."),
                               QMessageBox::NoButton, this);
    busyBox_->setObjectName(QStringLiteral("busyBox"));
    busyBox_->setAttribute(Qt::WA_DeleteOnClose);
    QPushButton* stay = busyBox_->addButton(tr("&Keep Open"), QMessageBox::RejectRole);
    busyBox_->setDefaultButton(stay);
    busyBox_->setEscapeButton(stay);
    connect(busyBox_, &QMessageBox::finished, this, [this] { closeWhenIdle_ = false; });
    busyBox_->open();
    return;
  }
  if (host_->isRunning() || host_->motion()->isRunning()) {
    auto* box = new QMessageBox(
        QMessageBox::Question, QStringLiteral("InnerGS"),
        host_->isRunning()
            ? tr("A reconstruction is running. Stop it and close? Once its iterations have begun, you can "
                 "continue it at the next start.")
            : tr("A dynamic scan is being reconstructed. Stop it and close? Once its frames are refined "
                 "together, you can continue it at the next start."),
        QMessageBox::NoButton, this);
    box->setObjectName(QStringLiteral("runningBox"));
    box->setAttribute(Qt::WA_DeleteOnClose);
    QPushButton* stop = box->addButton(tr("&Stop and Close"), QMessageBox::DestructiveRole);
    QPushButton* stay = box->addButton(tr("&Keep Running"), QMessageBox::RejectRole);
    box->setDefaultButton(stay);
    box->setEscapeButton(stay);
    connect(stop, &QPushButton::clicked, this, [this] {
      closeWhenEnded_ = true;
      host_->stopAndKeep();
      host_->motion()->cancel();
      if (!host_->isRunning() && !host_->motion()->isRunning()) reconstructionEnded();
    });
    box->open();
    return;
  }
  if (!files_->mayDiscard()) return;
  const auto settings = appSettings();
  settings->setValue(kGeometry, saveGeometry());
  settings->setValue(kState, saveState());
  settings->setValue(kLayout, static_cast<int>(views_->layoutShown()));
  event->accept();
}

void MainWindow::reconstructionEnded() {
  if (!closeWhenEnded_) return;
  closeWhenEnded_ = false;
  // A result finished before the stop is asked about like any other.
  QMetaObject::invokeMethod(
      this, [this] { close(); }, Qt::QueuedConnection);
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (!pathsOf(event->mimeData()).isEmpty()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  const QStringList paths = pathsOf(event->mimeData());
  if (paths.isEmpty()) return;
  event->acceptProposedAction();
  host_->open(paths);
}

} // namespace innergs::app
