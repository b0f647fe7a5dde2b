#ifndef vtkInnerGSLearnSegments_h
#define vtkInnerGSLearnSegments_h

#include "vtkInnerGSAlgorithm.h"

class vtkDataArray;
class vtkImageData;
class vtkInnerGSModel;
class vtkMatrix4x4;

/// Teaches a model (input) segments from one of three teachers, a labelmap, a feature volume with the
/// embeddings of texts, or a network: the output is the same model, whose Gaussians then have features that
/// vtkInnerGSSegment decodes on any grid. The labelmap may have a grid of its own, and labels on only some
/// slices.
class VTKINNERGS_EXPORT vtkInnerGSLearnSegments : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSLearnSegments* New();
  vtkTypeMacro(vtkInnerGSLearnSegments, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// Labels from 0 (background) to 65535, one component of any type; ijkToRAS is copied, null: from the
  /// image's origin, spacing and direction.
  void SetLabels(vtkImageData* labels, vtkMatrix4x4* ijkToRAS = nullptr);
  /// What a label is called, e.g. "liver", "Left kidney"; labels without a name become "Segment 3". At least
  /// one is needed. "": none.
  void SetSegmentName(int label, const std::string& name);
  std::string GetSegmentName(int label);
  void RemoveAllSegmentNames();
  ///@}

  ///@{
  /// On: slices without any label between labelled ones count as unlabelled and follow the scan. Off
  /// (default): as background.
  vtkSetMacro(SparseSlices, bool);
  vtkGetMacro(SparseSlices, bool);
  vtkBooleanMacro(SparseSlices, bool);
  ///@}

  ///@{
  /// Instead of labels: a feature volume with several values per voxel, and embeddings of texts by the model
  /// that made it, with as many values each ("background": everything else). An empty or null embedding
  /// removes the text.
  void SetFeatures(vtkImageData* features, vtkMatrix4x4* ijkToRAS = nullptr);
  void SetTextEmbedding(const std::string& text, vtkDataArray* values);
  int GetNumberOfTextEmbeddings();
  void RemoveAllTextEmbeddings();
  ///@}

  ///@{
  /// Or: an ONNX file that OpenVINO runs on the model's own image: 1 × 1 × K × J × I (or J × I) in; out, with
  /// text embeddings, features, otherwise a channel for the background and one per segment, named by
  /// SetSegmentName().
  /// "" (default): none.
  vtkSetMacro(NetworkFile, const std::string&);
  vtkGetMacro(NetworkFile, std::string);
  /// Intensities that become 0 and 1 for the network; equal (default): mean 0 and standard deviation 1
  /// instead.
  vtkSetVector2Macro(NetworkRange, double);
  vtkGetVector2Macro(NetworkRange, double);
  /// Voxel size that the network expects, mm; 0 (default): as in the fit.
  vtkSetMacro(NetworkSpacing, double);
  vtkGetMacro(NetworkSpacing, double);
  ///@}

  ///@{
  /// Channels of a Gaussian's latent: 8, 16 (default) or 32.
  vtkSetMacro(NumberOfChannels, int);
  vtkGetMacro(NumberOfChannels, int);
  /// For labelmaps only; 0 (default): as many as the labels need.
  vtkSetMacro(NumberOfIterations, int);
  vtkGetMacro(NumberOfIterations, int);
  ///@}

  vtkInnerGSModel* GetOutput();

protected:
  vtkInnerGSLearnSegments();
  ~vtkInnerGSLearnSegments() override;
  int FillInputPortInformation(int port, vtkInformation* information) override;
  int FillOutputPortInformation(int port, vtkInformation* information) override;
#ifndef __VTK_WRAP__
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
#endif

  bool SparseSlices = false;
  int NumberOfChannels = 16, NumberOfIterations = 0;
  std::string NetworkFile;
  double NetworkRange[2] = {0, 0}, NetworkSpacing = 0;

private:
  vtkInnerGSLearnSegments(const vtkInnerGSLearnSegments&) = delete;
  void operator=(const vtkInnerGSLearnSegments&) = delete;

  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
