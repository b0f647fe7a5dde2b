#include "Widgets/MessageLine.h"

#include "Widgets/PanelTools.h"

#include <QEvent>
#include <QHBoxLayout>
#include <QLabel>
#include <QStyle>

namespace innergs::ui {

MessageLine::MessageLine(QWidget* parent)
    : QWidget(parent), icon_(new QLabel(this)), label_(makeWrappedLabel("messageText", this)) {
  auto* layout = layoutWithoutMargins<QHBoxLayout>(this);
  layout->addWidget(icon_, 0, Qt::AlignTop);
  layout->addWidget(label_, 1);
  label_->setTextInteractionFlags(Qt::TextSelectableByMouse | Qt::TextSelectableByKeyboard);
  hide();
}

void MessageLine::setMessage(Kind kind, const QString& text) {
  kind_ = kind;
  label_->setText(text);
  setIcon();
  setVisible(!text.isEmpty());
}

void MessageLine::say(const QString& sentence, bool error) {
  setMessage(error ? Kind::Error : Kind::Information, sentence);
}

void MessageLine::clear() {
  label_->clear();
  hide();
}

QString MessageLine::text() const {
  return label_->text();
}

void MessageLine::changeEvent(QEvent* event) {
  if (event->type() == QEvent::StyleChange || event->type() == QEvent::PaletteChange) setIcon();
  QWidget::changeEvent(event);
}

void MessageLine::setIcon() {
  const auto which = kind_ == Kind::Error     ? QStyle::SP_MessageBoxCritical
                     : kind_ == Kind::Warning ? QStyle::SP_MessageBoxWarning
                                              : QStyle::SP_MessageBoxInformation;
  const int size = style()->pixelMetric(QStyle::PM_SmallIconSize, nullptr, this);
  icon_->setPixmap(style()->standardIcon(which, nullptr, this).pixmap(size, size));
}

} // namespace innergs::ui
