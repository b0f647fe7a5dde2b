"""Converts choices to parameter nodes."""

from __future__ import annotations

from ._queries import matrix_of
from ._scene import Error, logic, logic_of

_PROFILES = ("point", "box", "gaussian")


def apply_settings(node, settings):
    """Sets settings by their names in Docs/settings.md on a node or request; None unsets."""
    for name, value in settings.items():
        first, *others = name.split("_")
        setting = first + "".join(word.capitalize() for word in others)
        text = "" if value is None else str(value).lower() if isinstance(value, bool) else str(value)
        refusal = node.CheckSetting(setting, text)
        if refusal:
            raise Error(refusal)
        node.SetSetting(setting, text)


def _of_volume(node, name, value):
    """The parameter node's value for one volume's thickness, profile or axis."""
    if name == "profile":
        if value not in _PROFILES:
            raise Error("profile is one of %s, not %r." % (", ".join(_PROFILES), value))
        return _PROFILES.index(value)
    if name == "axis":
        if value not in (None, 0, 1, 2):
            raise Error("axis is 0, 1 or 2 (the index that counts the slices) or None, not %r." % (value,))
        return node.Automatic if value is None else value
    return value


def slice_poses(matrices, scene=None, name="Slice poses"):
    """A sequence node of transforms, for slice_poses in reconstruct(): for each slice a matrix (vtkMatrix4x4 or 4x4 numbers),
    rigid, RAS mm, applied to where the volume puts it."""
    matrices = [matrix_of(matrix) for matrix in matrices]
    if not matrices:
        raise Error("There are no slice poses: give one matrix per slice.")
    scene = logic(scene).GetMRMLScene()
    sequence = scene.AddNewNodeByClass("vtkMRMLSequenceNode", scene.GenerateUniqueName(name))
    sequence.SetIndexName("slice")
    sequence.SetIndexUnit("")
    transform = scene.CreateNodeByClass("vtkMRMLLinearTransformNode")
    transform.UnRegister(None)  # Python holds a reference
    for k, matrix in enumerate(matrices):
        transform.SetMatrixTransformToParent(matrix)
        sequence.SetDataNodeAtValue(transform, str(k))
    return sequence


def parameters(volumes, spacing=None, **choices):
    """A parameter node with these choices, added to the volumes' scene. Arguments as in reconstruct()."""
    return _add(False, volumes, spacing, **choices)


def temporary(volumes, spacing=None, **choices):
    """A parameter node for one job: not among the panel's parameter sets, not saved with the scene."""
    return _add(True, volumes, spacing, **choices)


def _add(hidden, volumes, spacing=None, *, reference=None, input_grid=False, mask=None, segment=None, roi=None,
         thickness=None, profile=None, axis=None, slice_poses=None, held_out=0.0, uncertainty=False, quality=False, quality_gap=0, output=None,
         output_model=None, **settings):
    volumes = list(volumes) if isinstance(volumes, (list, tuple)) else [volumes]
    if not volumes:
        raise Error("There is no input volume: give at least one.")
    owner = logic_of(volumes[0])
    if [spacing is not None, reference is not None, input_grid].count(True) > 1:
        raise Error("Give one of spacing, reference and input_grid: there is one output grid.")
    scene = owner.GetMRMLScene()
    node = scene.CreateNodeByClass("vtkMRMLInnerGSParameterNode")
    node.UnRegister(None)  # Python holds a reference
    node.SetHideFromEditors(hidden)
    node.SetSaveWithScene(not hidden)
    node.SetName(scene.GenerateUniqueName("InnerGS"))
    scene.AddNode(node)
    try:
        for volume in volumes:
            if not hasattr(volume, "IsA") or not volume.IsA("vtkMRMLVolumeNode"):
                raise Error("The input %s is not a volume node." % (volume,))
            node.AddInputVolumeNode(volume)
        for name, values, setter in (("thickness", thickness, node.SetInputSliceThickness),
                                     ("profile", profile, node.SetInputSliceProfile),
                                     ("axis", axis, node.SetInputSliceAxis),
                                     ("slice_poses", slice_poses, node.SetInputSlicePosesNode)):
            if values is None:
                continue
            values = list(values) if isinstance(values, (list, tuple)) else [values] * len(volumes)
            if len(values) != len(volumes):
                raise Error("There are %d values of %s for %d volumes." % (len(values), name, len(volumes)))
            for volume, value in zip(volumes, values):
                setter(volume, _of_volume(node, name, value))
        if spacing is not None:
            node.SetOutputGrid(node.SpacingGrid)
            node.SetOutputSpacing(spacing)
        elif reference is not None:
            node.SetOutputGrid(node.ReferenceGrid)
            node.SetReferenceVolumeNode(reference)
        elif input_grid:
            node.SetOutputGrid(node.InputGrid)
        if isinstance(mask, (list, tuple)):
            if len(mask) not in (0, 1, len(volumes)):
                raise Error("There are %d masks for %d volumes: give one for all, or one for each." % (len(mask), len(volumes)))
            if len(mask) == len(volumes) > 1:
                for volume, one in zip(volumes, mask):
                    node.SetInputMaskNode(volume, one)
            else:
                node.SetMaskNode(mask[0] if mask else None)
        else:
            node.SetMaskNode(mask)
        node.SetMaskSegmentID(segment or "")
        node.SetROINode(roi)
        node.SetHeldOutFraction(held_out)
        node.SetEstimateUncertainty(uncertainty)
        node.SetEvaluateQuality(quality)
        node.SetQualityGap(quality_gap)
        node.SetOutputVolumeNode(output)
        node.SetOutputModelNode(output_model)
        apply_settings(node, settings)
    except Exception as error:
        scene.RemoveNode(node)
        if isinstance(error, (TypeError, ValueError)):
            raise Error(str(error)) from error
        raise
    return node
