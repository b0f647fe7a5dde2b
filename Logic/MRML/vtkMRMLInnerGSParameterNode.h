#ifndef vtkMRMLInnerGSParameterNode_h
#define vtkMRMLInnerGSParameterNode_h

#include "vtkMRMLNode.h"
#include "vtkSlicerInnerGSModuleMRMLExport.h"

#include <map>    // std::map
#include <string> // returned

class vtkMRMLInnerGSModelNode;
class vtkMRMLScalarVolumeNode;
class vtkMRMLTableNode;
class vtkMRMLVolumeNode;

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

  enum Presets { Fast, Balanced, Best, Paper };
  enum { Automatic = -1 }; // chosen by the program from preset and data
  enum Blendings { Normalised, Additive, Alpha };
  enum Losses { L1, L2, Huber };
  enum Initialisations { Adaptive, Grid };
  enum Schedules { Exponential, Plateau };
  enum Selections { ExactSelection, Method1, Method2 };
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
  /// Of one input. Slice thickness in mm; 0 (default): as DICOM says where it is known, else the distance
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
  ///@}

  ///@{
  /// Only voxels inside are fitted: a labelmap volume (not 0 is inside) or a segmentation (all segments, or
  /// the one named by MaskSegmentID). Null: no mask.
  void SetMaskNode(vtkMRMLNode* node);
  vtkMRMLNode* GetMaskNode();
  vtkSetMacro(MaskSegmentID, const std::string&);
  vtkGetMacro(MaskSegmentID, std::string);
  vtkSetMacro(FillValue, double); // scanner units: the model's value outside the mask; 0 by default
  vtkGetMacro(FillValue, double);
  /// A markups ROI: only what it contains is fitted and put out. Null: everything.
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
  /// What the last reconstruction made or wrote to.
  vtkMRMLScalarVolumeNode* GetResultVolumeNode();
  vtkMRMLInnerGSModelNode* GetResultModelNode();
  vtkMRMLTableNode* GetResultTableNode();
  ///@}

  ///@{
  /// Settings. Automatic (-1), or 0 for counts, stands for "chosen from preset and data".
  vtkSetClampMacro(Preset, int, Fast, Paper);
  vtkGetMacro(Preset, int);
  vtkSetClampMacro(Blending, int, Automatic, Alpha);
  vtkGetMacro(Blending, int);
  vtkSetClampMacro(Selection, int, ExactSelection, Method2); // of the pixels a Gaussian is evaluated on
  vtkGetMacro(Selection, int);
  vtkSetClampMacro(LinearIntensity, int, -1, 1);
  vtkGetMacro(LinearIntensity, int);
  vtkSetClampMacro(Initialisation, int, Automatic, Grid);
  vtkGetMacro(Initialisation, int);
  vtkSetClampMacro(Loss, int, Automatic, Huber);
  vtkGetMacro(Loss, int);
  vtkSetMacro(HuberDelta, double); // fraction of the intensity range
  vtkGetMacro(HuberDelta, double);
  vtkSetMacro(SSIMWeight, double); // below 0 (default): chosen
  vtkGetMacro(SSIMWeight, double);
  vtkSetMacro(NumberOfGaussians, int);
  vtkGetMacro(NumberOfGaussians, int);
  vtkSetMacro(NumberOfIterations, int); // iterations over the data, per member
  vtkGetMacro(NumberOfIterations, int);
  vtkSetMacro(EnsembleSize, int); // fields fitted independently and merged
  vtkGetMacro(EnsembleSize, int);
  vtkSetClampMacro(PaperStopRule, int, -1, 1);
  vtkGetMacro(PaperStopRule, int);
  vtkSetClampMacro(AllAxes, int, -1, 1); // fit the slices of one scan along all its axes
  vtkGetMacro(AllAxes, int);
  vtkSetClampMacro(Schedule, int, Automatic, Plateau); // of the learning rates
  vtkGetMacro(Schedule, int);
  vtkSetMacro(PlateauPatience, int); // Plateau: iterations without improvement before the rates fall
  vtkGetMacro(PlateauPatience, int);
  vtkSetMacro(PlateauFactor, double); // what they are multiplied by then
  vtkGetMacro(PlateauFactor, double);
  vtkSetMacro(PlateauLowest, double); // share of the first rates that they never fall below
  vtkGetMacro(PlateauLowest, double);
  vtkSetMacro(PlateauThreshold, double); // relative improvement of the loss that counts
  vtkGetMacro(PlateauThreshold, double);
  vtkSetMacro(DensifyEvery, int); // iterations; Automatic (default); 0: never
  vtkGetMacro(DensifyEvery, int);
  vtkSetMacro(MaximumNumberOfGaussians, int); // that densification may reach
  vtkGetMacro(MaximumNumberOfGaussians, int);
  vtkSetMacro(PruneOpacity, double); // densification prunes below it; below 0 (default): chosen
  vtkGetMacro(PruneOpacity, double);
  vtkSetMacro(PruneSize, double); // voxels: and above this standard deviation
  vtkGetMacro(PruneSize, double);
  vtkSetMacro(DensifyGradient, double); // Gaussians pulled harder become two, see innergs::DensifyThresholds
  vtkGetMacro(DensifyGradient, double);
  vtkSetMacro(SplitSize, double); // voxels squared: with a larger covariance they are split, else cloned
  vtkGetMacro(SplitSize, double);
  vtkSetMacro(PointWeight, double); // of the loss beside SSIM; below 0 (default): chosen
  vtkGetMacro(PointWeight, double);
  vtkSetMacro(Cutoff, double); // Mahalanobis radius of a Gaussian, 1 to 5; below 0 (default): chosen
  vtkGetMacro(Cutoff, double);
  vtkSetMacro(Beta1, double); // Adam's share of the old first moment, 0 to 1; below 0 (default): chosen
  vtkGetMacro(Beta1, double);
  vtkSetMacro(Beta2, double); // and of the second
  vtkGetMacro(Beta2, double);
  vtkSetMacro(Relocate, bool);
  vtkGetMacro(Relocate, bool);
  vtkBooleanMacro(Relocate, bool);
  vtkSetMacro(Consistency, bool); // data-consistency step after the fit
  vtkGetMacro(Consistency, bool);
  vtkBooleanMacro(Consistency, bool);
  vtkSetMacro(NumberOfThreads, int); // 0: all cores
  vtkGetMacro(NumberOfThreads, int);
  vtkSetMacro(InstructionSet, const std::string&); // "": the best that the processor has
  vtkGetMacro(InstructionSet, std::string);
  vtkSetMacro(Device, const std::string&); // "auto" (default): a GPU where it suffices; or "cpu", "cuda:N"
  vtkGetMacro(Device, std::string);
  vtkSetClampMacro(Seed, int, 0, VTK_INT_MAX); // same seed, same result, bit for bit
  vtkGetMacro(Seed, int);
  ///@}

  ///@{
  /// Share of each input's slices withheld from a second fit, to report the quality on them; 0 (default) to
  /// 0.5.
  vtkSetMacro(HeldOutFraction, double);
  vtkGetMacro(HeldOutFraction, double);
  /// Also judge the settings on the first input by protocol H: keep every QualityGap-th slice (0,
  /// default: 2nd or 4th by its spacing), score the others beside linear, cubic and Lanczos interpolation, in
  /// a table node. Off by default.
  vtkSetMacro(EvaluateQuality, bool);
  vtkGetMacro(EvaluateQuality, bool);
  vtkBooleanMacro(EvaluateQuality, bool);
  vtkSetClampMacro(QualityGap, int, 0, 64);
  vtkGetMacro(QualityGap, int);
  ///@}

  /// All settings as at the start; inputs, region and outputs stay.
  void ResetSettings();

  static const char* GetInputVolumeReferenceRole() { return "inputVolume"; }
  static const char* GetMaskReferenceRole() { return "mask"; }
  static const char* GetROIReferenceRole() { return "roi"; }
  static const char* GetReferenceVolumeReferenceRole() { return "referenceVolume"; }
  static const char* GetOutputVolumeReferenceRole() { return "outputVolume"; }
  static const char* GetOutputModelReferenceRole() { return "outputModel"; }
  static const char* GetQualityTableReferenceRole() { return "qualityTable"; }
  static const char* GetResultVolumeReferenceRole() { return "resultVolume"; }
  static const char* GetResultModelReferenceRole() { return "resultModel"; }
  static const char* GetResultTableReferenceRole() { return "resultTable"; }

protected:
  vtkMRMLInnerGSParameterNode();
  ~vtkMRMLInnerGSParameterNode() override;
  vtkMRMLInnerGSParameterNode(const vtkMRMLInnerGSParameterNode&);
  void operator=(const vtkMRMLInnerGSParameterNode&);

  /// "id thickness profile axis;..." of the inputs that differ from the defaults.
  std::string GetInputSettings();
  void SetInputSettings(const std::string& text);
  void SetReference(const char* role, vtkMRMLNode* node);

  std::string MaskSegmentID;
  int OutputGrid = AutomaticGrid;
  double OutputSpacing = 1;
  int Preset = Balanced, Blending = Automatic, LinearIntensity = Automatic, Initialisation = Automatic,
      Loss = Automatic;
  double HuberDelta = 0.02, SSIMWeight = Automatic;
  int NumberOfGaussians = 0, NumberOfIterations = 0, EnsembleSize = 0, PaperStopRule = Automatic;
  int AllAxes = Automatic, Schedule = Automatic, DensifyEvery = Automatic, MaximumNumberOfGaussians = 0;
  double PointWeight = Automatic;
  int Selection = ExactSelection, PlateauPatience = 10;
  double PlateauFactor = 0.5, PlateauLowest = 0.01, PlateauThreshold = 1e-4;
  double PruneOpacity = Automatic, PruneSize = 20, DensifyGradient = 1, SplitSize = 2;
  double Cutoff = Automatic, Beta1 = Automatic, Beta2 = Automatic;
  std::string Device = "auto";
  bool Relocate = true, Consistency = true;
  double FillValue = 0;
  int NumberOfThreads = 0;
  std::string InstructionSet;
  int Seed = 1;
  double HeldOutFraction = 0;
  bool EvaluateQuality = false;
  int QualityGap = 0;

private:
#ifndef __VTK_WRAP__
  struct StackSettings {
    double Thickness = 0;
    int Profile = BoxProfile, Axis = Automatic;
  };
  /// The node's settings; a fresh entry is made only to change it.
  StackSettings StackOf(vtkMRMLNode* input) const;
  std::map<std::string, StackSettings> Stacks; // by node ID
#endif
};

#endif
