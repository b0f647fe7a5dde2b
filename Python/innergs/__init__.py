"""Reconstruct medical image slices into a continuous volume of 3D Gaussians.

In Slicer's Python console, in a notebook or a script with slicer-core:

    import innergs
    result = innergs.reconstruct(volumeNode, spacing=1.0)     # blocks; new nodes beside the input
    result.volume, result.model                               # a volume node, a model node
    innergs.query(result.model, [[0, 0, 0], [10, -5, 20]])     # values at RAS points
    innergs.plane(result.model, matrix, size=512)              # any oblique plane as a volume node

    job = innergs.start([axial, sagittal], held_out=0.1)       # in the background
    job.progress, job.description
    job.cancel()
    job.result()                                               # waits

Everything here is a thin front of vtkSlicerInnerGSLogic (innergs.logic()). What goes wrong raises innergs.Error with a
sentence that says what to do; inputs are never changed.
"""

from __future__ import annotations

import collections
import contextlib
import weakref

__all__ = ["Cancelled", "Error", "Job", "Result", "cancel", "follow", "gaussians", "load", "logic", "parameters", "plane",
           "query", "reconstruct", "resample", "running", "save", "start", "stop_following"]


class Error(RuntimeError):
    """What went wrong, in a sentence that says what to do."""


class Cancelled(Error):
    """The reconstruction was cancelled; nothing was changed."""


Result = collections.namedtuple("Result", "volume model table training_psnr held_out_psnr warnings")
Result.__doc__ = """What a reconstruction gave: nodes (table: None unless quality was asked for), PSNR in dB on the fitted
samples and on withheld ones (NaN without), and sentences that the user should read."""

_logics = weakref.WeakKeyDictionary()  # scene -> logic, where there is no application


def _classes():
    """The modules with the wrapped classes; importing them needs Slicer's own first."""
    with contextlib.suppress(ImportError):
        import slicer_core  # noqa: F401  (inside the application Slicer's classes are there already)
    import vtkInnerGSPython
    import vtkSlicerInnerGSModuleLogicPython
    import vtkSlicerInnerGSModuleMRMLPython

    return vtkInnerGSPython, vtkSlicerInnerGSModuleMRMLPython, vtkSlicerInnerGSModuleLogicPython


def logic(scene=None):
    """The module's logic: the application's own, or one for the scene (a vtkMRMLScene; slicer.mrmlScene by default)."""
    import slicer

    scene = scene or getattr(slicer, "mrmlScene", None)
    module = getattr(getattr(slicer, "modules", None), "innergs", None)
    if module is not None and scene is slicer.mrmlScene:
        return module.logic()
    if scene is None:
        raise Error("There is no scene: add the nodes to a vtkMRMLScene first.")
    if scene not in _logics:
        made = _classes()[2].vtkSlicerInnerGSLogic()
        made.SetMRMLScene(scene)
        _logics[scene] = made
    return _logics[scene]


def _logic_of(node):
    if node is None or not hasattr(node, "GetScene"):
        raise Error("Give a node of the scene, not %s." % type(node).__name__)
    if node.GetScene() is None:
        raise Error("The node is not in a scene: add it first.")
    return logic(node.GetScene())


@contextlib.contextmanager
def _quiet(target):
    """Errors are raised as exceptions: no second message on the console."""
    tag = target.AddObserver("ErrorEvent", lambda *_: None)
    try:
        yield
    finally:
        target.RemoveObserver(tag)


def _checked(target, value):
    if value is None or value is False:
        raise Error(target.GetLastError())
    return value


_CHOICES = {
    "preset": ("fast", "balanced", "best", "paper"),
    "blending": ("normalised", "additive", "alpha"),
    "loss": ("l1", "l2", "huber"),
    "initialisation": ("adaptive", "grid"),
    "schedule": ("exponential", "plateau"),
    "selection": ("exact", "method1", "method2"),
}
_NUMBERS = {
    "gaussians": "NumberOfGaussians", "iterations": "NumberOfIterations", "members": "NumberOfMembers",
    "linear_intensity": "LinearIntensity", "huber_delta": "HuberDelta", "ssim_weight": "SSIMWeight",
    "paper_stop_rule": "PaperStopRule", "all_axes": "AllAxes", "densify_every": "DensifyEvery",
    "maximum_gaussians": "MaximumNumberOfGaussians", "prune_opacity": "PruneOpacity", "prune_size": "PruneSize",
    "densify_gradient": "DensifyGradient", "split_size": "SplitSize", "plateau_patience": "PlateauPatience",
    "plateau_factor": "PlateauFactor", "plateau_lowest": "PlateauLowest", "plateau_threshold": "PlateauThreshold",
    "point_weight": "PointWeight", "relocate": "Relocate", "consistency": "Consistency", "device": "Device",
    "threads": "NumberOfThreads", "instruction_set": "InstructionSet", "seed": "Seed",
}
_PROFILES = ("point", "box", "gaussian")


def _apply(node, settings):
    for name, value in settings.items():
        if name in _CHOICES:
            if value not in _CHOICES[name]:
                raise Error("%s is one of %s, not %r." % (name, ", ".join(_CHOICES[name]), value))
            getattr(node, "Set" + name.capitalize())(_CHOICES[name].index(value))
        elif name in _NUMBERS:
            getattr(node, "Set" + _NUMBERS[name])(value)
        else:
            raise Error("There is no setting %r; there are %s." % (name, ", ".join(sorted([*_CHOICES, *_NUMBERS]))))


def parameters(volumes, spacing=None, *, reference=None, input_grid=False, mask=None, segment=None, roi=None,
               thickness=None, profile=None, held_out=0.0, quality=False, quality_gap=4, output=None, output_model=None,
               **settings):
    """A parameter node with these choices, added to the volumes' scene. Arguments as in reconstruct()."""
    volumes = list(volumes) if isinstance(volumes, (list, tuple)) else [volumes]
    if not volumes:
        raise Error("There is no input volume: give at least one.")
    owner = _logic_of(volumes[0])
    if [spacing is not None, reference is not None, input_grid].count(True) > 1:
        raise Error("Give one of spacing, reference and input_grid: there is one output grid.")
    node = owner.GetMRMLScene().AddNewNodeByClass("vtkMRMLInnerGSParameterNode")
    try:
        for volume in volumes:
            if not hasattr(volume, "IsA") or not volume.IsA("vtkMRMLVolumeNode"):
                raise Error("The input %s is not a volume node." % (volume,))
            node.AddInputVolumeNode(volume)
        for name, values, setter in (("thickness", thickness, node.SetInputSliceThickness),
                                     ("profile", profile, node.SetInputSliceProfile)):
            if values is None:
                continue
            values = list(values) if isinstance(values, (list, tuple)) else [values] * len(volumes)
            if len(values) != len(volumes):
                raise Error("There are %d values of %s for %d volumes." % (len(values), name, len(volumes)))
            for volume, value in zip(volumes, values):
                setter(volume, _PROFILES.index(value) if name == "profile" else value)
        if spacing is not None:
            node.SetOutputGrid(node.SpacingGrid)
            node.SetOutputSpacing(spacing)
        elif reference is not None:
            node.SetOutputGrid(node.ReferenceGrid)
            node.SetReferenceVolumeNode(reference)
        elif input_grid:
            node.SetOutputGrid(node.InputGrid)
        node.SetMaskNode(mask)
        node.SetMaskSegmentID(segment or "")
        node.SetROINode(roi)
        node.SetHeldOutFraction(held_out)
        node.SetEvaluateQuality(quality)
        node.SetQualityGap(quality_gap)
        node.SetOutputVolumeNode(output)
        node.SetOutputModelNode(output_model)
        _apply(node, settings)
    except Exception as error:
        owner.GetMRMLScene().RemoveNode(node)
        if isinstance(error, (TypeError, ValueError)):
            raise Error(str(error)) from error
        raise
    return node


class Job:
    """A reconstruction in the background. Where no application delivers events, asking it for anything does."""

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
        """One line: phase, sweeps, PSNR, seconds left."""
        return self._current().GetDescription()

    @property
    def psnr(self):
        """dB on the fitted samples so far."""
        return self._current().GetTrainingPSNR()

    @property
    def preview(self):
        """The last preview as (vtkImageData, IJK to RAS vtkMatrix4x4), or None."""
        job = self._current()
        return (job.GetPreviewImage(), job.GetPreviewIJKToRASMatrix()) if job.GetPreviewImage() else None

    def cancel(self):
        """Ends it within 200 ms; no node is changed."""
        self._logic.Cancel(self._job)

    def result(self, timeout=None):
        """Waits (at most timeout seconds) and gives the Result. Raises Error, Cancelled, or TimeoutError."""
        import time

        end = None if timeout is None else time.monotonic() + timeout
        try:
            with _quiet(self._logic):
                while not self._job.IsDone():
                    if end is not None and time.monotonic() >= end:
                        raise TimeoutError("The reconstruction is still running.")
                    self._logic.WaitForJob(self._job, 0.1)  # short: Ctrl-C is heard in between
        except KeyboardInterrupt:
            self.cancel()
            raise
        job = self._job
        if job.GetState() == job.Failed:
            raise Error(job.GetErrorMessage())
        if job.GetState() == job.Cancelled:
            raise Cancelled("The reconstruction was cancelled.")
        warnings = [job.GetWarning(n) for n in range(job.GetNumberOfWarnings())]
        return Result(job.GetVolumeNode(), job.GetModelNode(), job.GetTableNode(), job.GetTrainingPSNR(),
                      job.GetHeldOutPSNR(), warnings)


def start(volumes, spacing=None, *, progress=None, preview=None, parameter_node=None, **choices):
    """Starts a reconstruction in the background and returns a Job; jobs run one after the other.

    progress, preview: called on the main thread with the Job. parameter_node: a vtkMRMLInnerGSParameterNode with all
    choices, instead of them. Other arguments as in reconstruct().
    """
    if parameter_node is not None:
        if volumes is not None or spacing is not None or choices:
            raise Error("Give a parameter node or volumes with choices, not both.")
        node, temporary = parameter_node, None
    else:
        node = temporary = parameters(volumes, spacing, **choices)
    owner = _logic_of(node)
    with _quiet(owner):
        job = owner.StartReconstruction(node)
    if job is None:
        sentence = owner.GetLastError()
        if temporary is not None:
            temporary.GetScene().RemoveNode(temporary)
        raise Error(sentence)
    return Job(owner, job, temporary, progress, preview)


def reconstruct(volumes, spacing=None, *, progress=None, preview=None, parameter_node=None, **choices):
    """Reconstructs one volume node, or several of the same patient, and waits. Returns a Result with new nodes.

    spacing      output voxel size in mm, isotropic; by default the finest spacing of the inputs
    reference    a volume node whose voxels the output gets; input_grid=True: those of the first input
    mask         a label map or segmentation node: only what is inside is fitted (segment: one segment's ID)
    roi          a markups ROI node: only that box is fitted and put out
    thickness    slice thickness in mm, one number or one per volume; by default the distance between slices
    profile      "box" (default), "gaussian" or "point": how a slice averages across its thickness
    held_out     share of slices (0 to 0.5) withheld to report held_out_psnr
    quality      also judge the settings by protocol H (keep every quality_gap-th slice) in a table node
    output, output_model  nodes to write to instead of new ones
    progress, preview     called with the Job from time to time
    preset       "fast", "balanced" (default), "best" or "paper"; further settings: blending, loss, initialisation,
                 schedule (plateau_patience, plateau_factor, plateau_lowest, plateau_threshold), gaussians,
                 densify_every (maximum_gaussians, prune_opacity, prune_size, densify_gradient, split_size), iterations,
                 members, linear_intensity, huber_delta, point_weight, ssim_weight, all_axes, paper_stop_rule,
                 relocate, consistency, selection, device ("auto", "cpu", "cuda", "cuda:N"), threads, instruction_set, seed
    """
    return start(volumes, spacing, progress=progress, preview=preview, parameter_node=parameter_node, **choices).result()


def running(scene=None):
    """Whether a reconstruction is queued or running."""
    return bool(logic(scene).IsRunning())


def cancel(scene=None):
    """Cancels all reconstructions."""
    logic(scene).Cancel()


def query(model, points):
    """The model's values (scanner units) at RAS points in mm: a float for one point, else a NumPy array."""
    import numpy
    from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
    from vtkmodules.vtkCommonCore import vtkFloatArray, vtkPoints

    array = numpy.ascontiguousarray(points, dtype=numpy.float64)
    if array.shape[-1:] != (3,):
        raise Error("Points have three coordinates each: give an array of shape (..., 3).")
    coordinates = vtkPoints()
    coordinates.SetData(numpy_to_vtk(array.reshape(-1, 3), deep=True))
    values = vtkFloatArray()
    owner = _logic_of(model)
    with _quiet(owner):
        _checked(owner, owner.GetValuesAtRAS(model, coordinates, values))
    if values.GetNumberOfTuples() == 0:
        return numpy.empty(array.shape[:-1], numpy.float32)
    result = vtk_to_numpy(values).reshape(array.shape[:-1]).copy()
    return float(result) if array.ndim == 1 else result


def plane(model, matrix, size=256, spacing=1.0, output=None):
    """The model on a plane as a volume node.

    matrix: plane to RAS (vtkMatrix4x4 or 4x4 numbers) as a slice node's SliceToRAS; its origin is the middle of the
    image. size: pixels, one number or (columns, rows); spacing in mm.
    """
    columns, rows = (size, size) if isinstance(size, int) else size
    owner = _logic_of(model)
    with _quiet(owner):
        return _checked(owner, owner.QueryPlane(model, _matrix(matrix), columns, rows, spacing, output))


def _matrix(matrix):
    from vtkmodules.vtkCommonMath import vtkMatrix4x4

    if isinstance(matrix, vtkMatrix4x4):
        return matrix
    result = vtkMatrix4x4()
    result.DeepCopy([float(x) for row in matrix for x in row])
    return result


def resample(model, spacing=0.0, reference=None, output=None):
    """The model as a volume node at a spacing in mm (0: as the fit had it), or on a reference volume's voxels."""
    owner = _logic_of(model)
    with _quiet(owner):
        made = owner.ResampleLike(model, reference, output) if reference else owner.Resample(model, spacing, output)
        return _checked(owner, made)


def follow(model, slice_node, output=None):
    """A volume node that shows the model on a slice view's plane from now on."""
    owner = _logic_of(model)
    with _quiet(owner):
        return _checked(owner, owner.FollowSlice(model, slice_node, output))


def stop_following(output):
    """The volume node stays as it is."""
    _logic_of(output).StopFollowing(output)


def gaussians(model, maximum=0):
    """The Gaussians as a model node for 3D views; at most so many (0: all)."""
    owner = _logic_of(model)
    with _quiet(owner):
        return _checked(owner, owner.CreateGaussianModel(model, maximum))


def load(path, scene=None):
    """A model file (.innergs, .ply) as a model node."""
    owner = logic(scene)
    with _quiet(owner):
        return _checked(owner, owner.LoadModel(str(path)))


def save(model, path):
    """Writes a model file (.innergs: everything; .ply: the Gaussians alone)."""
    owner = _logic_of(model)
    with _quiet(owner):
        _checked(owner, owner.SaveModel(model, str(path)))
