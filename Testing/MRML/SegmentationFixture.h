#pragma once
#include "MrmlFixture.h"

#include <vtkMRMLSegmentationNode.h>

#include <vtkClosedSurfaceToBinaryLabelmapConversionRule.h>
#include <vtkOrientedImageData.h>
#include <vtkPolyData.h>
#include <vtkSegment.h>
#include <vtkSegmentation.h>
#include <vtkSegmentationConverter.h>

#include <condition_variable>
#include <mutex>
#include <set>
#include <thread>

inline const std::string kLabelmap =
    vtkSegmentationConverter::GetSegmentationBinaryLabelmapRepresentationName();
inline const std::string kSurface =
    vtkSegmentationConverter::GetSegmentationClosedSurfaceRepresentationName();

/// Slicer's own rule, which also records the threads it runs on and can be paused there.
class WatchedRule : public vtkClosedSurfaceToBinaryLabelmapConversionRule {
public:
  static WatchedRule* New();
  vtkTypeMacro(WatchedRule, vtkClosedSurfaceToBinaryLabelmapConversionRule);
  vtkSegmentationConverterRule* CreateRuleInstance() override { return WatchedRule::New(); }
  unsigned int GetConversionCost(vtkDataObject*, vtkDataObject*) override { return 1; } // before the other
  bool Convert(vtkSegment* segment) override;
  /// Returns once it runs on some thread.
  static void waitForEntry();

  static std::mutex mutex; // for the following members
  static std::set<std::thread::id> threads;
  static bool held;
  static int done; // conversions
  static std::condition_variable changed;
};

/// While it lives, Slicer converts surfaces to voxels by a WatchedRule.
class WatchedRules {
public:
  WatchedRules();
  ~WatchedRules();
  WatchedRules(const WatchedRules&) = delete;
  WatchedRules& operator=(const WatchedRules&) = delete;

private:
  vtkNew<WatchedRule> rule_;
};

/// A sphere's surface with its centre at (r, -2, 3).
vtkSmartPointer<vtkPolyData> ballSurface(double r, double radius);

/// A volume and an empty segmentation 'Organs'.
class SegmentationFixture : public MrmlFixture {
protected:
  SegmentationFixture();

  /// Balls (centre and radius in mm of the node) with the labels 1, 2, ... on one grid.
  static vtkSmartPointer<vtkOrientedImageData> balls(vtkMatrix4x4* toNode, const int extent[6], int type,
                                                     const std::vector<std::array<double, 4>>& balls);
  void addSegment(const std::string& id, vtkDataObject* data, int label = 1);
  void addSurface(const std::string& id, double r, double radius);
  /// Two on one grid, one on a finer, rotated one, one without a voxel, one empty.
  void addLabelmaps();

  WatchedRules rules;
  vtkMRMLScalarVolumeNode* input = nullptr;
  vtkMRMLSegmentationNode* node = nullptr;
  vtkSegmentation* segments = nullptr;
};
