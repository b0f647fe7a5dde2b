#include "ReconstructSettings.h"

#include "vtkInnerGSReconstruct.h"

#include <locale>
#include <sstream>

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
  if (this->NumberOfMembers != 0) s.members = this->NumberOfMembers;
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
  s.threads = this->NumberOfThreads;
  s.instructionSet = this->InstructionSet;
  s.device = this->Device;
  s.seed = this->Seed;
  return s;
}

namespace innergs::vtk {

std::string settingsText(const Settings& s, double heldOutFraction) {
  static constexpr const char* presets[] = {"fast", "balanced", "best", "paper"};
  static constexpr const char* losses[] = {"l1", "l2", "huber"};
  static constexpr const char* starts[] = {"adaptive", "grid"};
  static constexpr const char* schedules[] = {"exponential", "plateau"};
  std::ostringstream text;
  text.imbue(std::locale::classic());
  const auto add = [&](const char* name, const auto& value) {
    text << (text.tellp() > 0 ? "; " : "") << name << '=' << value;
  };
  const auto addIf = [&](const char* name, const auto& value) {
    if (value) add(name, *value);
  };
  const auto addWord = [&](const char* name, const auto& value, const char* const* words) {
    if (value) add(name, words[static_cast<int>(*value)]);
  };
  addWord("preset", std::optional(s.preset), presets);
  add("blending", blendingName(chosenBlending(s)));
  add("selection", selectionName(s.selection));
  addIf("gaussians", s.gaussians);
  addIf("maxGaussians", s.maxGaussians);
  addIf("iterations", s.iterations);
  addIf("members", s.members);
  addIf("linearIntensity", s.linearIntensity);
  addWord("initialisation", s.initialisation, starts);
  addWord("loss", s.loss, losses);
  addIf("pointWeight", s.pointWeight);
  addIf("ssimWeight", s.ssimWeight);
  add("huberDelta", s.huberDelta);
  addWord("schedule", s.schedule, schedules);
  if (s.schedule == Schedule::Plateau) {
    add("plateauPatience", s.plateau.patience);
    add("plateauFactor", s.plateau.factor);
    add("plateauLowest", s.plateau.lowest);
    add("plateauThreshold", s.plateau.threshold);
  }
  addIf("densifyEvery", s.densifyEvery);
  if (s.densifyEvery.value_or(0) > 0) {
    addIf("pruneOpacity", s.densify.opacity);
    add("pruneSize", s.densify.size);
    add("densifyGradient", s.densify.gradient);
    add("splitSize", s.densify.split);
  }
  addIf("cutoff", s.cutoff);
  addIf("beta1", s.beta1);
  addIf("beta2", s.beta2);
  addIf("allAxes", s.allAxes);
  addIf("paperStopRule", s.paperStopRule);
  add("relocate", s.relocate);
  add("consistency", s.consistency);
  add("device", s.device);
  add("seed", s.seed);
  add("heldOutFraction", heldOutFraction);
  return text.str();
}

} // namespace innergs::vtk
