#pragma once
#include <QWidget>

class QToolButton;

namespace innergs::ui {

/// A part of a panel that folds away under its title.
class Section : public QWidget {
  Q_OBJECT
public:
  explicit Section(const QString& title, QWidget* parent = nullptr);
  /// Takes the content over. Folded at first.
  void setContent(QWidget* content);
  bool isOpen() const;

public Q_SLOTS:
  void setOpen(bool open);

Q_SIGNALS:
  void opened(bool open);

private:
  QToolButton* button_;
  QWidget* content_ = nullptr;
};

} // namespace innergs::ui
