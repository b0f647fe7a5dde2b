#include "vtkMRMLInnerGSParameterNode.h"

#include "vtkMRMLInnerGSModelNode.h"

#include <vtkMRMLNodePropertyMacros.h>
#include <vtkMRMLScalarVolumeNode.h>
#include <vtkMRMLScene.h>
#include <vtkMRMLTableNode.h>
#include <vtkMRMLVolumeNode.h>

#include <vtkObjectFactory.h>

#include <locale>
#include <sstream>

vtkMRMLNodeNewMacro(vtkMRMLInnerGSParameterNode);

// Every setting once: (kind of macro, XML attribute, property).
#define INNERGS_SETTINGS(DO)                                                                                 \
  DO(Int, preset, Preset)                                                                                    \
  DO(Int, blending, Blending)                                                                                \
  DO(Int, linearIntensity, LinearIntensity)                                                                  \
  DO(Int, initialisation, Initialisation)                                                                    \
  DO(Int, loss, Loss)                                                                                        \
  DO(Float, huberDelta, HuberDelta)                                                                          \
  DO(Float, ssimWeight, SSIMWeight)                                                                          \
  DO(Int, numberOfGaussians, NumberOfGaussians)                                                              \
  DO(Int, numberOfIterations, NumberOfIterations)                                                            \
  DO(Int, numberOfMembers, EnsembleSize)                                                                     \
  DO(Int, paperStopRule, PaperStopRule)                                                                      \
  DO(Int, allAxes, AllAxes)                                                                                  \
  DO(Int, schedule, Schedule)                                                                                \
  DO(Int, densifyEvery, DensifyEvery)                                                                        \
  DO(Int, maximumNumberOfGaussians, MaximumNumberOfGaussians)                                                \
  DO(Float, pointWeight, PointWeight)                                                                        \
  DO(Int, selection, Selection)                                                                              \
  DO(Int, plateauPatience, PlateauPatience)                                                                  \
  DO(Float, plateauFactor, PlateauFactor)                                                                    \
  DO(Float, plateauLowest, PlateauLowest)                                                                    \
  DO(Float, plateauThreshold, PlateauThreshold)                                                              \
  DO(Float, pruneOpacity, PruneOpacity)                                                                      \
  DO(Float, pruneSize, PruneSize)                                                                            \
  DO(Float, densifyGradient, DensifyGradient)                                                                \
  DO(Float, splitSize, SplitSize)                                                                            \
  DO(Float, cutoff, Cutoff)                                                                                  \
  DO(Float, beta1, Beta1)                                                                                    \
  DO(Float, beta2, Beta2)                                                                                    \
  DO(StdString, device, Device)                                                                              \
  DO(Boolean, relocate, Relocate)                                                                            \
  DO(Boolean, consistency, Consistency)                                                                      \
  DO(Float, fillValue, FillValue)                                                                            \
  DO(Int, numberOfThreads, NumberOfThreads)                                                                  \
  DO(StdString, instructionSet, InstructionSet)                                                              \
  DO(Int, seed, Seed)                                                                                        \
  DO(Float, heldOutFraction, HeldOutFraction)                                                                \
  DO(Boolean, evaluateQuality, EvaluateQuality)                                                              \
  DO(Int, qualityGap, QualityGap)                                                                            \
  DO(Int, outputGrid, OutputGrid)                                                                            \
  DO(Float, outputSpacing, OutputSpacing)

#define INNERGS_PROPERTIES(DO)                                                                               \
  INNERGS_SETTINGS(DO)                                                                                       \
  DO(StdString, maskSegmentID, MaskSegmentID)                                                                \
  DO(StdString, inputSettings, InputSettings)

vtkMRMLInnerGSParameterNode::vtkMRMLInnerGSParameterNode() {
  for (const char* role :
       {GetInputVolumeReferenceRole(), GetMaskReferenceRole(), GetROIReferenceRole(),
        GetReferenceVolumeReferenceRole(), GetOutputVolumeReferenceRole(), GetOutputModelReferenceRole(),
        GetQualityTableReferenceRole(), GetResultVolumeReferenceRole(), GetResultModelReferenceRole(),
        GetResultTableReferenceRole()})
    this->AddNodeReferenceRole(role, (std::string(role) + "Ref").c_str());
}

vtkMRMLInnerGSParameterNode::~vtkMRMLInnerGSParameterNode() = default;

void vtkMRMLInnerGSParameterNode::ReadXMLAttributes(const char** atts) {
  const int wasModifying = this->StartModify();
  this->Superclass::ReadXMLAttributes(atts);
#define INNERGS_READ(Kind, attribute, Property) vtkMRMLReadXML##Kind##Macro(attribute, Property);
  vtkMRMLReadXMLBeginMacro(atts);
  INNERGS_PROPERTIES(INNERGS_READ)
  vtkMRMLReadXMLEndMacro();
  this->EndModify(wasModifying);
}

void vtkMRMLInnerGSParameterNode::WriteXML(ostream& of, int indent) {
  this->Superclass::WriteXML(of, indent);
  const auto precision = of.precision(17); // numbers come back as they were
#define INNERGS_WRITE(Kind, attribute, Property) vtkMRMLWriteXML##Kind##Macro(attribute, Property);
  vtkMRMLWriteXMLBeginMacro(of);
  INNERGS_PROPERTIES(INNERGS_WRITE)
  vtkMRMLWriteXMLEndMacro();
  of.precision(precision);
}

void vtkMRMLInnerGSParameterNode::CopyContent(vtkMRMLNode* node, bool deepCopy) {
  MRMLNodeModifyBlocker blocker(this);
  this->Superclass::CopyContent(node, deepCopy);
#define INNERGS_COPY(Kind, attribute, Property) vtkMRMLCopy##Kind##Macro(Property);
  vtkMRMLCopyBeginMacro(node);
  INNERGS_PROPERTIES(INNERGS_COPY)
  vtkMRMLCopyEndMacro();
}

void vtkMRMLInnerGSParameterNode::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
#define INNERGS_PRINT(Kind, attribute, Property) vtkMRMLPrint##Kind##Macro(Property);
  vtkMRMLPrintBeginMacro(os, indent);
  INNERGS_PROPERTIES(INNERGS_PRINT)
  vtkMRMLPrintEndMacro();
}

void vtkMRMLInnerGSParameterNode::ResetSettings() {
  MRMLNodeModifyBlocker blocker(this);
  vtkNew<vtkMRMLInnerGSParameterNode> fresh;
#define INNERGS_RESET(Kind, attribute, Property) this->Set##Property(fresh->Get##Property());
  INNERGS_SETTINGS(INNERGS_RESET)
}

void vtkMRMLInnerGSParameterNode::UpdateReferenceID(const char* oldID, const char* newID) {
  this->Superclass::UpdateReferenceID(oldID, newID);
  const auto found = oldID && newID ? this->Stacks.find(oldID) : this->Stacks.end();
  if (found == this->Stacks.end()) return;
  const StackSettings settings = found->second;
  this->Stacks.erase(found);
  this->Stacks[newID] = settings;
}

void vtkMRMLInnerGSParameterNode::AddInputVolumeNode(vtkMRMLVolumeNode* node) {
  if (!node) return;
  for (int n = 0; n < this->GetNumberOfInputVolumeNodes(); ++n)
    if (this->GetInputVolumeNode(n) == node) return;
  this->AddNodeReferenceID(GetInputVolumeReferenceRole(), node->GetID());
}

void vtkMRMLInnerGSParameterNode::SetInputVolumeNode(vtkMRMLVolumeNode* node) {
  MRMLNodeModifyBlocker blocker(this);
  this->RemoveAllInputVolumeNodes();
  this->AddInputVolumeNode(node);
}

void vtkMRMLInnerGSParameterNode::RemoveInputVolumeNode(vtkMRMLVolumeNode* node) {
  for (int n = this->GetNumberOfInputVolumeNodes() - 1; n >= 0; --n)
    if (this->GetInputVolumeNode(n) == node) this->RemoveNthNodeReferenceID(GetInputVolumeReferenceRole(), n);
}

void vtkMRMLInnerGSParameterNode::RemoveAllInputVolumeNodes() {
  this->RemoveNodeReferenceIDs(GetInputVolumeReferenceRole());
}

int vtkMRMLInnerGSParameterNode::GetNumberOfInputVolumeNodes() {
  return this->GetNumberOfNodeReferences(GetInputVolumeReferenceRole());
}

vtkMRMLVolumeNode* vtkMRMLInnerGSParameterNode::GetInputVolumeNode(int index) {
  return vtkMRMLVolumeNode::SafeDownCast(this->GetNthNodeReference(GetInputVolumeReferenceRole(), index));
}

vtkMRMLInnerGSParameterNode::StackSettings vtkMRMLInnerGSParameterNode::StackOf(vtkMRMLNode* input) const {
  const auto found = input && input->GetID() ? this->Stacks.find(input->GetID()) : this->Stacks.end();
  return found == this->Stacks.end() ? StackSettings{} : found->second;
}

// Setter and getter of one of the settings that an input has.
#define INNERGS_STACK_SETTING(Type, Name)                                                                    \
  void vtkMRMLInnerGSParameterNode::SetInputSlice##Name(vtkMRMLNode* input, Type value) {                    \
    if (!input || !input->GetID() || this->StackOf(input).Name == value) return;                             \
    this->Stacks[input->GetID()].Name = value;                                                               \
    this->Modified();                                                                                        \
  }                                                                                                          \
  Type vtkMRMLInnerGSParameterNode::GetInputSlice##Name(vtkMRMLNode* input) {                                \
    return this->StackOf(input).Name;                                                                        \
  }
INNERGS_STACK_SETTING(double, Thickness)
INNERGS_STACK_SETTING(int, Profile)
INNERGS_STACK_SETTING(int, Axis)

std::string vtkMRMLInnerGSParameterNode::GetInputSettings() {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(17);
  for (const auto& [id, stack] : this->Stacks)
    text << id << ' ' << stack.Thickness << ' ' << stack.Profile << ' ' << stack.Axis << ';';
  return text.str();
}

void vtkMRMLInnerGSParameterNode::SetInputSettings(const std::string& text) {
  std::map<std::string, StackSettings> stacks;
  std::istringstream entries(text);
  for (std::string entry; std::getline(entries, entry, ';');) {
    std::istringstream words(entry);
    words.imbue(std::locale::classic());
    std::string id;
    StackSettings stack;
    if (words >> id >> stack.Thickness >> stack.Profile >> stack.Axis) stacks[id] = stack;
  }
  if (text == this->GetInputSettings()) return;
  this->Stacks = std::move(stacks);
  this->Modified();
}

void vtkMRMLInnerGSParameterNode::SetReference(const char* role, vtkMRMLNode* node) {
  this->SetNodeReferenceID(role, node ? node->GetID() : nullptr);
}

// Setter and getter of a node that is referenced by role.
#define INNERGS_REFERENCE(Type, Name, Role)                                                                  \
  void vtkMRMLInnerGSParameterNode::Set##Name(Type* node) {                                                  \
    this->SetReference(Get##Role##ReferenceRole(), node);                                                    \
  }                                                                                                          \
  Type* vtkMRMLInnerGSParameterNode::Get##Name() {                                                           \
    return Type::SafeDownCast(this->GetNodeReference(Get##Role##ReferenceRole()));                           \
  }
INNERGS_REFERENCE(vtkMRMLNode, MaskNode, Mask)
INNERGS_REFERENCE(vtkMRMLNode, ROINode, ROI)
INNERGS_REFERENCE(vtkMRMLVolumeNode, ReferenceVolumeNode, ReferenceVolume)
INNERGS_REFERENCE(vtkMRMLScalarVolumeNode, OutputVolumeNode, OutputVolume)
INNERGS_REFERENCE(vtkMRMLInnerGSModelNode, OutputModelNode, OutputModel)
INNERGS_REFERENCE(vtkMRMLTableNode, QualityTableNode, QualityTable)

vtkMRMLScalarVolumeNode* vtkMRMLInnerGSParameterNode::GetResultVolumeNode() {
  return vtkMRMLScalarVolumeNode::SafeDownCast(this->GetNodeReference(GetResultVolumeReferenceRole()));
}
vtkMRMLInnerGSModelNode* vtkMRMLInnerGSParameterNode::GetResultModelNode() {
  return vtkMRMLInnerGSModelNode::SafeDownCast(this->GetNodeReference(GetResultModelReferenceRole()));
}
vtkMRMLTableNode* vtkMRMLInnerGSParameterNode::GetResultTableNode() {
  return vtkMRMLTableNode::SafeDownCast(this->GetNodeReference(GetResultTableReferenceRole()));
}
