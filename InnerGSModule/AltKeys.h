#pragma once
#include <QList>

class QMenuBar;
class QWidget;

/// Makes the Alt keys of a panel unique: menus keep theirs, then the first occurrence in the panel; the rest
/// get another letter of their text, or none. Does not change `fixed`, whose texts vary, and keeps their
/// letters, `reserved`, free.
void shareAltKeys(QWidget* panel, QMenuBar* menus, const QList<const QWidget*>& fixed, const char* reserved);
