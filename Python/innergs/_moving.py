"""Dynamic scans: continuous volumes in space and time."""

from __future__ import annotations

import collections
import os

from ._jobs import Job
from ._parameters import apply_settings
from ._scene import _classes, call, checked, logic_of, quiet

MovingResult = collections.namedtuple("MovingResult", "model frames browser table training_psnr notes")
MovingResult.__doc__ = """The result for a dynamic scan: nodes (table: None unless quality was judged), PSNR in dB on the fitted frames,
and sentences that the user should read, with why the model is of its kind."""


class MovingJob(Job):
    """The reconstruction of a dynamic scan in the background."""

    @property
    def recovery_file(self):
        """The model file to resume from, of a job that was stopped; else ""."""
        return self._current().GetRecoveryFile()

    def preview(self, seconds, output=None):
        """While it is fitted: the model so far at a time in s, as a volume node; None before there is one."""
        if self._job.GetPreviewModel() is None:
            return None
        with quiet(self._logic):
            return checked(self._logic, self._logic.PreviewFrame(self._job, float(seconds), output))

    def result(self, timeout=None):
        """Waits (at most timeout seconds) and returns the MovingResult. Raises Error, Cancelled, or TimeoutError."""
        plain = super().result(timeout)
        job = self._job
        return MovingResult(plain.model, job.GetSequenceNode(), job.GetBrowserNode(), plain.table, plain.training_psnr,
                            plain.warnings)


def _times(times):
    if times is None:
        return None
    from vtkmodules.vtkCommonCore import vtkDoubleArray

    array = vtkDoubleArray()
    for time in times:
        array.InsertNextValue(float(time))
    return array


def start_moving(sequence, *, interval=0.0, kind="auto", times=None, rate=0.0, quality=True, slice_times=None,
                 resume="", keep=False, progress=None, preview=None, **settings):
    """Starts the reconstruction of a dynamic scan in the background and returns a MovingJob. Arguments as in
    reconstruct_moving()."""
    owner = logic_of(sequence)
    request = _classes()[2].vtkSlicerInnerGSDynamicRequest()
    request.SetSeries(sequence)
    request.SetInterval(interval)
    apply_settings(request, dict(settings, kind=None if kind == "auto" else kind))
    request.SetTimes(_times(times))
    request.SetRate(rate)
    if isinstance(slice_times, (str, os.PathLike)):
        request.SetSliceTimingFileName(os.fspath(slice_times))
    else:
        request.SetSliceTimes(_times(slice_times))
    request.SetEvaluateQuality(quality)
    request.SetResumeFileName(str(resume))
    request.SetKeepWhenCancelled(keep)
    with quiet(owner):
        job = checked(owner, owner.StartDynamicReconstruction(request))
    return MovingJob(owner, job, None, progress, preview)


def reconstruct_moving(sequence, **choices):
    """Reconstructs a dynamic scan, a sequence node of scalar volumes, and waits. Returns a MovingResult with new nodes.

    interval     seconds from one frame to the next, if the sequence's index is not a time
    kind         what changes with time: "motion", "intensity" (fMRI), "network" or "auto" (default): which of the first
                 two predicts held-out frames better
    times, rate  the frames to make: at these times in s, or this many per second; by default at the sequence's own times
    quality      judge by a second fit, on frames that it does not see, next to linear interpolation (default True)
    slice_times  seconds after a frame's time at which each of its slices was acquired, one per slice along K, or a file
                 with them (BIDS's .json, or text); by default what the sequence says (attribute InnerGS.SliceTiming)
                 or the BIDS file beside the one that it was read from. Used by kind "intensity"
    resume       a model file to resume from, of a stopped fit of the same sequence and settings
    keep         keep the state of a cancelled fit in the recovery folder; MovingJob.recovery_file then names the file
    progress     called with the job from time to time
    preview      called with the job when the model so far is new: job.preview(seconds)
    any setting of dynamic scans (Docs/settings.md): knots, rounds, node_distance, gaussians, seed,
                 threads, device ("auto", "cpu", "cuda", "cuda:N") ...
    """
    return start_moving(sequence, **choices).result()


def set_time(model, seconds):
    """Shows a dynamic model at a time: planes, followed views and values are those of that moment from then on."""
    model.SetTime(float(seconds))


def frames(model, times=None, output=None):
    """A dynamic model's frames at times in s (None: those it was fitted to) as a sequence node with a browser."""
    return call("CreateFrames", model, _times(times), output)


def motion(model, times=None, start=None, output=None):
    """A dynamic model's motion from a time (s; None: the middle frame's) as a sequence of grid transforms."""
    return call("CreateMotion", model, _times(times), float("nan") if start is None else float(start), output)
