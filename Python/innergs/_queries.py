"""Querying, showing, loading and saving models."""

from __future__ import annotations

from ._scene import Error, call, checked, logic, logic_of, quiet


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
    call("GetValuesAtRAS", model, coordinates, values)
    if values.GetNumberOfTuples() == 0:
        return numpy.empty(array.shape[:-1], numpy.float32)
    result = vtk_to_numpy(values).reshape(array.shape[:-1]).copy()
    return float(result) if array.ndim == 1 else result


def plane(model, matrix, size=256, spacing=1.0, output=None, uncertainty=False):
    """The model on a plane as a volume node; uncertainty: the standard deviation of its volume there instead.

    matrix: plane to RAS (vtkMatrix4x4 or 4x4 numbers), like a slice node's SliceToRAS; its origin is the centre of the
    image. size: pixels, one number or (columns, rows); spacing in mm.
    """
    columns, rows = (size, size) if isinstance(size, int) else size
    method = "QueryUncertaintyPlane" if uncertainty else "QueryPlane"
    return call(method, model, matrix_of(matrix), columns, rows, spacing, output)


def matrix_of(matrix):
    """A vtkMatrix4x4 of 4x4 numbers, or itself."""
    from vtkmodules.vtkCommonMath import vtkMatrix4x4

    if isinstance(matrix, vtkMatrix4x4):
        return matrix
    try:
        numbers = [float(x) for row in matrix for x in row]
    except TypeError:
        numbers = []
    if len(numbers) != 16:
        raise Error("A matrix is a vtkMatrix4x4 or 4x4 numbers, not %r." % (matrix,))
    result = vtkMatrix4x4()
    result.DeepCopy(numbers)
    return result


def resample(model, spacing=0.0, reference=None, output=None):
    """The model as a volume node at a spacing in mm (0: as in the fit), or on a reference volume's voxels."""
    if reference:
        return call("ResampleLike", model, reference, output)
    return call("Resample", model, spacing, output)


def follow(model, slice_node, output=None):
    """A volume node that shows the model on a slice view's plane from now on."""
    return call("FollowSlice", model, slice_node, output)


def stop_following(output):
    """Stops following; the volume node keeps its content."""
    logic_of(output).StopFollowing(output)


def gaussians(model, maximum=0):
    """The Gaussians as a model node for 3D views; at most the given number (0: all)."""
    return call("CreateGaussianModel", model, maximum)


def load(path, scene=None):
    """A model file (.innergs, .ply) as a model node."""
    owner = logic(scene)
    with quiet(owner):
        return checked(owner, owner.LoadModel(str(path)))


def slice_transforms(slices):
    """Transform nodes of a result's slices (Result.slices), in their order: from where a scan's header puts the slice
    to where it lies (to parent, RAS mm)."""
    from vtkmodules.vtkCommonCore import vtkCollection

    transforms = vtkCollection()
    call("CreateSliceTransforms", slices, transforms)
    return [transforms.GetItemAsObject(n) for n in range(transforms.GetNumberOfItems())]


def save(model, path):
    """Writes a model file (.innergs: everything; .ply: only the Gaussians)."""
    call("SaveModel", model, str(path))
