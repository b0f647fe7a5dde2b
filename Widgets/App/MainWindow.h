#pragma once
#include "Widgets/App/AppHost.h"
#include "Widgets/App/ViewGrid.h"
#include "Widgets/Request.h"

#include <QMainWindow>
#include <QPointer>

class QAction;
class QActionGroup;
class QDockWidget;
class QLabel;
class QMenu;
class QMessageBox;
class QProgressBar;

namespace innergs::ui {
class FindPanel;
class ModelPanel;
class MotionPanel;
class QueryPanel;
class ReconstructionPanel;
} // namespace innergs::ui

namespace innergs::app {

class DataList;
class FileDialogs;

/// The desktop app's window: views in the middle; panels and data list in docks.
class MainWindow : public QMainWindow {
  Q_OBJECT
public:
  explicit MainWindow(QWidget* parent = nullptr);
  ~MainWindow() override;

  AppHost* host() { return host_; }
  ViewState* state() { return state_; }
  FileDialogs* files() { return files_; }
  ViewGrid* views() { return views_; }
  ui::ReconstructionPanel* reconstruction() { return reconstruction_; }
  ui::QueryPanel* query() { return query_; }
  ui::FindPanel* find() { return find_; }
  ui::MotionPanel* motion() { return motion_; }
  /// Brings a panel to the front: "reconstructDock", "motionDock", "queryDock", "findDock", "modelDock",
  /// "logDock", "dataDock".
  void showPanel(const QString& name);
  /// The same, and moves the keyboard focus to its first control.
  void goToPanel(const QString& name);

  /// Presses Reconstruct; with `all`, from all volumes that are open.
  void reconstruct(bool all);

protected:
  bool focusNextPrevChild(bool next) override;
  void closeEvent(QCloseEvent* event) override;
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;

private:
  void makeDocks();
  void makeFileMenu();
  void makeViewMenu();
  void makeHelpMenu();
  void restoreLayout();
  QAction* add(QMenu* menu, const char* name, const QString& text, const QString& tip,
               const QKeySequence& keys, const std::function<void()>& call = {});
  QDockWidget* addDock(QWidget* content, const char* name, const QString& title, bool scrolled);
  void updateActions();
  /// Sets the model that panels and menus act on.
  void setModel(const QString& id);
  void remember(const QString& file);
  void fillRecent();
  void tellErrors();
  void showFinished(const ui::Report& report);
  void reconstructionEnded();

  AppHost* host_;
  ViewState* state_;
  FileDialogs* files_;
  ViewGrid* views_;
  DataList* list_ = nullptr;
  ui::ReconstructionPanel* reconstruction_ = nullptr;
  ui::QueryPanel* query_ = nullptr;
  ui::FindPanel* find_ = nullptr;
  ui::MotionPanel* motion_ = nullptr;
  ui::ModelPanel* model_ = nullptr;
  QMenu *recent_ = nullptr, *panels_ = nullptr;
  QActionGroup* layouts_ = nullptr;
  QAction *saveVolume_ = nullptr, *saveModel_ = nullptr, *rendering_ = nullptr, *ellipsoids_ = nullptr;
  QList<QAction*> needVolume_;
  QLabel *pointed_ = nullptr, *busyText_ = nullptr;
  QProgressBar* busy_ = nullptr;
  QString modelId_;    // that the menus act on
  QStringList errors_; // of files
  QPointer<QMessageBox> busyBox_;
  bool closeWhenEnded_ = false, closeWhenIdle_ = false;
};

} // namespace innergs::app
