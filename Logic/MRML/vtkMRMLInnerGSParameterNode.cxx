#include "vtkMRMLInnerGSParameterNode.h"

#include "Core/Base/NumberText.h"
#include "SettingsAccess.h"
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

vtkInnerGSOwnSettingsMacro(vtkMRMLInnerGSParameterNode);

namespace {

/// The name in scenes from before each setting had a single name.
std::string formerName(const std::string& name) {
  static const std::map<std::string, std::string> former{
      {"gaussians", "numberOfGaussians"},  {"iterations", "numberOfIterations"},
      {"ensembleSize", "numberOfMembers"}, {"maxGaussians", "maximumNumberOfGaussians"},
      {"lossWeight", "pointWeight"},       {"fill", "fillValue"},
      {"threads", "numberOfThreads"}};
  const auto found = former.find(name);
  return found == former.end() ? name : found->second;
}

/// Choices were numbers then, and values out of range, -1 or 0, meant unset.
void setFormer(innergs::Settings& settings, const innergs::Setting& row, const std::string& text) {
  const innergs::Settings before = settings;
  const auto number =
      row.type() == innergs::Setting::Type::Text ? std::nullopt : innergs::wholeTextNumber(text);
  if (!number)
    row.setText(settings, text);
  else if (!row.member.optional || *number >= 0)
    row.setNumber(settings, number);
  if (row.member.optional && !innergs::sentenceOf([&] { row.check(settings); }).empty()) settings = before;
}

} // namespace

// What else is set: (kind of macro, XML attribute, property).
#define INNERGS_SETTINGS(DO)                                                                                 \
  DO(Float, heldOutFraction, HeldOutFraction)                                                                \
  DO(Boolean, estimateUncertainty, EstimateUncertainty)                                                      \
  DO(Boolean, evaluateQuality, EvaluateQuality)                                                              \
  DO(Int, qualityGap, QualityGap)                                                                            \
  DO(Int, outputGrid, OutputGrid)                                                                            \
  DO(Float, outputSpacing, OutputSpacing)

#define INNERGS_PROPERTIES(DO)                                                                               \
  INNERGS_SETTINGS(DO)                                                                                       \
  DO(StdString, maskSegmentID, MaskSegmentID)                                                                \
  DO(StdString, resumeFileName, ResumeFileName)                                                              \
  DO(StdString, inputSettings, InputSettings)

vtkMRMLInnerGSParameterNode::vtkMRMLInnerGSParameterNode() : Choices(std::make_unique<innergs::Settings>()) {
  for (const char* role :
       {GetInputVolumeReferenceRole(), GetMaskReferenceRole(), GetInputMaskReferenceRole(),
        GetInputSlicePosesReferenceRole(), GetROIReferenceRole(), GetReferenceVolumeReferenceRole(),
        GetOutputVolumeReferenceRole(), GetOutputModelReferenceRole(), GetQualityTableReferenceRole(),
        GetResultVolumeReferenceRole(), GetResultModelReferenceRole(), GetResultTableReferenceRole(),
        GetOutputUncertaintyReferenceRole(), GetResultUncertaintyReferenceRole(),
        GetResultSliceTableReferenceRole()})
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
  std::map<std::string, std::string> given;
  for (; atts[0]; atts += 2)
    given[atts[0]] = atts[1];
  const bool former = given.count("numberOfGaussians") > 0; // always written then, now only what is set
  innergs::Settings settings;
  for (const innergs::Setting& row : innergs::settingsTable()) {
    const auto found = given.find(former ? formerName(row.name) : row.name);
    if (found == given.end()) continue;
    const std::string refusal = innergs::sentenceOf([&] {
      if (former)
        setFormer(settings, row, found->second);
      else
        row.setText(settings, found->second);
    });
    if (!refusal.empty()) vtkWarningMacro(<< refusal);
  }
  this->SetSettings(settings);
  this->EndModify(wasModifying);
}

void vtkMRMLInnerGSParameterNode::WriteXML(ostream& of, int indent) {
  this->Superclass::WriteXML(of, indent);
  const auto precision = of.precision(17); // numbers come back as they were
#define INNERGS_WRITE(Kind, attribute, Property) vtkMRMLWriteXML##Kind##Macro(attribute, Property);
  vtkMRMLWriteXMLBeginMacro(of);
  INNERGS_PROPERTIES(INNERGS_WRITE)
  vtkMRMLWriteXMLEndMacro();
  for (const innergs::Setting& row : innergs::settingsTable())
    if (const std::string text = row.textIn(*this->Choices); !text.empty())
      of << " " << row.name << "=\"" << vtkMRMLNode::XMLAttributeEncodeString(text) << "\"";
  of.precision(precision);
}

void vtkMRMLInnerGSParameterNode::CopyContent(vtkMRMLNode* node, bool deepCopy) {
  MRMLNodeModifyBlocker blocker(this);
  this->Superclass::CopyContent(node, deepCopy);
#define INNERGS_COPY(Kind, attribute, Property) vtkMRMLCopy##Kind##Macro(Property);
  vtkMRMLCopyBeginMacro(node);
  INNERGS_PROPERTIES(INNERGS_COPY)
  vtkMRMLCopyEndMacro();
  if (auto* source = SafeDownCast(node)) this->SetSettings(source->GetSettings());
}

void vtkMRMLInnerGSParameterNode::PrintSelf(ostream& os, vtkIndent indent) {
  this->Superclass::PrintSelf(os, indent);
#define INNERGS_PRINT(Kind, attribute, Property) vtkMRMLPrint##Kind##Macro(Property);
  vtkMRMLPrintBeginMacro(os, indent);
  INNERGS_PROPERTIES(INNERGS_PRINT)
  vtkMRMLPrintEndMacro();
  os << indent << "Settings: " << innergs::settingsText(*this->Choices, this->HeldOutFraction) << "\n";
}

void vtkMRMLInnerGSParameterNode::ResetSettings() {
  MRMLNodeModifyBlocker blocker(this);
  vtkNew<vtkMRMLInnerGSParameterNode> fresh;
#define INNERGS_RESET(Kind, attribute, Property) this->Set##Property(fresh->Get##Property());
  INNERGS_SETTINGS(INNERGS_RESET)
  this->SetSettings({});
}

void vtkMRMLInnerGSParameterNode::UpdateReferenceID(const char* oldID, const char* newID) {
  this->Superclass::UpdateReferenceID(oldID, newID);
  if (!oldID || !newID) return;
  for (auto& [input, stack] : this->Stacks)
    for (std::string* id : {&stack.Mask, &stack.Poses})
      if (*id == oldID) *id = newID;
  const auto found = this->Stacks.find(oldID);
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

void vtkMRMLInnerGSParameterNode::SetInputNode(vtkMRMLNode* input, std::string StackSettings::*which,
                                               vtkMRMLNode* node) {
  const std::string id = node && node->GetID() ? node->GetID() : "";
  if (!input || !input->GetID() || this->StackOf(input).*which == id) return;
  MRMLNodeModifyBlocker blocker(this);
  this->Stacks[input->GetID()].*which = id;
  // References let the scene update the IDs here when it has to change them.
  this->RemoveNodeReferenceIDs(GetInputMaskReferenceRole());
  this->RemoveNodeReferenceIDs(GetInputSlicePosesReferenceRole());
  for (const auto& [key, stack] : this->Stacks) {
    if (!stack.Mask.empty()) this->AddNodeReferenceID(GetInputMaskReferenceRole(), stack.Mask.c_str());
    if (!stack.Poses.empty())
      this->AddNodeReferenceID(GetInputSlicePosesReferenceRole(), stack.Poses.c_str());
  }
  this->Modified();
}

vtkMRMLNode* vtkMRMLInnerGSParameterNode::GetInputNode(vtkMRMLNode* input,
                                                       std::string StackSettings::*which) {
  const std::string id = this->StackOf(input).*which;
  return this->Scene && !id.empty() ? this->Scene->GetNodeByID(id.c_str()) : nullptr;
}

void vtkMRMLInnerGSParameterNode::SetInputMaskNode(vtkMRMLNode* input, vtkMRMLNode* mask) {
  this->SetInputNode(input, &StackSettings::Mask, mask);
}

vtkMRMLNode* vtkMRMLInnerGSParameterNode::GetInputMaskNode(vtkMRMLNode* input) {
  return this->GetInputNode(input, &StackSettings::Mask);
}

bool vtkMRMLInnerGSParameterNode::HasInputMask(vtkMRMLNode* input) {
  return !this->StackOf(input).Mask.empty();
}

void vtkMRMLInnerGSParameterNode::SetInputSlicePosesNode(vtkMRMLNode* input, vtkMRMLNode* sequence) {
  this->SetInputNode(input, &StackSettings::Poses, sequence);
}

vtkMRMLNode* vtkMRMLInnerGSParameterNode::GetInputSlicePosesNode(vtkMRMLNode* input) {
  return this->GetInputNode(input, &StackSettings::Poses);
}

bool vtkMRMLInnerGSParameterNode::HasInputSlicePoses(vtkMRMLNode* input) {
  return !this->StackOf(input).Poses.empty();
}

std::string vtkMRMLInnerGSParameterNode::GetInputSettings() {
  std::ostringstream text;
  text.imbue(std::locale::classic());
  text.precision(17);
  const auto idOr = [](const std::string& id) { return id.empty() ? "-" : id; };
  for (const auto& [id, stack] : this->Stacks)
    text << id << ' ' << stack.Thickness << ' ' << stack.Profile << ' ' << stack.Axis << ' '
         << idOr(stack.Mask) << ' ' << idOr(stack.Poses) << ';';
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
    if (!(words >> id >> stack.Thickness >> stack.Profile >> stack.Axis)) continue;
    for (std::string* node : {&stack.Mask, &stack.Poses}) // missing in scenes of earlier versions
      if (words >> *node && *node == "-") node->clear();
    stacks[id] = stack;
  }
  if (text == this->GetInputSettings()) return;
  this->Stacks = std::move(stacks);
  this->Modified();
}

void vtkMRMLInnerGSParameterNode::SetReference(const char* role, vtkMRMLNode* node) {
  this->SetNodeReferenceID(role, node ? node->GetID() : nullptr);
}

// Setter and getter of a node that is referenced by role.
#define INNERGS_GET_REFERENCE(Type, Name, Role)                                                              \
  Type* vtkMRMLInnerGSParameterNode::Get##Name() {                                                           \
    return Type::SafeDownCast(this->GetNodeReference(Get##Role##ReferenceRole()));                           \
  }
#define INNERGS_REFERENCE(Type, Name, Role)                                                                  \
  void vtkMRMLInnerGSParameterNode::Set##Name(Type* node) {                                                  \
    this->SetReference(Get##Role##ReferenceRole(), node);                                                    \
  }                                                                                                          \
  INNERGS_GET_REFERENCE(Type, Name, Role)
INNERGS_REFERENCE(vtkMRMLNode, MaskNode, Mask)
INNERGS_REFERENCE(vtkMRMLNode, ROINode, ROI)
INNERGS_REFERENCE(vtkMRMLVolumeNode, ReferenceVolumeNode, ReferenceVolume)
INNERGS_REFERENCE(vtkMRMLScalarVolumeNode, OutputVolumeNode, OutputVolume)
INNERGS_REFERENCE(vtkMRMLInnerGSModelNode, OutputModelNode, OutputModel)
INNERGS_REFERENCE(vtkMRMLTableNode, QualityTableNode, QualityTable)
INNERGS_REFERENCE(vtkMRMLScalarVolumeNode, OutputUncertaintyNode, OutputUncertainty)
INNERGS_GET_REFERENCE(vtkMRMLScalarVolumeNode, ResultVolumeNode, ResultVolume)
INNERGS_GET_REFERENCE(vtkMRMLScalarVolumeNode, ResultUncertaintyNode, ResultUncertainty)
INNERGS_GET_REFERENCE(vtkMRMLInnerGSModelNode, ResultModelNode, ResultModel)
INNERGS_GET_REFERENCE(vtkMRMLTableNode, ResultTableNode, ResultTable)
INNERGS_GET_REFERENCE(vtkMRMLTableNode, ResultSliceTableNode, ResultSliceTable)
