"""Reconstruct medical image slices into a continuous volume of 3D Gaussians.

In Slicer's Python console, in a notebook or a script with slicer-core:

    import innergs
    result = innergs.reconstruct(volumeNode, spacing=1.0)     # blocks; new nodes beside the input
    result.volume, result.model                               # a volume node, a model node
    innergs.query(result.model, [[0, 0, 0], [10, -5, 20]])     # values at RAS points
    innergs.plane(result.model, matrix, size=512)              # any oblique plane as a volume node

    innergs.learn(result.model, segmentationNode)              # once: segments to be asked for by their names
    innergs.segment(result.model, "left kidney")               # a segmentation node

    job = innergs.start([axial, sagittal], held_out=0.1)       # in the background
    job.progress, job.description, job.device
    job.cancel()
    job.result()                                               # waits

Everything here is a thin front of vtkSlicerInnerGSLogic (innergs.logic()). What goes wrong raises innergs.Error with a
sentence that says what to do; inputs are never changed.
"""

from ._jobs import Estimate, Job, Result, cancel, estimate, reconstruct, running, start
from ._parameters import parameters
from ._queries import follow, gaussians, load, plane, query, resample, save, stop_following
from ._scene import Cancelled, Error, logic
from ._segments import Found, find, learn, segment

__all__ = ["Cancelled", "Error", "Estimate", "Found", "Job", "Result", "cancel", "estimate", "find", "follow", "gaussians",
           "learn", "load", "logic", "parameters", "plane", "query", "reconstruct", "resample", "running", "save", "segment",
           "start", "stop_following"]
