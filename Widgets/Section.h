#pragma once
#include <QWidget>

class QToolButton;

namespace innergs::ui {

/// A part of a panel that folds under its title.
class Section : public QWidget {
  Q_OBJECT
public:
  explicit Section(const QString& title, QWidget* parent = nullptr);
  /// Takes ownership of the content. Initially folded.
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
