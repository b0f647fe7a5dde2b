"""The logic of a scene, and errors."""

from __future__ import annotations

import contextlib
import weakref


class Error(RuntimeError):
    """An error, with a message that says what to do. code: one of vtkInnerGSAlgorithm's ErrorCodes, or 0."""

    def __init__(self, sentence="", code=0):
        super().__init__(sentence)
        self.code = code


class Cancelled(Error):
    """The reconstruction was cancelled; nothing was changed."""


_logics = weakref.WeakKeyDictionary()  # scene -> logic, without an application


def _classes():
    """The modules with the wrapped classes; importing them needs Slicer's own first."""
    with contextlib.suppress(ImportError):
        import slicer_core  # noqa: F401  (inside the application, Slicer's classes are loaded already)
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


def logic_of(node):
    if node is None or not hasattr(node, "GetScene"):
        raise Error("Give a node of the scene, not %s." % type(node).__name__)
    if node.GetScene() is None:
        raise Error("The node is not in a scene: add it first.")
    return logic(node.GetScene())


@contextlib.contextmanager
def quiet(target):
    """Suppresses console messages, as errors are raised as exceptions."""
    tag = target.AddObserver("ErrorEvent", lambda *_: None)
    try:
        yield
    finally:
        target.RemoveObserver(tag)


def checked(target, value):
    if value is None or value is False:
        raise Error(target.GetLastError(), target.GetLastErrorCode())
    return value


def call(method, node, *arguments):
    """Calls a method of the node's logic, with the node and what follows; raises Error if it refuses."""
    owner = logic_of(node)
    with quiet(owner):
        return checked(owner, getattr(owner, method)(node, *arguments))
