#pragma once
#include "IO/RecoveredFit.h"
#include "Widgets/Host.h"

class QPushButton;

namespace innergs::ui {

class MessageLine;

/// Offers to resume the newest fit in the host's recovery folder, of static scans or of dynamic ones, and says
/// when the next reconstruction continues one. Hidden when there is neither.
class RecoveryLine : public QWidget {
  Q_OBJECT
public:
  enum class Scans { Static, Dynamic };
  RecoveryLine(Host* host, Scans scans, QWidget* parent);
  /// What the next reconstruction continues, as in its request.
  QString file() const { return file_; }
  void setFile(const QString& file);
  /// Looks again; returns whether it now offers another fit.
  bool refresh();

Q_SIGNALS:
  /// By the user, who wants to resume it.
  void chosen(const innergs::RecoveredFit& fit);
  /// By the user: file() is empty now.
  void dropped();

private:
  void accept();
  void dismiss();

  Host* host_;
  bool dynamic_;
  QString file_;
  RecoveredFit offered_; // without a file: none
  MessageLine* message_;
  QPushButton *accept_, *dismiss_;
};

} // namespace innergs::ui
