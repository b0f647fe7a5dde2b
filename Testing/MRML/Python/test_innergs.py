"""The wrapped logic and the innergs package against Slicer's real MRML, without a display."""

import gc
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy
import slicer_core
from slicer_core import vtkMRMLScalarVolumeNode, vtkMRMLScene
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonCore import VTK_OBJECT
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonMath import vtkMatrix4x4

import innergs

TEMPORARY = tempfile.TemporaryDirectory()
os.environ["TMPDIR"] = TEMPORARY.name  # where the logic keeps fits that end with their scene


def truth(r, a, s):
    return 400 + 120 * numpy.sin(r / 7) + 90 * numpy.cos(a / 6) + 70 * numpy.sin(s / 8) + r - 2 * a


def add_volume(scene, name="Head", size=(24, 22, 20), spacing=(2.0, 2.0, 2.0)):
    k, j, i = numpy.meshgrid(*[numpy.arange(n) for n in reversed(size)], indexing="ij")
    origin = [-d * (n - 1) / 2 for n, d in zip(size, spacing)]
    values = truth(*[o + d * x for o, d, x in zip(origin, spacing, (i, j, k))]).astype(numpy.int16)
    image = vtkImageData()
    image.SetDimensions(size)
    image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=True))
    node = vtkMRMLScalarVolumeNode()
    node.SetName(name)
    node.SetAndObserveImageData(image)
    node.SetSpacing(spacing)
    node.SetOrigin(origin)
    scene.AddNode(node)
    return node


def add_series(scene, frames=5, interval=0.5):
    """A blob that moves along R, 1.5 mm a frame."""
    from slicer_core import vtkMRMLSequenceNode

    sequence = vtkMRMLSequenceNode()
    sequence.SetName("Wrist")
    sequence.SetIndexName("time")
    sequence.SetIndexUnit("s")
    scene.AddNode(sequence)
    k, j, i = numpy.meshgrid(numpy.arange(6), numpy.arange(12), numpy.arange(14), indexing="ij")
    for f in range(frames):
        values = 20 + 300 * numpy.exp(-((2 * i - 10 - 1.5 * f) ** 2 + (2 * j - 11) ** 2 + (3 * k - 7) ** 2) / 30)
        image = vtkImageData()
        image.SetDimensions(14, 12, 6)
        image.GetPointData().SetScalars(numpy_to_vtk(values.ravel(), deep=True))
        node = vtkMRMLScalarVolumeNode()
        node.SetAndObserveImageData(image)
        node.SetSpacing(2, 2, 3)
        sequence.SetDataNodeAtValue(node, str(interval * f))
    return sequence


class InnerGSTest(unittest.TestCase):
    def setUp(self):
        self.scene = vtkMRMLScene()
        self.logic = innergs.logic(self.scene)

    def test_segments_by_their_names(self):
        source = add_volume(self.scene)
        model = innergs.reconstruct(source, preset="fast", iterations=10).model
        with self.assertRaisesRegex(innergs.Error, "knows no segments"):
            innergs.segment(model, "liver")
        node = slicer_core.vtkMRMLSegmentationNode()
        node.SetName("Organs")
        self.scene.AddNode(node)
        k, j, i = numpy.indices((20, 22, 24))
        for name, inside in (("liver", i < 10), ("kidney_left", (i > 12) & (j < 9)), ("kidney_right", (i > 12) & (j > 12))):
            image = slicer_core.vtkOrientedImageData()
            image.SetDimensions(24, 22, 20)
            image.GetPointData().SetScalars(numpy_to_vtk(inside.astype(numpy.uint8).ravel(), deep=True))
            matrix = vtkMatrix4x4()
            source.GetIJKToRASMatrix(matrix)
            image.SetImageToWorldMatrix(matrix)
            node.AddSegmentFromBinaryLabelmapRepresentation(image, name)
        told = []
        self.assertIs(innergs.learn(model, node, progress=lambda job: told.append(job.progress)), model)
        self.assertTrue(told)
        found = innergs.find(model, "kidney")
        self.assertEqual((found.answer, found.candidates), ("several", [("kidney_left", 1.0), ("kidney_right", 1.0)]))
        self.assertEqual(innergs.find(model, "heart").answer, "not in volume")
        segments = innergs.segment(model, ["hepar", "both kidneys"], largest_only=False, smoothing=1.0)
        self.assertEqual(segments.GetSegmentation().GetNumberOfSegments(), 2)
        self.assertIs(innergs.segment(model, "left kidney", output=segments), segments)
        self.assertEqual(segments.GetSegmentation().GetNthSegment(2).GetName(), "kidney_left")
        score = innergs.score(model, "left kidney")
        self.assertGreater(score.GetImageData().GetScalarRange()[1], 0.9)
        self.assertIs(innergs.score(model, "hepar", output=score), score)
        with self.assertRaisesRegex(innergs.Error, "not in this volume"):
            innergs.segment(model, "heart")
        with self.assertRaisesRegex(innergs.Error, "empty"):
            innergs.segment(model, "")
        with self.assertRaisesRegex(innergs.Error, "choose a segmentation"):
            innergs.learn(model, None)
        with self.assertRaisesRegex(innergs.Error, "one teacher"):
            innergs.learn(model, node, network="organs.onnx")
        with self.assertRaisesRegex(innergs.Error, "organs.onnx|OpenVINO"):
            innergs.learn(model, network="organs.onnx", names=["liver"])

    def test_segments_from_features(self):
        source = add_volume(self.scene)
        model = innergs.reconstruct(source, preset="fast", iterations=10).model
        k, j, i = numpy.indices((20, 22, 24))
        image = vtkImageData()
        image.SetDimensions(24, 22, 20)
        angles = numpy.where(i < 10, 1.5, 0.0).ravel()
        image.GetPointData().SetScalars(
            numpy_to_vtk(numpy.stack([numpy.cos(angles), numpy.sin(angles)], axis=1).astype(numpy.float32), deep=True))
        features = slicer_core.vtkMRMLVectorVolumeNode()
        features.SetAndObserveImageData(image)
        matrix = vtkMatrix4x4()
        source.GetIJKToRASMatrix(matrix)
        features.SetIJKToRASMatrix(matrix)
        self.scene.AddNode(features)
        with tempfile.TemporaryDirectory() as folder:
            texts = os.path.join(folder, "texts.json")
            with open(texts, "w") as out:
                out.write('{"background": [1, 0], "liver": [0.07, 0.9975]}')
            self.assertIs(innergs.learn(model, features=features, texts=texts), model)
        self.assertEqual(innergs.find(model, "liver").answer, "found")
        self.assertEqual(innergs.segment(model, "liver").GetSegmentation().GetNumberOfSegments(), 1)

    def test_moving(self):
        sequence = add_series(self.scene)
        seen = []
        result = innergs.reconstruct_moving(sequence, kind="motion", quality=False, rate=4,
                                            progress=lambda job: seen.append(job.progress))
        self.assertTrue(seen)
        self.assertEqual(result.frames.GetNumberOfDataNodes(), 9)
        self.assertIsNotNone(result.browser)
        innergs.set_time(result.model, 0.75)
        centre = [10 + 1.5 * 1.5, 11, 7]
        self.assertAlmostEqual(innergs.query(result.model, centre), 320, delta=25)
        innergs.set_time(result.model, 2)
        self.assertLess(innergs.query(result.model, centre), 250)
        self.assertEqual(innergs.frames(result.model, [0.1, 0.2, 0.3]).GetNumberOfDataNodes(), 3)
        self.assertEqual(innergs.motion(result.model, start=0).GetNumberOfDataNodes(), 5)
        with self.assertRaisesRegex(innergs.Error, "outside"):
            innergs.frames(result.model, [99])
        with self.assertRaisesRegex(innergs.Error, r"motion\|intensity\|network"):
            innergs.reconstruct_moving(sequence, kind="warp")
        with self.assertRaisesRegex(innergs.Error, "knots"):
            innergs.reconstruct_moving(sequence, knots=2)
        coarse = innergs.reconstruct_moving(sequence, kind="network", rounds=2, knots=5, quality=False)
        self.assertIn("rounds=2", coarse.model.GetAttribute("InnerGS.Settings"))

    def test_moving_segments(self):
        sequence = add_series(self.scene)
        model = innergs.reconstruct_moving(sequence, kind="motion", quality=False).model
        node = slicer_core.vtkMRMLSegmentationNode()
        self.scene.AddNode(node)
        image = slicer_core.vtkOrientedImageData()
        image.SetDimensions(14, 12, 6)
        image.SetSpacing(2, 2, 3)
        frame = vtk_to_numpy(sequence.GetNthDataNode(1).GetImageData().GetPointData().GetScalars())
        image.GetPointData().SetScalars(numpy_to_vtk((frame > 150).astype(numpy.uint8), deep=True))
        node.AddSegmentFromBinaryLabelmapRepresentation(image, "lunate")
        innergs.set_time(model, 0.5)
        taught = innergs.learn(model, node, progress=lambda job: innergs.set_time(model, 2.0))
        self.assertIs(taught, model)
        self.assertTrue(model.IsDynamic())
        for frame in (1, 4):
            innergs.set_time(model, 0.5 * frame)
            score = innergs.score(model, "lunate")
            found = vtk_to_numpy(score.GetImageData().GetPointData().GetScalars()) > 0.5
            truth = vtk_to_numpy(sequence.GetNthDataNode(frame).GetImageData().GetPointData().GetScalars()) > 150
            self.assertGreater(2 * (found & truth).sum() / (found.sum() + truth.sum()), 0.85)
        segments = innergs.segment(model, "lunate")
        self.assertEqual(segments.GetSegmentation().GetNthSegment(0).GetName(), "lunate")

    def test_moving_slice_times(self):
        sequence = add_series(self.scene)
        slices = sequence.GetNthDataNode(0).GetImageData().GetDimensions()[2]
        times = [0.5 * ((2 * k) % slices) / slices for k in range(slices)]
        value = {}
        for given in (None, times):
            result = innergs.reconstruct_moving(sequence, kind="intensity", quality=False, slice_times=given)
            innergs.set_time(result.model, 0.75)
            value[given is None] = innergs.query(result.model, [11, 11, 7])
        self.assertNotEqual(value[True], value[False])
        with self.assertRaisesRegex(innergs.Error, "does not exist"):
            innergs.reconstruct_moving(sequence, kind="intensity", slice_times="no/such/file.json")

    def test_moving_stopped(self):
        sequence = add_series(self.scene)
        shown = []

        def stop(job):
            shown.append(job.preview(0.75))
            job.cancel()

        choices = dict(kind="motion", quality=False, rounds=150)
        job = innergs.start_moving(sequence, keep=True, preview=stop, **choices)
        with self.assertRaises(innergs.Cancelled):
            job.result()
        self.assertIsNotNone(shown[0].GetImageData())
        self.assertTrue(job.recovery_file)
        result = innergs.reconstruct_moving(sequence, resume=job.recovery_file, **choices)
        innergs.set_time(result.model, 0.75)
        self.assertAlmostEqual(innergs.query(result.model, [10 + 1.5 * 1.5, 11, 7]), 320, delta=25)

    def test_reconstruct(self):
        source = add_volume(self.scene)
        result = innergs.reconstruct(source, spacing=1.5, preset="fast", held_out=0.1)
        self.assertEqual(result.volume.GetImageData().GetDimensions(), (32, 29, 27))
        self.assertGreater(result.training_psnr, 30)
        self.assertGreater(result.held_out_psnr, 25)
        self.assertIsNone(result.table)
        self.assertEqual(result.volume.GetAttribute("InnerGS.Inputs"), "Head")
        # The temporary parameter node is gone.
        self.assertEqual(self.scene.GetNumberOfNodesByClass("vtkMRMLInnerGSParameterNode"), 0)

        points = numpy.array([[1, 2, 3], [-6, 5, 4]], float)
        values = innergs.query(result.model, points)
        numpy.testing.assert_allclose(values, truth(*points.T), atol=10)
        self.assertAlmostEqual(innergs.query(result.model, [1, 2, 3]), values[0], places=3)
        self.assertEqual(innergs.query(result.model, numpy.zeros((2, 5, 3))).shape, (2, 5))
        self.assertEqual(innergs.query(result.model, numpy.zeros((0, 3))).shape, (0,))

        plane = innergs.plane(result.model, numpy.eye(4), size=(17, 9), spacing=0.5)
        self.assertEqual(plane.GetImageData().GetDimensions(), (17, 9, 1))
        self.assertAlmostEqual(plane.GetImageData().GetScalarComponentAsDouble(8, 4, 0, 0), truth(0, 0, 0), delta=8)
        fine = innergs.resample(result.model, spacing=1)
        self.assertEqual(fine.GetImageData().GetDimensions(), (48, 44, 40))
        like = innergs.resample(result.model, reference=source)
        self.assertEqual(like.GetImageData().GetDimensions(), (24, 22, 20))
        centres = innergs.gaussians(result.model, 20)
        self.assertEqual(centres.GetPolyData().GetNumberOfPoints(), 20)
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "head.innergs"
            innergs.save(result.model, path)
            loaded = innergs.load(path, self.scene)
            self.assertEqual(innergs.query(loaded, [1, 2, 3]), innergs.query(result.model, [1, 2, 3]))

    def test_several_volumes_and_quality(self):
        axial = add_volume(self.scene, "Axial", (30, 28, 12), (1.5, 1.5, 4.0))
        coronal = add_volume(self.scene, "Coronal", (30, 12, 30), (1.5, 4.0, 1.5))
        result = innergs.reconstruct([axial, coronal], preset="fast", thickness=[4.0, 3.5], quality=True, quality_gap=2)
        self.assertEqual(result.table.GetTable().GetNumberOfRows(), 4)
        self.assertEqual(result.volume.GetAttribute("InnerGS.Inputs"), "Axial; Coronal")

    def test_every_volume_may_have_a_mask_of_its_own(self):
        axial = add_volume(self.scene, "Axial", (30, 28, 12), (1.5, 1.5, 4.0))
        coronal = add_volume(self.scene, "Coronal", (30, 12, 30), (1.5, 4.0, 1.5))
        masks = [add_volume(self.scene, name, (12, 12, 12), (3.0, 3.0, 3.0)) for name in ("First", "Second")]
        node = innergs.parameters([axial, coronal], mask=masks)
        self.assertIsNone(node.GetMaskNode())
        self.assertEqual([node.GetInputMaskNode(scan) for scan in (axial, coronal)], masks)
        node = innergs.parameters([axial, coronal], mask=masks[0])
        self.assertEqual(node.GetMaskNode(), masks[0])
        self.assertFalse(node.HasInputMask(axial))
        with self.assertRaisesRegex(innergs.Error, "3 masks for 2 volumes"):
            innergs.parameters([axial, coronal], mask=[*masks, masks[0]])
        with self.assertRaisesRegex(innergs.Error, "'Coronal' has no mask, but other scans have"):
            innergs.reconstruct([axial, coronal], preset="fast", iterations=2, mask=[masks[0], None])

    def test_slices_may_lie_where_matrices_say(self):
        volume = add_volume(self.scene, "Sweep", (30, 28, 12), (1.5, 1.5, 4.0))
        identity = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        poses = innergs.slice_poses([[[1, 0, 0, 0], [0, 1, 0, 0.1 * k], [0, 0, 1, 0], [0, 0, 0, 1]] for k in range(12)], self.scene)
        self.assertEqual(poses.GetNumberOfDataNodes(), 12)
        node = innergs.parameters(volume, slice_poses=poses)
        self.assertEqual(node.GetInputSlicePosesNode(volume), poses)
        result = innergs.reconstruct(volume, preset="fast", iterations=5, slice_poses=poses)
        self.assertIsNotNone(result.volume)
        with self.assertRaisesRegex(innergs.Error, "slice poses"):
            innergs.reconstruct(volume, iterations=5, slice_poses=innergs.slice_poses(3 * [identity], self.scene))
        with self.assertRaisesRegex(innergs.Error, "4x4"):
            innergs.slice_poses([[1, 2, 3]], self.scene)

    def test_slices_of_several_scans_have_transforms(self):
        axial = add_volume(self.scene, "Axial", (30, 28, 12), (1.5, 1.5, 4.0))
        coronal = add_volume(self.scene, "Coronal", (30, 12, 30), (1.5, 4.0, 1.5))
        result = innergs.reconstruct([axial, coronal], preset="fast", iterations=4, sliceMotion="on")
        table = result.slices.GetTable()
        self.assertEqual(table.GetNumberOfRows(), 24)
        transforms = innergs.slice_transforms(result.slices)
        self.assertEqual(len(transforms), 24)
        matrix = vtkMatrix4x4()
        transforms[13].GetMatrixTransformToParent(matrix)
        self.assertEqual(matrix.GetElement(2, 3), table.GetValueByName(13, "M23").ToDouble())
        self.assertEqual(transforms[13].GetName(), "Scan 2 slice 001")
        with self.assertRaisesRegex(innergs.Error, "has no places of slices"):
            innergs.slice_transforms(self.scene.AddNewNodeByClass("vtkMRMLTableNode"))

    def test_held_out_slices_judge_a_second_fit(self):
        source = add_volume(self.scene)
        plain = innergs.reconstruct(source, preset="fast", iterations=10)
        judged = innergs.reconstruct(source, preset="fast", iterations=10, held_out=0.2)
        self.assertTrue(math.isnan(plain.held_out_psnr))
        self.assertLess(judged.held_out_psnr, judged.training_psnr)
        self.assertEqual(judged.training_psnr, plain.training_psnr)
        self.assertEqual(innergs.query(judged.model, [1, 2, 3]), innergs.query(plain.model, [1, 2, 3]))

    def test_uncertainty_is_a_volume_beside_the_result(self):
        source = add_volume(self.scene, "Head", (36, 34, 30), (1.5, 1.5, 2.0))
        result = innergs.reconstruct(source, preset="fast", iterations=10, uncertainty=True, thickness=1, spacing=1.2)
        self.assertIsNotNone(result.uncertainty, result.warnings)
        self.assertEqual(result.uncertainty.GetName(), "Head InnerGS standard deviation")
        self.assertEqual(result.uncertainty.GetImageData().GetDimensions(), result.volume.GetImageData().GetDimensions())
        self.assertEqual(result.measured.GetImageData().GetScalarRange(), (0, 1))
        self.assertEqual(result.measured.GetImageData().GetDimensions(), result.volume.GetImageData().GetDimensions())
        self.assertGreater(result.coverage, 0.8)
        self.assertLessEqual(result.coverage, 1)
        matrix = numpy.eye(4)
        plane = innergs.plane(result.model, matrix, size=(9, 7), spacing=1, uncertainty=True)
        low, high = result.uncertainty.GetImageData().GetScalarRange()
        self.assertTrue(low <= plane.GetImageData().GetScalarRange()[0] <= plane.GetImageData().GetScalarRange()[1] <= high)
        plain = innergs.reconstruct(source, preset="fast", iterations=10)
        self.assertIsNone(plain.uncertainty)
        self.assertIsNone(plain.measured)
        self.assertTrue(math.isnan(plain.coverage))
        with self.assertRaisesRegex(innergs.Error, "is not known"):
            innergs.plane(plain.model, matrix, uncertainty=True)

    def test_background_job(self):
        threads, fractions = set(), []

        def on_progress(job):
            threads.add(threading.current_thread())
            fractions.append(job.progress)

        job = innergs.start(add_volume(self.scene), preset="fast", progress=on_progress)
        self.assertTrue(job.running)
        while job.running:
            time.sleep(0.01)
        self.assertEqual(threads, {threading.main_thread()})
        self.assertEqual(fractions, sorted(fractions))
        self.assertIsNotNone(job.result().model)
        self.assertEqual(job.progress, 1)
        self.assertFalse(innergs.running(self.scene))

    def test_cancel(self):
        source = add_volume(self.scene)
        job = innergs.start(source, iterations=100000)
        with self.assertRaises(TimeoutError):
            job.result(timeout=0)
        job.cancel()
        with self.assertRaises(innergs.Cancelled):
            job.result()
        self.assertEqual(self.scene.GetNumberOfNodesByClass("vtkMRMLScalarVolumeNode"), 1)
        # From its own progress, and all at once.
        with self.assertRaises(innergs.Cancelled):
            innergs.reconstruct(source, iterations=100000, progress=lambda job: job.cancel())
        innergs.start(source, iterations=100000)
        innergs.start(source, iterations=100000)
        innergs.cancel(self.scene)
        self.assertFalse(innergs.running(self.scene))
        self.assertEqual(self.scene.GetNumberOfNodesByClass("vtkMRMLInnerGSParameterNode"), 0)

    def test_preview(self):
        shapes = []

        def on_preview(job):
            image, matrix = job.preview
            shapes.append(image.GetDimensions())
            self.assertNotEqual(matrix.Determinant(), 0)
            job.cancel()

        with self.assertRaises(innergs.Cancelled):
            innergs.reconstruct(add_volume(self.scene), iterations=100000, preview=on_preview)
        self.assertEqual(len(shapes), 1)

    def test_errors_are_sentences(self):
        source = add_volume(self.scene)
        empty = vtkMRMLScalarVolumeNode()
        empty.SetName("Empty")
        self.scene.AddNode(empty)
        nodes = self.scene.GetNumberOfNodes()
        for call, words in (
            (lambda: innergs.reconstruct(None), "Give a node"),
            (lambda: innergs.reconstruct([]), "at least one"),
            (lambda: innergs.reconstruct(vtkMRMLScalarVolumeNode()), "not in a scene"),
            (lambda: innergs.reconstruct(empty), "'Empty' has no voxels"),
            (lambda: innergs.reconstruct(source, spacing=-1), "above 0 mm"),
            (lambda: innergs.reconstruct(source, spacing=1, input_grid=True), "one output grid"),
            (lambda: innergs.reconstruct(source, preset="magic"), "fast|balanced|best|paper"),
            (lambda: innergs.reconstruct(source, colour="red"), "no setting 'colour'"),
            (lambda: innergs.reconstruct(source, plateau_faktor=1), "did you mean plateauFactor"),
            (lambda: innergs.reconstruct(source, cutoff=9), "between 1 and 5"),
            (lambda: innergs.reconstruct(source, seed=-1), "seed"),
            (lambda: innergs.reconstruct(source, gaussians=-1), "Gaussians"),
            (lambda: innergs.reconstruct(source, gaussians="many"), ""),
            (lambda: innergs.reconstruct(source, thickness=[1, 2]), "2 values of thickness"),
            (lambda: innergs.reconstruct(source, instruction_set="none such"), "none such"),
            (lambda: innergs.load("/no/such/file.innergs", self.scene), "file.innergs"),
            (lambda: innergs.query(None, [0, 0, 0]), "Give a node"),
        ):
            with self.assertRaises(innergs.Error) as caught:
                call()
            self.assertIn(words, str(caught.exception))
        self.assertEqual(self.scene.GetNumberOfNodes(), nodes)

    def test_parameter_node(self):
        node = innergs.parameters(add_volume(self.scene), input_grid=True, preset="fast", seed=3, selection="method1",
                                  device="cpu", schedule="plateau", plateau_patience=5, densifyEvery=3, prune_size=9,
                                  cutoff=2.5, beta1=0.75, beta2=0.875, relocate=False, loss=None)
        result = innergs.reconstruct(None, parameter_node=node)
        self.assertIs(node.GetResultVolumeNode(), result.volume)
        used = result.model.GetAttribute("InnerGS.Settings").split("; ")
        for setting in ("seed=3", "selection=method1", "device=cpu", "plateauPatience=5", "densifyEvery=3", "pruneSize=9",
                        "relocate=false", "loss=l2", "cutoff=2.5", "beta1=0.75", "beta2=0.875"):
            self.assertIn(setting, used)

    def test_temporary_parameter_node(self):
        volume = add_volume(self.scene)

        def nodes():
            every = (self.scene.GetNthNodeByClass(n, "vtkMRMLInnerGSParameterNode")
                     for n in range(self.scene.GetNumberOfNodesByClass("vtkMRMLInnerGSParameterNode")))
            return [node for node in every if node is not own]

        def saved():
            with tempfile.TemporaryDirectory() as folder:
                path = pathlib.Path(folder) / "scene.mrml"
                self.scene.SetURL(str(path))
                self.assertTrue(self.scene.Commit(str(path)))
                return path.read_text().count("<InnerGSParameters")

        own = None
        job = innergs.start(volume, iterations=100000)
        made, = nodes()
        self.assertTrue(made.GetHideFromEditors())
        self.assertFalse(made.GetSaveWithScene())
        self.assertTrue(job.running)
        self.assertEqual(saved(), 0)
        job.cancel()
        self.assertEqual(nodes(), [])
        with self.assertRaises(innergs.Error):  # at once
            innergs.reconstruct(volume, held_out=0.9)
        self.assertEqual(nodes(), [])
        self.assertIsNotNone(innergs.reconstruct(volume, iterations=2).model)
        self.assertEqual(nodes(), [])
        empty = add_volume(self.scene, "Nothing")
        vtk_to_numpy(empty.GetImageData().GetPointData().GetScalars())[:] = 0
        with self.assertRaises(innergs.Error):  # by the worker
            innergs.reconstruct(volume, iterations=2, mask=empty)
        self.assertEqual(nodes(), [])
        # One's own is a set like the panel's, and stays.
        own = innergs.parameters(volume, iterations=2)
        self.assertFalse(own.GetHideFromEditors())
        self.assertTrue(own.GetSaveWithScene())
        self.assertIsNotNone(innergs.reconstruct(None, parameter_node=own).model)
        self.assertIs(own.GetScene(), self.scene)
        self.assertEqual(saved(), 1)
        self.scene.Clear(False)

    def test_temporary_parameter_node_of_a_cleared_scene(self):
        job = innergs.start(add_volume(self.scene), iterations=100000)
        self.scene.Clear(False)
        self.assertFalse(job.running)
        self.assertEqual(self.scene.GetNumberOfNodesByClass("vtkMRMLInnerGSParameterNode"), 0)

    def test_estimate(self):
        volume = add_volume(self.scene)
        nodes = self.scene.GetNumberOfNodes()
        few = innergs.estimate(volume, preset="fast", iterations=10, device="cpu")
        many = innergs.estimate(volume, preset="fast", iterations=100000, device="cpu")
        self.assertGreater(few.seconds, 0)
        self.assertGreater(many.seconds, 5 * few.seconds)
        self.assertGreater(few.bytes, 100000)
        self.assertIn("as asked", few.device)
        with self.assertRaises(innergs.Error) as caught:
            innergs.estimate(volume, held_out=0.9)
        self.assertEqual(self.scene.GetNumberOfNodes(), nodes)
        with self.assertRaisesRegex(innergs.Error, "not both"):
            innergs.estimate(volume, parameter_node=innergs.parameters(volume))
        self.assertEqual(innergs.reconstruct(volume, iterations=2, device="cpu").model.GetAttribute("InnerGS.Device"), "cpu")
        job = innergs.start(volume, iterations=5, device="cpu")
        job.result()
        self.assertEqual(job.device, few.device)

    def test_scene_cleared_and_dropped_while_running(self):
        job = innergs.start(add_volume(self.scene), iterations=100000)
        self.scene.Clear(False)
        with self.assertRaises(innergs.Cancelled):
            job.result()
        scene = vtkMRMLScene()
        innergs.start(add_volume(scene), iterations=100000)
        del scene
        gc.collect()

    def test_event_call_data(self):
        kinds = []

        def on_event(caller, event, job):
            kinds.append(job.GetStateAsString(job.GetState()))

        on_event.CallDataType = VTK_OBJECT
        self.logic.AddObserver(self.logic.JobFinishedEvent, on_event)
        innergs.reconstruct(add_volume(self.scene), preset="fast")
        self.assertEqual(kinds, ["Finished"])

    def test_interpreter_ends_while_running(self):
        code = ("import sys; sys.path[:0] = %r\n"
                "import test_innergs as t, innergs\n"
                "scene = t.vtkMRMLScene(); innergs.logic(scene)\n"
                "job = innergs.start(t.add_volume(scene), iterations=100000)\n"
                "print('started', job.running)\n" % sys.path)
        done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=600,
                              cwd=pathlib.Path(__file__).parent)
        self.assertEqual((done.returncode, done.stdout), (0, "started True\n"), done.stderr)

    def test_slice_axis(self):
        sagittal = add_volume(self.scene, "Sagittal", (12, 26, 26), (2.0, 2.0, 2.0))
        axial = add_volume(self.scene, "Axial")
        node = innergs.parameters([sagittal, axial], axis=[0, None], profile=["gaussian", "box"], thickness=[3, 2])
        self.assertEqual([node.GetInputSliceAxis(volume) for volume in (sagittal, axial)], [0, node.Automatic])
        self.assertEqual([node.GetInputSliceThickness(volume) for volume in (sagittal, axial)], [3, 2])
        self.assertEqual(node.GetInputSliceProfile(sagittal), node.GaussianProfile)
        self.assertEqual(innergs.parameters(sagittal, axis=1).GetInputSliceAxis(sagittal), 1)
        innergs.reconstruct(sagittal, axis=0, preset="fast")
        for choice in ({"axis": 3}, {"axis": "I"}, {"axis": [0, 1]}, {"profile": "square"}):
            with self.assertRaisesRegex(innergs.Error, next(iter(choice))):
                innergs.parameters(sagittal, **choice)


if __name__ == "__main__":
    unittest.main()
