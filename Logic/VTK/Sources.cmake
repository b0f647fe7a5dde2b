# The classes of the VTK layer: each has a .h, wrapped for Python, and a .cxx. A separate list, so that the macros of a Slicer
# build can use it too.
set(INNERGS_VTK_CLASSES
  vtkInnerGSAlgorithm
  vtkInnerGSLearnSegments
  vtkInnerGSDynamicModel
  vtkInnerGSDynamicReconstruct
  vtkInnerGSInterpolateTime
  vtkInnerGSModel
  vtkInnerGSMotionField
  vtkInnerGSPlaneQuery
  vtkInnerGSPointQuery
  vtkInnerGSReconstruct
  vtkInnerGSResample
  vtkInnerGSSegment
  vtkInnerGSToPolyData
)
set(INNERGS_VTK_PRIVATE_SOURCES
  Geometry.cxx
  ImageVoxels.cxx
  PipelineTime.cxx
  PlaneQueue.cxx
  ReconstructInputs.cxx
  SliceTable.cxx
  UncertaintyImage.cxx
)
