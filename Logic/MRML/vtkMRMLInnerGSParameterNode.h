#ifndef vtkMRMLInnerGSParameterNode_h
#define vtkMRMLInnerGSParameterNode_h

#include "vtkInnerGSSettingsMacro.h"
#include "vtkMRMLNode.h"
#include "vtkSlicerInnerGSModuleMRMLExport.h"

#include <map>    // std::map
#include <memory> // std::unique_ptr
#include <string> // returned

class vtkMRMLInnerGSModelNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLTableNode;
class vtkMRMLVolumeNode;
#ifndef __VTK_WRAP__
namespace innergs {
struct Settings;
}
#endif

/// Everything that a reconstruction is asked for: inputs, region, output grid and settings. Saved with the
/// scene.
class VTK_SLICER_INNERGS_MODULE_MRML_EXPORT vtkMRMLInnerGSParameterNode : public vtkMRMLNode {
public:
  static vtkMRMLInnerGSParameterNode* New();
  vtkTypeMacro(vtkMRMLInnerGSParameterNode, vtkMRMLNode);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  vtkMRMLNode* CreateNodeInstance() override;
  const char* GetNodeTagName() override { return "InnerGSParameters"; }
  void ReadXMLAttributes(const char** atts) override;
  void WriteXML(ostream& of, int indent) override;
  vtkMRMLCopyContentMacro(vtkMRMLInnerGSParameterNode);
  void UpdateReferenceID(const char* oldID, const char* newID) override;

  enum SliceProfiles { PointProfile, BoxProfile, GaussianProfile };
  enum OutputGrids {
    AutomaticGrid, // isotropic at the finest spacing of all inputs, over the first one's box or the ROI
    InputGrid,     // the first input's voxels (with a ROI: those in it)
    SpacingGrid,   // isotropic at OutputSpacing, over the first input's box or the ROI
    ReferenceGrid  // the reference volume's voxels
  };

  ///@{
  /// The scans: one volume, or several of the same patient (orthogonal or oblique stacks).
  void AddInputVolumeNode(vtkMRMLVolumeNode* node);
  /// That volume alone; null: none.
  void SetInputVolumeNode(vtkMRMLVolumeNode* node);
  void RemoveInputVolumeNode(vtkMRMLVolumeNode* node);
  void RemoveAllInputVolumeNodes();
  int GetNumberOfInputVolumeNodes();
  vtkMRMLVolumeNode* GetInputVolumeNode(int index = 0);
  ///@}

  ///@{
  /// Of one input. Slice thickness in mm; 0 (default): as DICOM or a BIDS file says, else the distance
  /// between slices.
  void SetInputSliceThickness(vtkMRMLNode* input, double thickness);
  double GetInputSliceThickness(vtkMRMLNode* input);
  /// How a slice averages across its thickness; BoxProfile by default.
  void SetInputSliceProfile(vtkMRMLNode* input, int profile);
  int GetInputSliceProfile(vtkMRMLNode* input);
  /// The index axis that counts the slices: 0, 1, 2; Automatic (default): the one with clearly the coarsest
  /// spacing, else 2 (K).
  void SetInputSliceAxis(vtkMRMLNode* input, int axis);
  int GetInputSliceAxis(vtkMRMLNode* input);
  /// A mask of its own, which moves with it where scans are aligned; null (default): GetMaskNode().
  void SetInputMaskNode(vtkMRMLNode* input, vtkMRMLNode* mask);
  vtkMRMLNode* GetInputMaskNode(vtkMRMLNode* input);
  /// Whether one was set and not unset since; its node may have left the scene.
  bool HasInputMask(vtkMRMLNode* input);
  /// Where its slices lie, as of a tracked ultrasound probe: a sequence of linear transforms, one per slice,
  /// rigid, RAS mm, each applied to where the volume puts the slice in the world; null (default): there.
  void SetInputSlicePosesNode(vtkMRMLNode* input, vtkMRMLNode* sequence);
  vtkMRMLNode* GetInputSlicePosesNode(vtkMRMLNode* input);
  /// As HasInputMask().
  bool HasInputSlicePoses(vtkMRMLNode* input);
  ///@}

  ///@{
  /// Only voxels inside are fitted: a labelmap volume (not 0 is inside) or a segmentation (all segments, or
  /// the one named by MaskSegmentID). Null: no mask. It applies to all inputs without one of their own; if
  /// any input has a mask, all must have one.
  void SetMaskNode(vtkMRMLNode* node);
  vtkMRMLNode* GetMaskNode();
  vtkSetMacro(MaskSegmentID, const std::string&);
  vtkGetMacro(MaskSegmentID, std::string);
  /// A markups ROI: only what it contains is fitted and output. Null: everything.
  void SetROINode(vtkMRMLNode* node);
  vtkMRMLNode* GetROINode();
  ///@}

  ///@{
  /// The output grid.
  vtkSetClampMacro(OutputGrid, int, AutomaticGrid, ReferenceGrid);
  vtkGetMacro(OutputGrid, int);
  vtkSetMacro(OutputSpacing, double); // mm
  vtkGetMacro(OutputSpacing, double);
  void SetReferenceVolumeNode(vtkMRMLVolumeNode* node);
  vtkMRMLVolumeNode* GetReferenceVolumeNode();
  ///@}

  ///@{
  /// Nodes to write to; null (default): new ones each time. Never an input.
  void SetOutputVolumeNode(vtkMRMLScalarVolumeNode* node);
  vtkMRMLScalarVolumeNode* GetOutputVolumeNode();
  void SetOutputModelNode(vtkMRMLInnerGSModelNode* node);
  vtkMRMLInnerGSModelNode* GetOutputModelNode();
  void SetQualityTableNode(vtkMRMLTableNode* node);
  vtkMRMLTableNode* GetQualityTableNode();
  void SetOutputUncertaintyNode(vtkMRMLScalarVolumeNode* node);
  vtkMRMLScalarVolumeNode* GetOutputUncertaintyNode();
  /// What the last reconstruction made or wrote to.
  vtkMRMLScalarVolumeNode* GetResultVolumeNode();
  vtkMRMLInnerGSModelNode* GetResultModelNode();
  vtkMRMLTableNode* GetResultTableNode();
  vtkMRMLScalarVolumeNode* GetResultUncertaintyNode();
  vtkMRMLTableNode* GetResultSliceTableNode();
  ///@}

  ///@{
  /// Settings: any of them by its name in Docs/settings.md as text, the usual ones as numbers too.
  vtkInnerGSSettingsMacro();
  vtkInnerGSSettingMacro(NumberOfThreads, threads, int);
  vtkInnerGSTextSettingMacro(Device, device);
  vtkInnerGSTextSettingMacro(InstructionSet, instructionSet);
#ifndef __VTK_WRAP__
  const innergs::Settings& GetSettings() const;
  void SetSettings(const innergs::Settings& settings);
#endif
  ///@}

  ///@{
  /// Share of each input's slices held out from a second fit, to report the quality on them; 0 (default) to
  /// 0.5.
  vtkSetMacro(HeldOutFraction, double);
  vtkGetMacro(HeldOutFraction, double);
  /// Also estimate how far the volume may be off: a volume node of standard deviations. Off by default.
  vtkSetMacro(EstimateUncertainty, bool);
  vtkGetMacro(EstimateUncertainty, bool);
  vtkBooleanMacro(EstimateUncertainty, bool);
  /// Also judge the settings on the first input by protocol H: keep every QualityGap-th slice (0,
  /// default: 2nd or 4th by its spacing), score the others beside linear, cubic and Lanczos interpolation, in
  /// a table node. Off by default.
  vtkSetMacro(EvaluateQuality, bool);
  vtkGetMacro(EvaluateQuality, bool);
  vtkBooleanMacro(EvaluateQuality, bool);
  vtkSetClampMacro(QualityGap, int, 0, 64);
  vtkGetMacro(QualityGap, int);
  ///@}

  /// A model file to resume, UTF-8: with the same inputs and settings, the result is bit-identical; with
  /// others, its Gaussians are the start. A finished reconstruction empties it. "" (default): none.
  vtkSetMacro(ResumeFileName, const std::string&);
  vtkGetMacro(ResumeFileName, std::string);

  /// Restores the defaults of all settings; inputs, region and outputs stay.
  void ResetSettings();

  /// The roles of its references to nodes.
#define vtkInnerGSReferenceRoleMacro(Name, role)                                                             \
  static const char* Get##Name##ReferenceRole() {                                                            \
    return role;                                                                                             \
  }
  vtkInnerGSReferenceRoleMacro(InputVolume, "inputVolume");
  vtkInnerGSReferenceRoleMacro(Mask, "mask");
  vtkInnerGSReferenceRoleMacro(InputMask, "inputMask");
  vtkInnerGSReferenceRoleMacro(InputSlicePoses, "inputSlicePoses");
  vtkInnerGSReferenceRoleMacro(ROI, "roi");
  vtkInnerGSReferenceRoleMacro(ReferenceVolume, "referenceVolume");
  vtkInnerGSReferenceRoleMacro(OutputVolume, "outputVolume");
  vtkInnerGSReferenceRoleMacro(OutputModel, "outputModel");
  vtkInnerGSReferenceRoleMacro(QualityTable, "qualityTable");
  vtkInnerGSReferenceRoleMacro(OutputUncertainty, "outputUncertainty");
  vtkInnerGSReferenceRoleMacro(ResultUncertainty, "resultUncertainty");
  vtkInnerGSReferenceRoleMacro(ResultVolume, "resultVolume");
  vtkInnerGSReferenceRoleMacro(ResultModel, "resultModel");
  vtkInnerGSReferenceRoleMacro(ResultTable, "resultTable");
  vtkInnerGSReferenceRoleMacro(ResultSliceTable, "resultSliceTable");
#undef vtkInnerGSReferenceRoleMacro

protected:
  vtkMRMLInnerGSParameterNode();
  ~vtkMRMLInnerGSParameterNode() override;
  vtkMRMLInnerGSParameterNode(const vtkMRMLInnerGSParameterNode&);
  void operator=(const vtkMRMLInnerGSParameterNode&);

  /// "id thickness profile axis mask poses;..." ("-": none; both may be missing) of the inputs that differ
  /// from the defaults.
  std::string GetInputSettings();
  void SetInputSettings(const std::string& text);
  void SetReference(const char* role, vtkMRMLNode* node);
#ifndef __VTK_WRAP__
  void SetSettingNumber(const char* name, double number);
  double GetSettingNumber(const char* name);
#endif

  std::string MaskSegmentID, ResumeFileName;
  int OutputGrid = AutomaticGrid;
  double OutputSpacing = 1;
  double HeldOutFraction = 0;
  bool EstimateUncertainty = false, EvaluateQuality = false;
  int QualityGap = 0;

private:
#ifndef __VTK_WRAP__
  std::unique_ptr<innergs::Settings> Choices;
  struct StackSettings {
    double Thickness = 0;
    int Profile = BoxProfile, Axis = Automatic;
    std::string Mask, Poses; // IDs of their nodes
  };
  /// The node's settings; a fresh entry is made only to change it.
  StackSettings StackOf(vtkMRMLNode* input) const;
  void SetInputNode(vtkMRMLNode* input, std::string StackSettings::*which, vtkMRMLNode* node);
  vtkMRMLNode* GetInputNode(vtkMRMLNode* input, std::string StackSettings::*which);
  std::map<std::string, StackSettings> Stacks; // by node ID
#endif
};

#endif
