#include "Core/Settings/Settings.h"
#include "vtkInnerGSReconstruct.h"

innergs::Settings vtkInnerGSReconstruct::MakeSettings() {
  innergs::Settings s;
  s.preset = static_cast<innergs::Preset>(this->Preset);
  if (this->Blending != Automatic) s.blending = static_cast<innergs::Blending>(this->Blending);
  if (this->Loss != Automatic) s.loss = static_cast<innergs::LossKind>(this->Loss);
  if (this->Initialisation != Automatic)
    s.initialisation = static_cast<innergs::Initialisation>(this->Initialisation);
  if (this->LinearIntensity != Automatic) s.linearIntensity = this->LinearIntensity == 1;
  if (this->PaperStopRule != Automatic) s.paperStopRule = this->PaperStopRule == 1;
  if (this->AllAxes != Automatic) s.allAxes = this->AllAxes == 1;
  if (this->Schedule != Automatic) s.schedule = static_cast<innergs::Schedule>(this->Schedule);
  if (this->DensifyEvery != Automatic) s.densifyEvery = this->DensifyEvery;
  if (this->MaximumNumberOfGaussians != 0) s.maxGaussians = this->MaximumNumberOfGaussians;
  if (!(this->PointWeight < 0)) s.pointWeight = this->PointWeight;
  if (!(this->SSIMWeight < 0)) s.ssimWeight = this->SSIMWeight;
  if (this->NumberOfGaussians != 0) s.gaussians = this->NumberOfGaussians;
  if (this->NumberOfIterations != 0) s.iterations = this->NumberOfIterations;
  if (this->EnsembleSize != 0) s.ensembleSize = this->EnsembleSize;
  s.selection = static_cast<innergs::Selection>(this->Selection);
  s.plateau = {this->PlateauPatience, this->PlateauFactor, this->PlateauLowest, this->PlateauThreshold};
  if (!(this->PruneOpacity < 0)) s.densify.opacity = this->PruneOpacity;
  s.densify.size = this->PruneSize;
  s.densify.gradient = this->DensifyGradient;
  s.densify.split = this->SplitSize;
  if (!(this->Cutoff < 0)) s.cutoff = this->Cutoff;
  if (!(this->Beta1 < 0)) s.beta1 = this->Beta1;
  if (!(this->Beta2 < 0)) s.beta2 = this->Beta2;
  s.huberDelta = this->HuberDelta;
  s.relocate = this->Relocate;
  s.consistency = this->Consistency;
  s.fill = this->FillValue;
  s.threads = this->NumberOfThreads;
  s.instructionSet = this->InstructionSet;
  s.device = this->Device;
  s.seed = this->Seed;
  return s;
}
