#pragma once
#include "Widgets/Request.h"

#include <QWidget>

class QGridLayout;
class QLabel;

namespace innergs::ui {

class MessageLine;

/// The quality of a result. Every figure says which samples it was computed on.
class QualityCard : public QWidget {
  Q_OBJECT
public:
  explicit QualityCard(QWidget* parent = nullptr);
  void setReport(const Report& report);
  void clear();

private:
  void setTable(const QVector<QualityRow>& rows);

  QLabel *summary_, *profile_, *agreement_, *prediction_, *uncertainty_, *verdict_, *heldOut_, *samples_,
      *training_;
  MessageLine* warnings_;
  QWidget* table_;
  QGridLayout* grid_;
};

} // namespace innergs::ui
