#pragma once
#include "Widgets/App/Document.h"
#include "Widgets/Host.h"

class QComboBox;

namespace innergs::app {

/// A combo box of the document's volumes or models.
class VolumeSelector : public ui::Selector {
  Q_OBJECT
public:
  VolumeSelector(Document* document, ui::Host::Role role, QWidget* parent);
  QString currentId() const override;
  void setCurrentId(const QString& id) override;

private:
  void fill();
  Document* document_;
  ui::Host::Role role_;
  QComboBox* box_;
};

} // namespace innergs::app
