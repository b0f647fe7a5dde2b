#include "Widgets/Section.h"

#include "Widgets/PanelTools.h"

#include <QToolButton>
#include <QVBoxLayout>

namespace innergs::ui {

Section::Section(const QString& title, QWidget* parent) : QWidget(parent), button_(new QToolButton(this)) {
  named(button_, "sectionButton", tr("Show or hide these settings."));
  button_->setText(title);
  button_->setCheckable(true);
  button_->setAutoRaise(true);
  button_->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
  button_->setArrowType(Qt::RightArrow);
  button_->setFocusPolicy(Qt::StrongFocus);
  auto* layout = layoutWithoutMargins<QVBoxLayout>(this);
  layout->addWidget(button_);
  setFocusProxy(button_);
  connect(button_, &QToolButton::toggled, this, &Section::setOpen);
}

void Section::setContent(QWidget* content) {
  content_ = content;
  layout()->addWidget(content);
  content->setVisible(isOpen());
}

bool Section::isOpen() const {
  return button_->isChecked();
}

void Section::setOpen(bool open) {
  button_->setChecked(open);
  button_->setArrowType(open ? Qt::DownArrow : Qt::RightArrow);
  if (!content_ || content_->isHidden() == !open) return;
  content_->setVisible(open);
  Q_EMIT opened(open);
}

} // namespace innergs::ui
