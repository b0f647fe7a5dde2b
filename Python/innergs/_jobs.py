"""Reconstructions, waiting and in the background."""

from __future__ import annotations

import collections

from ._parameters import temporary
from ._scene import Cancelled, Error, logic, logic_of, quiet

Result = collections.namedtuple("Result", "volume model table training_psnr held_out_psnr warnings uncertainty coverage slices prediction "
                                "profile measured")
Result.__doc__ = """The result of a reconstruction: nodes (table: None unless quality was requested), PSNR in dB on the fitted samples
and, for a second fit, on the slices held out from it (NaN without one), sentences that the user should read, and with
uncertainty=True a volume node of standard deviations (else None), the share of held-out voxels inside their 90 % intervals,
and measured, a labelmap node that is 1 where some slice measured the tissue (else None).
slices: of several scans, a table node of where every slice was found to lie (slice_transforms() makes transforms of it), or
None where they were not moved. prediction, profile: sentences on what was put between the slices and on how thick they look,
or ""."""


class Job:
    """A reconstruction in the background. Without an application to deliver events, using the job delivers them."""

    def __init__(self, owner, job, node=None, progress=None, preview=None):
        self._logic, self._job, self._node = owner, job, node
        self._tags = []
        for event, callback in ((owner.JobProgressEvent, progress), (owner.JobPreviewEvent, preview)):
            if callback:
                self._observe(event, lambda job, callback=callback: callback(self))
        for event in (owner.JobFinishedEvent, owner.JobFailedEvent, owner.JobCancelledEvent):
            self._observe(event, lambda job: self._release())

    def _observe(self, event, call):
        from vtkmodules.vtkCommonCore import VTK_OBJECT

        def on_event(caller, name, job):
            if job is self._job:
                call(job)

        on_event.CallDataType = VTK_OBJECT
        self._tags.append(self._logic.AddObserver(event, on_event))

    def _release(self):
        for tag in self._tags:
            self._logic.RemoveObserver(tag)
        self._tags = []
        if self._node is not None and self._node.GetScene() is not None:
            self._node.GetScene().RemoveNode(self._node)
        self._node = None

    def _current(self):
        self._logic.IsRunning()
        if self._job.IsDone():
            self._release()  # no event arrives if the scene or the logic is gone
        return self._job

    @property
    def running(self):
        """Queued or running."""
        return not self._current().IsDone()

    @property
    def progress(self):
        """0 to 1."""
        return self._current().GetProgress()

    @property
    def description(self):
        """One line: phase, iterations, PSNR, seconds left."""
        return self._current().GetDescription()

    @property
    def psnr(self):
        """dB on the fitted samples so far."""
        return self._current().GetTrainingPSNR()

    @property
    def device(self):
        """Where the fit runs and why, as a sentence; "" until known."""
        return self._current().GetDeviceNote()

    @property
    def preview(self):
        """The last preview as (vtkImageData, IJK to RAS vtkMatrix4x4), or None."""
        job = self._current()
        return (job.GetPreviewImage(), job.GetPreviewIJKToRASMatrix()) if job.GetPreviewImage() else None

    def cancel(self):
        """Ends it within 200 ms and changes no node, unless the fit was complete and only its quality being judged."""
        self._logic.Cancel(self._job)

    def result(self, timeout=None):
        """Waits (at most timeout seconds) and returns the Result. Raises Error, Cancelled, or TimeoutError."""
        import time

        end = None if timeout is None else time.monotonic() + timeout
        try:
            with quiet(self._logic):
                while not self._job.IsDone():
                    if end is not None and time.monotonic() >= end:
                        raise TimeoutError("The reconstruction is still running.")
                    self._logic.WaitForJob(self._job, 0.1)  # short, so that Ctrl-C gets through
        except KeyboardInterrupt:
            self.cancel()
            raise
        job = self._job
        if job.GetState() == job.Failed:
            raise Error(job.GetErrorMessage(), job.GetErrorCode())
        if job.GetState() == job.Cancelled:
            raise Cancelled("The reconstruction was cancelled.")
        warnings = [job.GetWarning(n) for n in range(job.GetNumberOfWarnings())]
        return Result(job.GetVolumeNode(), job.GetModelNode(), job.GetTableNode(), job.GetTrainingPSNR(),
                      job.GetHeldOutPSNR(), warnings, job.GetUncertaintyNode(), job.GetUncertaintyCoverage(),
                      job.GetSliceTableNode(), job.GetPredictionNote(), job.GetProfileNote(), job.GetMeasuredNode())


def _node_of(volumes, spacing, parameter_node, choices):
    if parameter_node is None:
        return temporary(volumes, spacing, **choices)
    if volumes is not None or spacing is not None or choices:
        raise Error("Give a parameter node or volumes with choices, not both.")
    return parameter_node


def start(volumes, spacing=None, *, progress=None, preview=None, parameter_node=None, **choices):
    """Starts a reconstruction in the background and returns a Job; jobs run one after the other.

    progress, preview: called on the main thread with the Job. parameter_node: a vtkMRMLInnerGSParameterNode with all
    choices, instead of them. Other arguments as in reconstruct().
    """
    node = _node_of(volumes, spacing, parameter_node, choices)
    own = None if node is parameter_node else node
    owner = logic_of(node)
    with quiet(owner):
        job = owner.StartReconstruction(node)
    if job is None:
        error = Error(owner.GetLastError(), owner.GetLastErrorCode())
        if own is not None:
            own.GetScene().RemoveNode(own)
        raise error
    return Job(owner, job, own, progress, preview)


def reconstruct(volumes, spacing=None, *, progress=None, preview=None, parameter_node=None, **choices):
    """Reconstructs one volume node, or several of the same patient, and waits. Returns a Result with new nodes.

    spacing      output voxel size in mm, isotropic; by default the finest spacing of the inputs
    reference    a volume node whose voxel grid the output uses; input_grid=True: the first input's
    mask         a labelmap or segmentation node, or a list of one per volume: only what is inside is fitted (segment:
                 one segment's ID), and the model has values only there and up to one slice distance beyond; fill: its
                 value elsewhere, 0
    roi          a markups ROI node: only that box is fitted and output
    thickness    slice thickness in mm, one number or one per volume; by default from DICOM in
                 Slicer, else the distance between slices
    profile      "box" (default), "gaussian" or "point": how a slice averages across its thickness
    axis         the index (0, 1, 2) that counts the slices, one or one per volume; by default one with clearly the
                 coarsest spacing, else 2
    slice_poses  where slices lie that do not lie in a block, as of a tracked ultrasound probe: the sequence node that
                 slice_poses() makes, or a list with one, or None, per volume
    held_out     share of slices (0 to 0.5) held out from a second fit, which takes about as long again, to report
                 held_out_psnr; the result is fitted to all slices
    uncertainty  also estimate how far the volume may be off, as a volume node of standard deviations; takes this second fit
                 (of a fifth of the slices where held_out is 0) and two small ones
    quality      also score the settings by protocol H (keep every quality_gap-th slice; 0: the 2nd of thick
                 slices, the 4th of thin ones) in a table node
    output, output_model  nodes to write to instead of new ones
    progress, preview     called with the Job from time to time
    preset       "fast", "balanced" (default), "best" or "paper"; further settings by their names in Docs/settings.md,
                 huber_delta for huberDelta: gaussians, iterations, seed, device ("auto", "cpu", "cuda", "cuda:N"), ...;
                 None: chosen from preset and data
    """
    return start(volumes, spacing, progress=progress, preview=preview, parameter_node=parameter_node, **choices).result()


Estimate = collections.namedtuple("Estimate", "seconds bytes device")
Estimate.__doc__ = """The cost of a reconstruction: rough seconds (0: unknown), bytes of memory beyond its inputs, and where it will run
and why, as a sentence."""


def estimate(volumes, spacing=None, *, parameter_node=None, **choices):
    """Estimates the cost of reconstruct() with these arguments, without reading voxels."""
    node = _node_of(volumes, spacing, parameter_node, choices)
    owner = logic_of(node)
    try:
        refused = owner.CheckParameters(node)
        if refused:
            raise Error(refused)
        return Estimate(owner.EstimateSeconds(node), owner.EstimateMemory(node), owner.DescribeDevice(node))
    finally:
        if node is not parameter_node:
            node.GetScene().RemoveNode(node)


def running(scene=None):
    """Whether a reconstruction is queued or running."""
    return bool(logic(scene).IsRunning())


def cancel(scene=None):
    """Cancels all reconstructions."""
    logic(scene).Cancel()
