#ifndef qSlicerInnerGSReader_h
#define qSlicerInnerGSReader_h

#include "qSlicerFileReader.h"

#include <vtkWeakPointer.h>

class vtkSlicerInnerGSLogic;

/// Opens .innergs files, and .ply files that hold Gaussians.
class qSlicerInnerGSReader : public qSlicerFileReader {
  Q_OBJECT
public:
  typedef qSlicerFileReader Superclass;
  explicit qSlicerInnerGSReader(vtkSlicerInnerGSLogic* logic, QObject* parent = nullptr);
  ~qSlicerInnerGSReader() override;

  QString description() const override;
  IOFileType fileType() const override;
  QStringList extensions() const override;
  bool canLoadFile(const QString& file) const override;
  bool load(const IOProperties& properties) override;

private:
  Q_DISABLE_COPY(qSlicerInnerGSReader);
  vtkWeakPointer<vtkSlicerInnerGSLogic> logic_;
};

#endif
