#include "QualityTable.h"

#include <vtkMRMLTableNode.h>

#include <vtkDoubleArray.h>
#include <vtkNew.h>
#include <vtkStringArray.h>
#include <vtkTable.h>

namespace innergs::mrml {

vtkSmartPointer<vtkTable> makeQualityTable(const EvaluationReport& report) {
  vtkNew<vtkStringArray> method;
  vtkNew<vtkDoubleArray> psnr, ssim, seconds;
  method->SetName("Method");
  psnr->SetName("PSNR (dB)");
  ssim->SetName("SSIM");
  seconds->SetName("Seconds");
  for (const MethodScore& score : report.methods) {
    method->InsertNextValue(score.name);
    psnr->InsertNextValue(score.psnr);
    ssim->InsertNextValue(score.ssim);
    seconds->InsertNextValue(score.seconds);
  }
  auto table = vtkSmartPointer<vtkTable>::New();
  for (vtkAbstractArray* column :
       {static_cast<vtkAbstractArray*>(method), static_cast<vtkAbstractArray*>(psnr),
        static_cast<vtkAbstractArray*>(ssim), static_cast<vtkAbstractArray*>(seconds)})
    table->AddColumn(column);
  return table;
}

void setQuality(vtkMRMLTableNode* node, vtkTable* table, const EvaluationReport& report) {
  MRMLNodeModifyBlocker blocker(node);
  node->SetAttribute("InnerGS.Protocol", ("H, " + report.caseName).c_str());
  node->SetAttribute("InnerGS.Samples", report.samples.c_str());
  node->SetAttribute("InnerGS.Range", report.range.c_str());
  node->SetAndObserveTable(table);
}

} // namespace innergs::mrml
