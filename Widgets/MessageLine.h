#pragma once
#include <QWidget>

class QLabel;

namespace innergs::ui {

/// A message in a panel, with an icon; hidden while empty. Its text can be selected.
class MessageLine : public QWidget {
  Q_OBJECT
public:
  enum class Kind { Information, Warning, Error };

  explicit MessageLine(QWidget* parent = nullptr);
  void setMessage(Kind kind, const QString& text);
  /// What was done, or why it could not be.
  void say(const QString& sentence, bool error = false);
  void clear();
  QString text() const;
  Kind kind() const { return kind_; }

protected:
  void changeEvent(QEvent* event) override;

private:
  void setIcon();

  Kind kind_ = Kind::Information;
  QLabel* icon_;
  QLabel* label_;
};

} // namespace innergs::ui
