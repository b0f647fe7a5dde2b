#pragma once
#include "Core/Image/Metrics.h"
#include "Core/Job/ReconstructionJob.h"

#include "Evaluation/BiasErrors.h"
#include "Evaluation/PoseErrors.h"

#include <functional>
#include <memory>
#include <string>

namespace innergs {

/// The anatomical plane of a slice.
enum class Plane { Axial, Coronal, Sagittal };
const char* planeName(Plane plane);
/// The grid axis (0, 1, 2) normal to a plane's slices; the three planes get three different axes.
int sliceAxis(const GridGeometry& geometry, Plane plane);
/// The plane of the slices that a grid axis counts.
Plane planeAcross(const GridGeometry& geometry, int axis);

struct EvaluationOptions {
  Settings settings;                                // of the Gaussians; seed and threads apply to all methods
  bool gaussians = true;                            // false: baselines only
  bool uncertainty = false;                         // also judges the Gaussians' stated uncertainty
  bool totalVariation = false;                      // protocol H: includes the slowest baseline by far
  bool keepVolumes = false;                         // keeps every method's volume (for pictures)
  double heldOutFraction = 0.05;                    // protocols P and scans
  ProgressCallback progress;                        // of the Gaussians' fit
  std::function<void(const std::string&)> onMethod; // called before each method with its name
  std::stop_token stop;                             // when stopped, throws Error(Cancelled)
  std::optional<Mask> mask; // protocol H: fits and scores inside it; without it, scores inside the body mask
};

struct PlaneScore {
  Plane plane = Plane::Axial;
  double psnr = 0, ssim = 0; // mean over the held-out slices
  double pooledPsnr = 0;     // over all voxels of the held-out slices
  std::int64_t slices = 0;
};

/// How often a stated uncertainty holds.
struct IntervalScore {
  double coverage = 0; // share of the scored voxels whose truth lies in the 90 % interval
  double own = 0;      // what the reconstruction itself says of its held-out slices
  double width = 0;    // median deviation, image units
};

struct MethodScore {
  std::string name; // gaussians, uncorrected, linear, cubic, lanczos, average, …
  double psnr = 0, ssim = 0;
  double pooledPsnr = 0; // protocol P only (in protocol H, psnr is pooled already)
  double seconds = 0;
  double cpuSeconds = 0;                  // 0: not measured (protocol P)
  std::int64_t peakMemory = 0;            // bytes, of the process until then; 0: not measured (P)
  std::vector<PlaneScore> perPlane;       // protocol P only
  std::optional<PoseErrors> poses;        // protocol stacks, of the Gaussians
  std::optional<double> ncc;              // protocol scans: normalised cross-correlation
  std::optional<BiasErrors> bias;         // protocol stacks, of the Gaussians, where they are shaded
  std::optional<IntervalScore> intervals; // with EvaluationOptions::uncertainty, of the Gaussians
  std::shared_ptr<const Volume> volume;   // with keepVolumes; on EvaluationReport::truth's grid
};

/// The result of one evaluation, with the samples that it is for.
struct EvaluationReport {
  std::string protocol; // "held-out", "paper", "stacks" or "scans"
  std::string caseName; // "keep-every-4", "thick-4", "orthogonal-2-thick-4", "withheld-5%"
  std::string samples;  // a sentence: the voxels scored
  std::string range;    // a sentence: the PSNR's peak
  double peak = 0;      // image units
  std::int64_t voxels = 0;
  DensifyCounts densified;                // by the Gaussians' fit
  std::optional<Uncertainty> uncertainty; // of the Gaussians' volume, with EvaluationOptions::uncertainty
  std::vector<MethodScore> methods;
  std::vector<std::string> notes;
  std::shared_ptr<const Volume> truth;             // with keepVolumes: the scored grid, slices along K
  std::shared_ptr<const std::vector<Stack>> input; // with keepVolumes
  std::shared_ptr<const Model> model;              // with keepVolumes: the Gaussians
};

/// What a protocol shows to a method. truth is cropped to what the input covers, with its slices (axial
/// unless the case says otherwise) along K; if they are not, the grid is permuted.
struct EvaluationInput {
  Volume truth;
  std::vector<Stack> stacks;
  std::vector<std::int64_t> testSlices;             // scored K indices (protocol H)
  std::array<std::vector<std::int64_t>, 3> heldOut; // held-out slices by grid axis of truth (protocol P)
  std::array<std::vector<std::int64_t>, 3> scored;  // those that are not constant
};

} // namespace innergs
