// What becomes of results, files and reconstructions when an item or the window of the desktop app is closed.
#include "AppWindowTest.h"
#include "IO/RecoveredFit.h"

#include <QDir>
#include <QFile>
#include <QMenu>

#ifdef Q_OS_UNIX
#include <csignal>
#include <sys/resource.h>
#endif

using namespace innergs;
using namespace apptest;
using innergs::app::AppHost;
using innergs::app::MainWindow;
using innergs::app::SliceView;

namespace {

/// While it lives, files cannot grow beyond a few bytes: writing fails as on a full disk.
class FullDisk {
public:
#ifdef Q_OS_UNIX
  FullDisk() {
    std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit little = before_;
    little.rlim_cur = 2048;
    works_ = setrlimit(RLIMIT_FSIZE, &little) == 0;
  }
  ~FullDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
  }

private:
  rlimit before_{};
  bool works_ = false;

public:
  bool works() const {
    return works_;
  }
#else
  bool works() const {
    return false;
  }
#endif
};

} // namespace

class AppCloseTest : public AppWindowTest {
  Q_OBJECT
  /// A ball in this many voxels each way that no file holds; returns its ID.
  QString addUnsaved(const QString& name, std::int64_t size = 8) {
    app::VolumeItem item = app::makeItem(ball({size, size, size}, {1, 1, 1}), name);
    item.saved = false;
    return host().document().add(std::move(item));
  }

private Q_SLOTS:
  void deleteClosesAnItem() {
    open({writeBall(*sandbox_, "one.nii"), writeBall(*sandbox_, "two.nii")});
    window_->activateWindow();
    QVERIFY(QTest::qWaitForWindowActive(window_.get()));
    tree()->setFocus();
    QTest::keyClick(tree(), Qt::Key_Delete);
    QCOMPARE(lines(), QStringList{"one"});
  }

  void asksAboutUnsavedResults() {
    open({writeBall(*sandbox_, "ball.nii")});
    setQuick();
    reconstruct();
    QString text;
    answerBox("unsavedBox", "Cancel", &text);
    QVERIFY(!window_->close());
    QVERIFY(text.contains("ball reconstructed") && text.contains("ball model"));
    QVERIFY(window_->isVisible());
    // Closing one of them asks as well.
    chooseLine(2);
    answerBox("closeItemBox", "Discard");
    QTest::mouseClick(window_->findChild<QPushButton*>("closeItem"), Qt::LeftButton);
    QCOMPARE(lines(), (QStringList{"ball", "ball reconstructed"}));
    const QString file = sandbox_->path("saved.nrrd");
    answerBox("unsavedBox", "Save All");
    answerFileDialog(file);
    QVERIFY(window_->close());
    QVERIFY(QFile::exists(file));
  }

  void everyAnswerIsObeyed() {
    addUnsaved("one");
    addUnsaved("two");
    auto* closeButton = window_->findChild<QPushButton*>("closeItem");
    // One item: kept by Cancel and by a dialog that is left, gone once it is saved.
    chooseLine(0);
    answerBox("closeItemBox", "Cancel");
    QTest::mouseClick(closeButton, Qt::LeftButton);
    answerBox("closeItemBox", "Save");
    leaveFileDialog();
    QTest::mouseClick(closeButton, Qt::LeftButton);
    QCOMPARE(lines(), (QStringList{"one", "two"}));
    answerBox("closeItemBox", "Save");
    answerFileDialog(sandbox_->path("one.nii"));
    QTest::mouseClick(closeButton, Qt::LeftButton);
    QCOMPARE(lines(), QStringList{"two"});
    QVERIFY(QFile::exists(sandbox_->path("one.nii")));
    // The window: "Save All" whose dialog is left keeps it open, "Discard" closes it.
    answerBox("unsavedBox", "Save All");
    leaveFileDialog();
    QVERIFY(!window_->close());
    QVERIFY(window_->isVisible() && host().document().hasUnsaved());
    answerBox("unsavedBox", "Discard");
    QVERIFY(window_->close());
    QCOMPARE(QDir(sandbox_->path({})).entryList({"*.nii*"}), QStringList{"one.nii"});
  }

  void nothingIsLostWhereItCannotBeWritten() {
    const QString id = addUnsaved("result", 32);
    const QString target = writeBall(*sandbox_, "earlier.nii.gz");
    const auto read = [&] {
      QFile file(target);
      return file.open(QIODevice::ReadOnly) ? file.readAll() : QByteArray();
    };
    const QByteArray before = read();
    const auto files = [&] {
      return QDir(sandbox_->path({})).entryList({"*.nii*"}, QDir::Files | QDir::Hidden);
    };
    const QStringList there = files();
    QString text;
    {
      const FullDisk full;
      if (!full.works()) QSKIP("no way to fill a disk on this system");
      answerFileDialog(target);
      answerBox("errorBox", "OK", &text);
      answerBox("", "Yes"); // replace it
      trigger("saveVolume");
      TRY_VERIFY2(text.contains("free some space"), qPrintable(text));
      // Nor is the window closed over it.
      answerBox("unsavedBox", "Save All");
      answerFileDialog(target);
      answerBox("", "Yes");
      QVERIFY(!window_->close());
    }
    answerBox("errorBox", "OK");
    TRY_VERIFY(!window_->findChild<QMessageBox*>("errorBox"));
    QCOMPARE(read(), before); // the earlier file is whole
    QCOMPARE(files(), there); // and no half of the new one stays
    QVERIFY(window_->isVisible() && !host().document().volume(id)->saved);
    answerFileDialog(target);
    answerBox("", "Yes");
    trigger("saveVolume");
    QVERIFY(host().document().volume(id)->saved);
    QVERIFY(read() != before);
  }

  void closedWhileRunning() {
    open({writeBall(*sandbox_, "ball.nii", {48, 48, 16})});
    setQuick(true);
    start();
    answerBox("runningBox", "Keep Running");
    QVERIFY(!window_->close());
    TRY_VERIFY(!window_->findChild<QMessageBox*>("runningBox"));
    QVERIFY(host().isRunning() && window_->isVisible());
    stopAndClose();
    QVERIFY(!host().isRunning());
  }

  void goesOnAfterARestart() {
    const QString scan = writeBall(*sandbox_, "ball.nii", {48, 48, 16});
    open({scan});
    setQuick(true);
    QSignalSpy progress(&host(), &app::AppHost::progressed);
    start();
    TRY_VERIFY(!progress.isEmpty() && progress.last()[0].value<Progress>().iteration > 20);
    stopAndClose();
    const auto kept = [&] { return recoveredFits(host().recoveryFolder().toStdU16String()); };
    QCOMPARE(kept().size(), std::size_t(1));
    const auto [file, reached] = std::pair(kept()[0].file, kept()[0].iteration);
    QVERIFY(reached > 20);

    window_ = std::make_unique<MainWindow>();
    window_->show();
    open({scan});
    auto* goOn = window_->findChild<QPushButton*>("goOn");
    QVERIFY(goOn->isVisible());
    goOn->click();
    QSignalSpy further(&host(), &app::AppHost::progressed);
    start();
    const auto first = [&] { // iteration that it tells of
      for (const auto& told : further)
        if (const int iteration = told[0].value<Progress>().iteration; iteration > 0) return iteration;
      return 0;
    };
    TRY_VERIFY(first() > 0);
    QVERIFY(first() >= reached);
    host().cancel();
    TRY_VERIFY(!host().isRunning());
    QVERIFY(kept().size() == 1 && kept()[0].file == file); // for another time
  }

  // Closing would silently lose the progress of the fit.
  void staysOpenWhereItCannotBeKept() {
    open({writeBall(*sandbox_, "ball.nii", {48, 48, 16})});
    QFile inTheWay(host().recoveryFolder());
    QVERIFY(inTheWay.open(QIODevice::WriteOnly));
    inTheWay.close();
    setQuick(true);
    QSignalSpy progress(&host(), &app::AppHost::progressed), failed(&host(), &app::AppHost::failed);
    start();
    TRY_VERIFY(!progress.isEmpty() && progress.last()[0].value<Progress>().iteration > 0);
    answerBox("runningBox", "Stop and Close");
    window_->close();
    TRY_COMPARE(failed.size(), 1);
    QVERIFY(failed[0][0].toString().contains("cannot be made"));
    QVERIFY(window_->isVisible());
    QVERIFY(window_->close()); // a further attempt
    QVERIFY(inTheWay.remove());
  }

  void resultFinishedWhileClosingIsNotLost() {
    open({writeBall(*sandbox_, "ball.nii")});
    setQuick();
    start();
    window_->close(); // asks; the fit ends meanwhile
    TRY_VERIFY(window_->findChild<QMessageBox*>("runningBox"));
    TRY_COMPARE(lines().size(), 3);
    QString text;
    answerBox("unsavedBox", "Cancel", &text);
    answerBox("runningBox", "Stop and Close");
    TRY_VERIFY(text.contains("ball reconstructed"));
    QVERIFY(window_->isVisible());
  }

  void closedWhileAFileIsRead() {
    window_->host()->open({writeBall(*sandbox_, "large.nii.gz", {128, 128, 60}, {1, 1, 1})});
    QVERIFY(host().background().isBusy());
    QVERIFY(!window_->close());
    QVERIFY(window_->findChild<QMessageBox*>("busyBox")->isVisible());
    TRY_VERIFY(!window_->isVisible());
    QVERIFY(!host().background().isBusy());
  }

  void closingWhileAFileIsReadIsTakenBack() {
    window_->host()->open(
        {writeBall(*sandbox_, "large.nii.gz", {160, 160, 80}, {1, 1, 1}), sandbox_->path("absent.nii")});
    QVERIFY(!window_->close());
    QVERIFY(!window_->close()); // one box
    auto* box = window_->findChild<QMessageBox*>("busyBox");
    QVERIFY(box && box->isVisible() && box->buttons().size() == 1);
    QCOMPARE(window_->findChildren<QMessageBox*>().size(), 1);
    QTest::keyClick(box, Qt::Key_Escape);
    // Problems with the files are still reported.
    QVERIFY(errorText().contains("does not exist; check the path."));
    QVERIFY(window_->isVisible());
    QCOMPARE(lines(), QStringList{"large"});
    // Also where the window stays open for another reason.
    addUnsaved("result");
    window_->host()->open({sandbox_->path("absent.nii")});
    answerBox("unsavedBox", "Cancel");
    QVERIFY(!window_->close());
    QVERIFY(errorText().contains("does not exist; check the path."));
    QVERIFY(window_->isVisible() && !window_->findChild<QMessageBox*>("busyBox"));
  }

  void windowDeletedWhileRunning() {
    open({writeBall(*sandbox_, "ball.nii", {48, 48, 16})});
    setQuick(true);
    QSignalSpy progress(&host(), &app::AppHost::progressed);
    start();
    QVERIFY(progress.wait(kPatience));
    window_.reset();
    QVERIFY(true); // without a crash
    window_ = std::make_unique<MainWindow>();
  }

  void renamesAndRemembers() {
    const QString file = writeBall(*sandbox_, "ball.nii");
    open({file});
    QTest::mouseClick(window_->findChild<QPushButton*>("renameItem"), Qt::LeftButton);
    auto* edit = tree()->findChild<QLineEdit*>();
    QVERIFY(edit);
    edit->setText("Head of J.");
    QTest::keyClick(edit, Qt::Key_Return);
    TRY_COMPARE(lines(), QStringList{"Head of J."});
    window_->resize(1111, 777);
    QVERIFY(window_->close()); // nothing to save
    window_ = std::make_unique<MainWindow>();
    window_->show();
    TRY_COMPARE(window_->size(), QSize(1111, 777));
    auto* recent = window_->findChild<QMenu*>("recentMenu");
    QVERIFY(recent->actions().first()->text().contains("ball.nii"));
    recent->actions().first()->trigger();
    TRY_COMPARE(lines(), QStringList{"ball"});
  }
};

int main(int argc, char** argv) {
  return runAppTest<AppCloseTest>(argc, argv);
}
#include "AppCloseTest.moc"
