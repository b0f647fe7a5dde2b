#include "AltKeys.h"

#include <QAbstractButton>
#include <QLabel>
#include <QMenuBar>
#include <QSet>

#include <algorithm>

namespace {

/// Index of the letter after a single "&"; −1: none.
int keyAt(const QString& text) {
  for (int i = 0; i + 1 < text.size(); ++i)
    if (text[i] == '&') {
      if (text[i + 1] != '&') return i + 1;
      ++i;
    }
  return -1;
}

/// The text with another letter as its key, which becomes taken.
QString shared(QString text, QSet<QChar>& taken) {
  int at = keyAt(text);
  if (at < 0) return text;
  if (!taken.contains(text[at].toUpper())) {
    taken.insert(text[at].toUpper());
    return text;
  }
  text.remove(at - 1, 1);
  for (const bool starts : {true, false}) // of words, if possible
    for (at = 0; at < text.size(); ++at) {
      const bool start = at == 0 || text[at - 1].isSpace();
      if (!text[at].isLetter() || taken.contains(text[at].toUpper()) || (starts && !start)) continue;
      taken.insert(text[at].toUpper());
      return text.insert(at, '&');
    }
  return text;
}

} // namespace

void shareAltKeys(QWidget* panel, QMenuBar* menus, const QList<const QWidget*>& fixed, const char* reserved) {
  QSet<QChar> taken;
  for (const char* letter = reserved; *letter; ++letter)
    taken.insert(QLatin1Char(*letter));
  for (QAction* menu : menus ? menus->actions() : QList<QAction*>())
    if (const int at = keyAt(menu->text()); at >= 0) taken.insert(menu->text()[at].toUpper());
  for (QWidget* widget : panel->findChildren<QWidget*>()) {
    if (std::any_of(fixed.begin(), fixed.end(),
                    [&](const QWidget* one) { return one && (one == widget || one->isAncestorOf(widget)); }))
      continue;
    if (auto* label = qobject_cast<QLabel*>(widget); label && label->buddy())
      label->setText(shared(label->text(), taken));
    else if (auto* button = qobject_cast<QAbstractButton*>(widget); button && keyAt(button->text()) >= 0)
      button->setText(shared(button->text(), taken));
  }
}
