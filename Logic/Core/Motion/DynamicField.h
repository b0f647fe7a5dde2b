#pragma once
#include "Core/Acquisition/Observation.h"
#include "Core/Base/Parallel.h"
#include "Core/Model/GaussianField.h"
#include "Core/Motion/DeformationNetwork.h"
#include "Core/Motion/MotionGrid.h"
#include "Core/Motion/TimeSeries.h"
#include "Core/Motion/TimeSpline.h"
#include "Core/Settings/DynamicKind.h"

namespace innergs {

/// "motion", "intensity", "network": in files, reports and options.
const char* dynamicKindName(DynamicKind kind);

/// Nothing for any other word.
std::optional<DynamicKind> dynamicKindNamed(const std::string& name);

/// A continuous volume in space and time: canonical Gaussians and how they move or change. At every time it
/// is an ordinary field.
struct DynamicField {
  DynamicKind kind = DynamicKind::Motion;
  GaussianField canonical;
  std::vector<double> times; // of the frames that were fitted, s, increasing

  // Motion: mean + u(anchor, t) + r(t), rotated by the motion grid's rotation at the anchor.
  MotionGrid motionGrid;
  TimeSpline motion;          // of the grid's values
  std::vector<float> nodes;   // [coefficient][node][6]
  std::vector<float> anchors; // [Gaussian][3]: where each is bound to the grid or network, mm, model frame
  TimeSpline own;             // of each Gaussian's own displacement
  std::vector<float> ownPath; // [coefficient][Gaussian][3], mm; empty: none

  // Intensity: what is added to each Gaussian's.
  TimeSpline change;
  std::vector<float> changes; // [coefficient][Gaussian]

  // Network: what is added to each Gaussian's parameters, a function of its anchor and the time.
  DeformationNetwork network;

  std::int64_t size() const { return canonical.size(); }
};

/// Coefficients over time per value: of the spline, or of the network's planes.
int coefficientsInTime(const DynamicField& field);

/// A field without Gaussians over a series' grid and times.
DynamicField emptyField(DynamicKind kind, const TimeSeries& series, const IntensityMap& map, double cutoff);

/// Throws Error(FileFormat) when a dynamic field cannot be evaluated (arrays of other sizes, values that are
/// not finite, a canonical field that cannot be rendered).
void checkDynamicField(const DynamicField& field);

/// The field at a time (s); before the first and after the last fitted frame, the field at that frame's time.
GaussianField fieldAt(const DynamicField& field, double time);
/// The same into `out`, a copy of the canonical field, of which it writes only the Gaussians.
void poseAt(const DynamicField& field, double time, GaussianField& out, ThreadPool& pool);

struct RenderOptions;

/// The frame whose acquisition starts at a time (s), on the series' grid, each slice at its own time.
/// Values as in Volume. Throws Error(Cancelled).
std::vector<float> acquiredFrame(const DynamicField& field, const TimeSeries& series, double time,
                                 const RenderOptions& options);

/// Writes out.gaussians: the canonical ones plus `changes`, 16 floats each in the order of struct Gaussian.
void addChanges(const GaussianField& canonical, std::span<const float> changes, GaussianField& out,
                ThreadPool& pool);

} // namespace innergs
