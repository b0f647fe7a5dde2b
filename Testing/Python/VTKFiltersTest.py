"""The VTK filters from Python: run by ctest with VTK's own interpreter; PYTHONPATH names the wrapped module."""

import gc
import math
import sys
import unittest

try:
    from vtkmodules.util.vtkConstants import VTK_OBJECT, VTK_UNSIGNED_CHAR
    from vtkmodules.vtkCommonCore import vtkFloatArray, vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkImageData
    from vtkmodules.vtkCommonMath import vtkMatrix4x4
except ImportError as error:
    print("SKIPPED: VTK's Python modules are missing (Debian: python3-vtk9):", error)
    sys.exit(77)

from vtkInnerGSPython import (
    vtkInnerGSModel,
    vtkInnerGSPlaneQuery,
    vtkInnerGSPointQuery,
    vtkInnerGSReconstruct,
    vtkInnerGSResample,
    vtkInnerGSToPolyData,
)


def bump(r, a, s):
    """A smooth intensity around RAS (12, -8, 30)."""
    return 100 * math.exp(-((r - 12) ** 2 + (a + 8) ** 2 + (s - 30) ** 2) / 60)


def ijk_to_ras():
    """Oblique: a quarter turn about S, slices 2 mm apart running downwards; left-handed."""
    matrix = vtkMatrix4x4()
    for row, values in enumerate([(0, -1, 0, 22), (1, 0, 0, -18), (0, 0, -2, 44), (0, 0, 0, 1)]):
        for column, value in enumerate(values):
            matrix.SetElement(row, column, value)
    return matrix


def scan(size=(20, 20, 14)):
    image = vtkImageData()
    image.SetDimensions(*size)
    image.AllocateScalars(10, 1)  # float
    matrix = ijk_to_ras()
    for k in range(size[2]):
        for j in range(size[1]):
            for i in range(size[0]):
                position = matrix.MultiplyPoint((i, j, k, 1))[:3]
                image.SetScalarComponentFromDouble(i, j, k, 0, bump(*position))
    return image


def reconstruct(image=None):
    job = vtkInnerGSReconstruct()
    job.AddInputData(image or scan())
    job.SetInputIJKToRASMatrix(0, ijk_to_ras())
    job.SetInputSliceProfile(0, vtkInnerGSReconstruct.PointProfile)
    job.SetPreset(vtkInnerGSReconstruct.Fast)
    job.SetNumberOfGaussians(600)
    return job


class Filters(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.job = reconstruct()
        cls.job.Update()
        cls.model = cls.job.GetOutputModel()

    def test_reconstruction(self):
        job = self.job
        self.assertEqual(job.GetErrorMessage(), "")
        self.assertEqual(self.model.GetNumberOfGaussians(), job.GetCurrentGaussians())
        self.assertIn("Gaussians, normalised blending", self.model.GetDescription())
        self.assertEqual(job.GetOutputImage().GetDimensions(), (20, 20, 28))
        matrix = job.GetOutputIJKToRASMatrix()
        self.assertAlmostEqual(matrix.GetElement(0, 1), -1)
        self.assertAlmostEqual(matrix.GetElement(2, 2), -1)
        self.assertGreater(job.GetTrainingPSNR(), 35)
        self.assertTrue(math.isnan(job.GetHeldOutPSNR()))
        self.assertIn("preset=fast", job.GetUsedSettings())

    def test_values_lie_where_the_scan_has_them(self):
        query = vtkInnerGSPointQuery()
        query.SetModel(self.model)
        points = vtkPoints()
        expected = []
        for r, a, s in [(12, -8, 30), (14, -8, 30), (12, -4, 30), (12, -8, 36), (8, -12, 26)]:
            points.InsertNextPoint(r, a, s)
            expected.append(bump(r, a, s))
        values = vtkFloatArray()
        self.assertTrue(query.Evaluate(points, values))
        for i, value in enumerate(expected):
            self.assertAlmostEqual(values.GetValue(i), value, delta=4)
        self.assertAlmostEqual(query.EvaluatePoint(12, -8, 30), 100, delta=4)

    def test_plane_follows_its_matrix(self):
        query = vtkInnerGSPlaneQuery()
        query.SetInputConnection(self.job.GetOutputPort(0))
        query.SetDimensions(9, 9)
        plane = vtkMatrix4x4()
        angle = 0.6  # about A
        for (row, column), value in {
            (0, 0): math.cos(angle), (0, 2): math.sin(angle), (2, 0): -math.sin(angle), (2, 2): math.cos(angle),
            (0, 3): 12, (1, 3): -8, (2, 3): 30,
        }.items():
            plane.SetElement(row, column, value)
        query.SetPlaneToRASMatrix(plane)
        query.Update()
        image, matrix = query.GetOutput(), query.GetOutputIJKToRASMatrix()
        for i in range(9):
            for j in range(9):
                position = matrix.MultiplyPoint((i, j, 0, 1))[:3]
                self.assertAlmostEqual(image.GetScalarComponentAsDouble(i, j, 0, 0), bump(*position), delta=5)
        self.assertAlmostEqual(image.GetScalarComponentAsDouble(4, 4, 0, 0), 100, delta=4)
        plane.SetElement(2, 3, 33)
        query.SetPlaneToRASMatrix(plane)
        query.Update()
        self.assertAlmostEqual(query.GetOutput().GetScalarComponentAsDouble(4, 4, 0, 0), bump(12, -8, 33), delta=5)

    def test_resampling_and_export(self):
        resample = vtkInnerGSResample()
        resample.SetModel(self.model)
        resample.SetOutputSpacing(2, 2, 2)
        resample.Update()
        self.assertEqual(resample.GetOutput().GetDimensions(), (10, 10, 14))
        gaussians = vtkInnerGSToPolyData()
        gaussians.SetModel(self.model)
        gaussians.SetMaximumNumberOfGaussians(50)
        gaussians.Update()
        data = gaussians.GetOutput()
        self.assertEqual(data.GetNumberOfPoints(), 50)
        names = {data.GetPointData().GetArrayName(i) for i in range(data.GetPointData().GetNumberOfArrays())}
        self.assertEqual(names, {"Intensity", "Ellipsoid", "Scales", "Orientation", "Weight", "Disagreement"})
        bounds = [0] * 6
        self.model.GetBounds(bounds)
        for a, b in zip(bounds, (2.5, 22.5, -18.5, 1.5, 17, 45)):
            self.assertAlmostEqual(a, b)

    def test_progress_and_abort(self):
        job = reconstruct()
        seen = []

        def progress(caller, event):
            seen.append((caller.GetProgress(), caller.GetProgressText(), caller.GetCurrentIteration()))
            if caller.GetCurrentIteration() == 5:
                caller.AbortExecuteOn()

        tag = job.AddObserver("ProgressEvent", progress)
        job.Update()
        self.assertTrue(job.GetAborted())
        self.assertTrue(job.GetOutputModel().IsEmpty())
        self.assertEqual(job.GetErrorMessage(), "")
        self.assertEqual(seen[-1][2], 5)
        self.assertTrue(seen[-1][1].startswith("Fitting, iteration 5 of "))
        self.assertEqual([p for p, _, _ in seen], sorted(p for p, _, _ in seen))
        job.RemoveObserver(tag)
        job.Update()
        self.assertFalse(job.GetAborted())
        self.assertFalse(job.GetOutputModel().IsEmpty())

    def test_preview_has_its_image(self):
        job = reconstruct()
        job.SetNumberOfIterations(1000000)
        images = []

        def preview(caller, event, image):
            images.append(image)
            caller.Cancel()

        preview.CallDataType = VTK_OBJECT
        job.AddObserver(vtkInnerGSReconstruct.PreviewEvent, preview)
        job.Update()
        self.assertTrue(job.GetAborted())
        self.assertEqual(images[0].GetDimensions(), (20, 20, 28))
        self.assertAlmostEqual(images[0].GetScalarRange()[1], 100, delta=10)

    def test_errors_are_sentences(self):
        colour = vtkImageData()
        colour.SetDimensions(4, 4, 4)
        colour.AllocateScalars(VTK_UNSIGNED_CHAR, 3)
        job = reconstruct(colour)
        messages = []

        def error(caller, event, text):
            messages.append(text)

        error.CallDataType = "string0"
        job.AddObserver("ErrorEvent", error)
        job.Update()
        self.assertEqual(len(messages), 1)
        self.assertIn("3 values per voxel", messages[0])
        self.assertIn("3 values per voxel", job.GetErrorMessage())
        self.assertEqual(job.GetErrorCode(), vtkInnerGSReconstruct.UnsupportedImageError)
        self.assertTrue(job.GetOutputModel().IsEmpty())

    def test_a_model_outlives_its_filter(self):
        job = reconstruct()
        job.Update()
        model = vtkInnerGSModel()
        model.ShallowCopy(job.GetOutputModel())
        count = job.GetCurrentGaussians()
        del job
        gc.collect()
        self.assertGreater(count, 0)
        self.assertEqual(model.GetNumberOfGaussians(), count)
        self.assertEqual(model.GetReferenceCount(), 1)


if __name__ == "__main__":
    unittest.main(verbosity=2)
