#ifndef vtkInnerGSSegment_h
#define vtkInnerGSSegment_h

#include "vtkInnerGSAlgorithm.h"

class vtkImageData;
class vtkMatrix4x4;

/// Segments of a model with features (input; vtkInnerGSLearnSegments) by what a person calls them: a labelmap
/// (output, vtkImageData) with the labels 1, 2, ... of the segments that the queries ask for. The first
/// update for a grid decodes the features on all of it; the next queries on that grid take milliseconds.
class VTKINNERGS_EXPORT vtkInnerGSSegment : public vtkInnerGSAlgorithm {
public:
  static vtkInnerGSSegment* New();
  vtkTypeMacro(vtkInnerGSSegment, vtkInnerGSAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /// A structure in words: "left kidney", "hepar", or a segment's own name. A query for something that the
  /// model lacks is not an error: see GetAnswer().
  void AddQuery(const std::string& text);
  void RemoveAllQueries();
  /// Replaces all queries by this one.
  void SetQuery(const std::string& text);
  int GetNumberOfQueries();
  std::string GetQuery(int index);
  ///@}

  ///@{
  /// Voxels with at least this probability, 0 to 1; 0 (default): where the segment is the likeliest.
  vtkSetMacro(Threshold, double);
  vtkGetMacro(Threshold, double);
  /// Standard deviation in mm of a Gaussian that smooths the segments; 0 (default): none.
  vtkSetMacro(Smoothing, double);
  vtkGetMacro(Smoothing, double);
  /// Only the largest connected part of each segment. Off by default.
  vtkSetMacro(LargestOnly, bool);
  vtkGetMacro(LargestOnly, bool);
  vtkBooleanMacro(LargestOnly, bool);
  /// Keeps only connected parts of at least this many mm³; 0 by default.
  vtkSetMacro(MinimumSize, double);
  vtkGetMacro(MinimumSize, double);
  ///@}

  ///@{
  /// The grid, as in vtkInnerGSResample: mm; 0, 0, 0 (default): as in the fit.
  vtkSetVector3Macro(OutputSpacing, double);
  vtkGetVector3Macro(OutputSpacing, double);
  void SetReferenceGrid(vtkMatrix4x4* ijkToRAS, int dimensionI, int dimensionJ, int dimensionK);
  void SetReferenceImage(vtkImageData* image, vtkMatrix4x4* ijkToRAS = nullptr);
  ///@}

  /// Labels as unsigned char or, for more than 255 segments, unsigned short.
  vtkImageData* GetOutput();
  ///@{
  /// Whether to make a score too (second output, float, on the same grid): the probability, at each voxel, of
  /// what the queries ask for; for several segments, that of the likeliest. Off by default.
  vtkSetMacro(MakeScore, bool);
  vtkGetMacro(MakeScore, bool);
  vtkBooleanMacro(MakeScore, bool);
  vtkImageData* GetScore();
  ///@}
  vtkMatrix4x4* GetOutputIJKToRASMatrix();

  /// How a query was answered.
  enum Answers {
    Found,       // the leading candidates together are what was asked for: one segment
    Several,     // side or number is open: a segment of each leading candidate
    Wider,       // only segments that hold what was asked for and more: none is made
    NotInVolume, // a known structure that has no voxel here
    NoMatch,
    Similar // words that the lexicon does not know: candidates near in meaning (INNERGS_TEXT_MODEL), none
            // leads
  };
  ///@{
  /// Of the last update, per query.
  int GetAnswer(int query);             // one of Answers; NoMatch outside the range
  std::string GetAnswerText(int query); // a sentence for people
  int GetNumberOfCandidates(int query); // best first
  std::string GetCandidateName(int query, int candidate);
  double GetCandidateScore(int query, int candidate); // 0 to 1: how well the words fit
  int GetNumberOfLeadingCandidates(int query);        // those at the front that answer it together
  ///@}
  ///@{
  /// Of the last update, per segment in the order of the labels; SNOMED CT code and its meaning ("": not
  /// known), "left", "right" or "".
  int GetNumberOfSegments();
  std::string GetSegmentName(int index);
  std::string GetSegmentCode(int index);
  std::string GetSegmentMeaning(int index);
  std::string GetSegmentSide(int index);
  void GetSegmentColor(int index, double color[3]); // red, green, blue from 0 to 1
  double GetSegmentVolume(int index);               // mm³
  ///@}

protected:
  vtkInnerGSSegment();
  ~vtkInnerGSSegment() override;
#ifndef __VTK_WRAP__
  void RequestInformation(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
  void RequestData(vtkInformationVector** inputs, vtkInformationVector* outputs) override;
#endif

  double Threshold = 0, Smoothing = 0, MinimumSize = 0;
  bool LargestOnly = false, MakeScore = false;
  double OutputSpacing[3] = {0, 0, 0};

private:
  vtkInnerGSSegment(const vtkInnerGSSegment&) = delete;
  void operator=(const vtkInnerGSSegment&) = delete;

  struct Internals;
  std::unique_ptr<Internals> Work;
};

#endif
