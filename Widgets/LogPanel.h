#pragma once
#include "Widgets/Host.h"

#include <QWidget>

class QPlainTextEdit;

namespace innergs::ui {

/// A log with the time of day: reconstructions with their settings and warnings, and the host's messages.
/// Copy puts all of it on the clipboard.
class LogPanel : public QWidget {
  Q_OBJECT
public:
  explicit LogPanel(Host* host, QWidget* parent = nullptr);
  QString text() const;

public Q_SLOTS:
  void add(const QString& line);
  void copy();

private:
  void addReport(const Report& report);

  QPlainTextEdit* edit_;
};

} // namespace innergs::ui
