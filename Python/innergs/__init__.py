"""Reconstruct medical image slices into a continuous volume of 3D Gaussians.

In Slicer's Python console, in a notebook or a script with slicer-core:

    import innergs
    result = innergs.reconstruct(volumeNode, spacing=1.0)     # waits; creates new nodes next to the input
    result.volume, result.model                               # a volume node, a model node
    innergs.query(result.model, [[0, 0, 0], [10, -5, 20]])     # values at RAS points
    innergs.plane(result.model, matrix, size=512)              # any oblique plane as a volume node

    innergs.learn(result.model, segmentationNode)              # once: segments to find by name
    innergs.segment(result.model, "left kidney")               # a segmentation node

    job = innergs.start([axial, sagittal], held_out=0.1)       # in the background
    job.progress, job.description, job.device
    job.cancel()
    job.result()                                               # waits

    moving = innergs.reconstruct_moving(sequenceNode)          # a dynamic scan: a continuous volume in space and time
    innergs.set_time(moving.model, 1.25)                       # s; planes and values then show that moment

Everything here is a thin front end of vtkSlicerInnerGSLogic (innergs.logic()). What goes wrong raises innergs.Error with a
sentence that says what to do; inputs are never changed.
"""

from ._jobs import Estimate, Job, Result, cancel, estimate, reconstruct, running, start
from ._moving import MovingJob, MovingResult, frames, motion, reconstruct_moving, set_time, start_moving
from ._parameters import parameters, slice_poses
from ._queries import follow, gaussians, load, plane, query, resample, save, slice_transforms, stop_following
from ._scene import Cancelled, Error, logic
from ._segments import Found, find, learn, score, segment

__all__ = ["Cancelled", "Error", "Estimate", "Found", "Job", "MovingJob", "MovingResult", "Result", "cancel", "estimate",
           "find", "follow", "frames", "gaussians", "learn", "load", "logic", "motion", "parameters", "plane", "query",
           "reconstruct", "reconstruct_moving", "resample", "running", "save", "score", "segment", "set_time", "slice_poses",
           "slice_transforms", "start", "start_moving", "stop_following"]
