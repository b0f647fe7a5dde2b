#include "Widgets/SaveDialog.h"

#include <QDir>
#include <QFileInfo>
#include <QMessageBox>
#include <QRegularExpression>

namespace innergs::ui {
namespace {

/// ".nii.gz" of "NIfTI (*.nii.gz)".
QString endOf(const QString& filter) {
  static const QRegularExpression pattern(QStringLiteral("\\*(\\.[A-Za-z0-9.]+)"));
  return pattern.match(filter).captured(1);
}

} // namespace

SaveDialog::SaveDialog(QWidget* parent, const QString& title, const QString& folder, const QString& filters,
                       const QString& name)
    : QFileDialog(parent, title, folder, filters) {
  setAcceptMode(AcceptSave);
  for (const QString& filter : nameFilters()) // the one of the proposed name
    if (name.endsWith(endOf(filter), Qt::CaseInsensitive)) {
      selectNameFilter(filter);
      break;
    }
  const auto follow = [this](const QString& filter) { setDefaultSuffix(endOf(filter).mid(1)); };
  follow(selectedNameFilter());
  selectFile(withoutEnd(name) + endOf(selectedNameFilter()));
  connect(this, &QFileDialog::filterSelected, this, [this, follow](const QString& filter) {
    follow(filter);
    const QString file = QFileInfo(selectedFiles().value(0)).fileName();
    if (withoutEnd(file) != file) selectFile(withoutEnd(file) + endOf(filter));
  });
}

QString SaveDialog::withoutEnd(const QString& file) const {
  QString longest;
  for (const QString& filter : nameFilters())
    if (const QString end = endOf(filter);
        file.endsWith(end, Qt::CaseInsensitive) && end.size() > longest.size())
      longest = end;
  return file.left(file.size() - longest.size());
}

QString SaveDialog::complete(const QString& file) {
  if (withoutEnd(file) != file) return file;
  QString whole = file + endOf(selectedNameFilter());
  if (!QFileInfo::exists(whole)) return whole;
  QMessageBox box(QMessageBox::Warning, windowTitle(),
                  tr("'%1' exists already. Replace it?").arg(QDir::toNativeSeparators(whole)),
                  QMessageBox::Yes | QMessageBox::No, parentWidget());
  box.setObjectName(QStringLiteral("replaceBox"));
  box.setDefaultButton(QMessageBox::No);
  return box.exec() == QMessageBox::Yes ? whole : QString();
}

} // namespace innergs::ui
