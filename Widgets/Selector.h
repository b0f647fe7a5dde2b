#pragma once
#include <QString>
#include <QWidget>

namespace innergs::ui {

/// A combo box of the host's volumes, masks, regions or models. An empty ID stands for "none" or "new". Its
/// focus proxy is the widget in it that takes the keyboard.
class Selector : public QWidget {
  Q_OBJECT
public:
  using QWidget::QWidget;
  virtual QString currentId() const = 0;
  virtual void setCurrentId(const QString& id) = 0;
Q_SIGNALS:
  void currentIdChanged(const QString& id);
};

} // namespace innergs::ui
