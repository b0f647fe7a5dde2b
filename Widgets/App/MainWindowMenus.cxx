#include "Widgets/App/MainWindow.h"

#include "Widgets/App/AppSettings.h"

#include <QAction>
#include <QActionGroup>
#include <QDockWidget>
#include <QFileInfo>
#include <QMenuBar>
#include <QMessageBox>

#include <utility>

namespace innergs::app {
namespace {

QKeySequence ctrl(const char* key) {
  return QKeySequence(QStringLiteral("Ctrl+") + QString::fromLatin1(key));
}

/// Qt says that docks behind tabs are visible.
bool isInFront(const QDockWidget* dock) {
  return dock->isVisible() && !dock->visibleRegion().isEmpty();
}

} // namespace

QAction* MainWindow::add(QMenu* menu, const char* name, const QString& text, const QString& tip,
                         const std::function<void()>& call, const QKeySequence& keys) {
  auto* action = new QAction(text, this);
  action->setObjectName(QString::fromLatin1(name));
  action->setToolTip(tip);
  action->setStatusTip(tip);
  action->setShortcut(keys);
  connect(action, &QAction::triggered, this, [call] { call(); });
  menu->addAction(action);
  return action;
}

void MainWindow::makeFileMenu() {
  QMenu* menu = menuBar()->addMenu(tr("&File"));
  menu->setObjectName(QStringLiteral("fileMenu"));
  add(
      menu, "openFiles", tr("&Open Volume or Model…"),
      tr("NIfTI, NRRD, MetaImage, MINC; InnerGS models, PLY"), [this] { openFiles(); }, QKeySequence::Open);
  add(
      menu, "openFolder", tr("Open &DICOM Folder…"), tr("A folder with the files of one DICOM series"),
      [this] { openFolder(); }, ctrl("D"));
  recent_ = menu->addMenu(tr("Open &Recent"));
  recent_->setObjectName(QStringLiteral("recentMenu"));
  fillRecent();
  add(menu, "openSample", tr("Open Sample &Brain"),
      tr("A scan with 5 mm slices made from a T1 head (Colin 27), and the head to compare with"),
      [this] { openSample(); });
  menu->addSeparator();
  saveVolume_ = add(
      menu, "saveVolume", tr("&Save Volume As…"), tr("The volume that the views show"),
      [this] { saveAs(state_->volumeId()); }, QKeySequence::Save);
  saveModel_ = add(
      menu, "saveModel", tr("Save &Model As…"), tr("The model selected or made last"),
      [this] { saveAs(modelId_); }, ctrl("Shift+S"));
  menu->addSeparator();
  add(
      menu, "quit", tr("&Quit"), tr("Asks before unsaved items are lost"), [this] { close(); }, ctrl("Q"));
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
    connect(action, &QAction::triggered, this, [this, file] { open({file}); });
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
    QAction* action = add(
        menu, "", text, tr("Double click into a view does the same"),
        [this, layout = layout] { views_->setLayoutShown(layout); },
        QKeySequence(QStringLiteral("Ctrl+%1").arg(key++)));
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
  rendering_ = add(
      menu, "volumeRendering", tr("3D &Volume Rendering"),
      tr("Show the whole volume in the 3D view; smooth only on a good graphics card"),
      [this] { views_->threeD()->setVolumeRendered(rendering_->isChecked()); }, ctrl("R"));
  rendering_->setCheckable(true);
  QAction* planes =
      add(menu, "planes", tr("P&lanes in 3D"), tr("Show the three slices in the 3D view"), [] {});
  planes->setCheckable(true);
  planes->setChecked(true);
  connect(planes, &QAction::toggled, views_->threeD(), &ThreeDView::setPlanesShown);
  QAction* query =
      add(menu, "queryPlane", tr("&Query Plane in 3D"),
          tr("Show the plane of the panel Slice query in the 3D view while that panel is open"), [] {});
  query->setCheckable(true);
  query->setChecked(true);
  auto* panel = findChild<QDockWidget*>(QStringLiteral("queryDock"));
  const auto showQuery = [this, query](bool inFront) {
    views_->threeD()->setQueryShown(inFront && query->isChecked());
  };
  connect(query, &QAction::toggled, this, [showQuery, panel] { showQuery(isInFront(panel)); });
  connect(panel, &QDockWidget::visibilityChanged, this, showQuery);
  ellipsoids_ = add(
      menu, "ellipsoids", tr("&Ellipsoids"),
      tr("Show the Gaussians of the model selected or made last in the 3D view"),
      [this] { host_->showEllipsoids(modelId_, ellipsoids_->isChecked()); }, ctrl("E"));
  ellipsoids_->setCheckable(true);
  menu->addSeparator();
  needVolume_ << add(
                     menu, "resetWindow", tr("Reset &Window and Level"),
                     tr("Restore window and level as they were when the volume was opened"),
                     [this] { state_->resetWindow(); }, ctrl("W"))
              << add(
                     menu, "fit", tr("&Fit to Views"), tr("Show the whole volume in every view"),
                     [this] { views_->fit(); }, ctrl("0"))
              << add(
                     menu, "nextVolume", tr("&Next Volume"),
                     tr("Show the next volume at the same place, to compare"), [this] { state_->step(1); },
                     ctrl("PgDown"))
              << add(
                     menu, "previousVolume", tr("Previo&us Volume"),
                     tr("Show the previous volume at the same place, to compare"),
                     [this] { state_->step(-1); }, ctrl("PgUp"));
  menu->addSeparator();
  QMenu* panels = menu->addMenu(tr("&Go to Panel"));
  const std::pair<const char*, int> docks[] = {{"dataDock", Qt::Key_F4},
                                               {"reconstructDock", Qt::Key_F5},
                                               {"queryDock", Qt::Key_F6},
                                               {"modelDock", Qt::Key_F7},
                                               {"logDock", Qt::Key_F8}};
  for (const auto& [dock, panelKey] : docks) {
    const QString name = QString::fromLatin1(dock);
    add(
        panels, "", findChild<QDockWidget*>(name)->windowTitle(),
        tr("Show this panel and move the keyboard focus to it"), [this, name] { goToPanel(name); },
        QKeySequence(panelKey));
  }
  menu->addMenu(panels_);
}

void MainWindow::makeHelpMenu() {
  QMenu* menu = menuBar()->addMenu(tr("&Help"));
  menu->setObjectName(QStringLiteral("helpMenu"));
  const auto show = [this](const char* name, const QString& title, const QString& text) {
    auto* box = new QMessageBox(QMessageBox::NoIcon, title, text, QMessageBox::Close, this);
    box->setObjectName(QString::fromLatin1(name));
    box->setAttribute(Qt::WA_DeleteOnClose);
    box->setTextInteractionFlags(Qt::TextBrowserInteraction);
    box->open();
  };
  add(menu, "citation", tr("How to &Cite"), tr("The paper that the method comes from"), [show] {
    show("citationBox", tr("How to cite"),
         tr("S. Liang, Y. Xiao, W. Tang: <i>InnerGS: Internal Scenes Rendering via Factorized 3D Gaussian "
            "Splatting.</i> arXiv:2508.13287, 2025.<br><br>This program is an independent implementation: "
            "name "
            "it as InnerGS %1 beside the paper.")
             .arg(QStringLiteral(INNERGS_VERSION)));
  });
  add(menu, "about", tr("&About InnerGS"), tr("Version and licence"), [show] {
    show(
        "aboutBox", tr("About InnerGS"),
        tr("<h3>InnerGS %1</h3><p>Medical image slices become a continuous volume of 3D Gaussians.</p>"
           "<p><b>Research software. It is not a medical device and must not be used for diagnosis or "
           "treatment; not for clinical use.</b></p><p>Apache License 2.0. Made with Qt %2, VTK and ITK.</p>")
            .arg(QStringLiteral(INNERGS_VERSION), QString::fromLatin1(qVersion())));
  });
}

} // namespace innergs::app
