#pragma once
#include <QList>

class QMenuBar;
class QWidget;

/// Gives every Alt key of a panel to one place: the menus keep theirs, then who comes first in the panel.
/// Another letter of its text, or none, for the rest. Not for what is in `fixed` or renames itself, whose
/// letters are kept free: `reserved`.
void shareAltKeys(QWidget* panel, QMenuBar* menus, const QList<const QWidget*>& fixed, const char* reserved);
