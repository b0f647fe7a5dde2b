"""Drives the module's panel in the application as a person does: chooses a volume, reconstructs, cancels, looks at
what was made, saves and reopens the scene, and closes the scene while a reconstruction runs."""

import os
import tempfile
import time
import unittest

import numpy as np
import qt
import slicer
import vtk


def until(condition, seconds=120.0):
    """Lets the application's events be handled until the condition holds; whether it does."""
    end = time.time() + seconds
    while time.time() < end:
        slicer.app.processEvents()
        if condition():
            return True
        time.sleep(0.01)
    return bool(condition())


def ball(name="Ball", spacing=(1.5, 1.5, 4.0), size=(40, 40, 14)):
    """An oblique scan of a bright ball with a dark core, in thick slices; a window of its own."""
    matrix = vtk.vtkMatrix4x4()
    turn = vtk.vtkTransform()
    turn.RotateX(12)
    turn.RotateZ(7)
    turn.Scale(*spacing)
    turn.Translate(-0.5 * (size[0] - 1), -0.5 * (size[1] - 1), -0.5 * (size[2] - 1))
    turn.GetMatrix(matrix)
    k, j, i = np.meshgrid(*(np.arange(n) for n in reversed(size)), indexing="ij")
    distance = np.sqrt(sum(((index - 0.5 * (n - 1)) * s) ** 2 for index, n, s in zip((i, j, k), size, spacing)))
    voxels = 1000 / (1 + np.exp((distance - 22) / 1.5)) - 600 / (1 + np.exp((distance - 9) / 1.5))
    node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLScalarVolumeNode", name)
    node.SetIJKToRASMatrix(matrix)
    slicer.util.updateVolumeFromArray(node, voxels.astype(np.int16))
    node.CreateDefaultDisplayNodes()
    node.GetDisplayNode().SetAutoWindowLevel(False)
    node.GetDisplayNode().SetWindowLevel(870, 430)
    return node


class InnerGSModuleTest(unittest.TestCase):
    def setUp(self):
        slicer.mrmlScene.Clear(0)
        slicer.util.selectModule("Data")  # enters the module anew below
        self.volume = ball()
        slicer.util.setSliceViewerLayers(background=self.volume, fit=True)
        slicer.util.selectModule("InnerGS")
        slicer.app.processEvents()
        self.panel = slicer.modules.innergs.widgetRepresentation()
        self.logic = slicer.modules.innergs.logic()

    def tearDown(self):
        self.logic.Cancel()
        slicer.mrmlScene.Clear(0)

    def find(self, name):
        found = slicer.util.findChildren(self.panel, name=name)
        self.assertTrue(found, "The panel has no widget '%s'" % name)
        return found[0]

    @property
    def parameters(self):
        return self.find("ParameterNodeComboBox").currentNode()

    def quick(self):
        """Settings for a fit of a second or two, as a person would choose them in the panel."""
        self.find("preset").setCurrentIndex(0)
        self.find("evaluateQuality").setChecked(False)
        slicer.app.processEvents()

    def start(self):
        button = self.find("reconstruct")
        self.assertTrue(until(lambda: button.enabled, 10), self.find("refusal").toolTip)
        button.click()
        self.assertTrue(until(lambda: "ancel" in button.text, 10), "The button did not become Cancel")

    def ended(self):
        return "econstruct" in self.find("reconstruct").text

    def background(self, view="Red"):
        layers = slicer.app.layoutManager().sliceWidget(view).sliceLogic().GetSliceCompositeNode()
        return layers.GetBackgroundVolumeID()

    def test_module(self):
        module = slicer.modules.innergs
        self.assertEqual(module.title, "InnerGS")
        self.assertEqual(list(module.categories), ["Tomographic Reconstruction"])
        self.assertIn("not a medical device", module.helpText)
        self.assertEqual(self.logic.GetClassName(), "vtkSlicerInnerGSLogic")

    def test_the_volume_in_the_views_is_the_first_input(self):
        self.assertEqual(self.parameters.GetInputVolumeNode(0), self.volume)

    def test_reconstruct_shows_and_keeps(self):
        self.quick()
        before = slicer.app.layoutManager().sliceWidget("Red").sliceLogic().GetSliceNode().GetFieldOfView()
        self.start()
        self.assertTrue(until(self.ended), "The reconstruction did not end")
        result, model = self.parameters.GetResultVolumeNode(), self.parameters.GetResultModelNode()
        self.assertIsNotNone(result)
        self.assertGreater(model.GetModel().GetNumberOfGaussians(), 0)
        # Where and what it was: isotropic at the finest spacing, the ball's value at its shell and core.
        np.testing.assert_allclose(result.GetSpacing(), (1.5, 1.5, 1.5), atol=1e-6)
        self.assertAlmostEqual(self.logic.GetValueAtRAS(model, 0, 0, 0), 400, delta=80)
        self.assertAlmostEqual(self.logic.GetValueAtRAS(model, 15, 0, 0), 1000, delta=120)
        # At once in all slice views, with the scan's window, and the views where they were.
        for view in ("Red", "Yellow", "Green"):
            self.assertEqual(self.background(view), result.GetID())
        self.assertEqual((result.GetDisplayNode().GetWindow(), result.GetDisplayNode().GetLevel()), (870, 430))
        after = slicer.app.layoutManager().sliceWidget("Red").sliceLogic().GetSliceNode().GetFieldOfView()
        self.assertEqual(before, after)
        # Beside the scan in the Data module's tree, under an item of its own kind.
        tree = slicer.mrmlScene.GetSubjectHierarchyNode()
        item = tree.GetItemByDataNode(model)
        self.assertEqual(tree.GetItemOwnerPluginName(item), "InnerGSModel")
        # 3D on a button.
        button = self.find("VolumeRenderingButton")
        self.assertTrue(button.enabled)
        button.click()
        rendering = slicer.modules.volumerendering.logic().GetFirstVolumeRenderingDisplayNode(result)
        self.assertTrue(rendering.GetVisibility())
        button.click()
        self.assertFalse(rendering.GetVisibility())

    def test_cancel_and_again(self):
        self.find("preset").setCurrentIndex(2)
        self.start()
        began = time.time()
        self.find("reconstruct").click()
        self.assertLess(time.time() - began, 0.2, "The button waits")
        self.assertTrue(until(self.ended, 10))
        self.assertIsNone(self.parameters.GetResultVolumeNode())
        self.quick()
        self.start()
        self.assertTrue(until(self.ended))
        self.assertIsNotNone(self.parameters.GetResultVolumeNode())

    def test_several_sets_and_their_restoring(self):
        sets = self.find("ParameterNodeComboBox")
        first = self.parameters
        self.assertTrue(first.GetEvaluateQuality())  # as the panel proposes
        self.quick()
        self.assertEqual(first.GetPreset(), first.Fast)  # the panel writes the node
        second = sets.addNode()
        self.assertTrue(second.GetEvaluateQuality())
        self.assertEqual(self.find("preset").currentIndex, 1)  # and shows the other one
        second.SetPreset(second.Best)
        second.SetInputVolumeNode(self.volume)
        second.SetInputSliceThickness(self.volume, 3.5)
        slicer.app.processEvents()
        self.assertEqual(self.find("preset").currentIndex, 2)  # follows a script
        self.assertAlmostEqual(self.find("sliceThickness").value, 3.5)
        sets.setCurrentNode(first)
        self.assertEqual(self.find("preset").currentIndex, 0)
        sets.setCurrentNode(second)
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "scene.mrb")
            self.assertTrue(slicer.util.saveScene(scene))
            slicer.mrmlScene.Clear(0)
            slicer.app.processEvents()
            slicer.util.loadScene(scene, {"clear": True})
            slicer.app.processEvents()
        names = sorted(node.GetPreset() for node in slicer.util.getNodesByClass("vtkMRMLInnerGSParameterNode"))
        self.assertEqual(names, [first.Fast, first.Best])
        best = [n for n in slicer.util.getNodesByClass("vtkMRMLInnerGSParameterNode") if n.GetPreset() == n.Best][0]
        sets.setCurrentNode(best)
        slicer.app.processEvents()
        self.assertEqual(self.find("preset").currentIndex, 2)
        self.assertAlmostEqual(self.find("sliceThickness").value, 3.5)
        self.assertEqual(best.GetInputVolumeNode(0).GetName(), "Ball")

    def test_scene_closed_while_running(self):
        self.find("preset").setCurrentIndex(2)
        self.start()
        until(lambda: self.logic.GetLastJob().GetState() == 1, 20)
        slicer.mrmlScene.Clear(0)
        self.assertTrue(until(self.ended, 10), "The panel still waits")
        self.assertFalse(self.logic.IsRunning())
        self.assertIsNotNone(self.parameters)  # a new set, for the next volume
        self.assertEqual(self.parameters.GetNumberOfInputVolumeNodes(), 0)
        self.assertTrue(until(lambda: not self.find("reconstruct").enabled, 5))

    def test_input_removed_while_running(self):
        self.quick()
        self.start()
        slicer.mrmlScene.RemoveNode(self.volume)
        self.assertTrue(until(self.ended))
        self.assertIsNotNone(self.parameters.GetResultVolumeNode())

    def test_parameter_set_removed_while_running(self):
        self.find("preset").setCurrentIndex(2)
        self.start()
        slicer.mrmlScene.RemoveNode(self.parameters)
        self.assertTrue(until(self.ended, 10))
        self.assertFalse(self.logic.IsRunning())

    def test_leave_the_module_while_running(self):
        self.quick()
        self.start()
        slicer.util.selectModule("Data")
        self.assertTrue(until(self.ended))
        slicer.util.selectModule("InnerGS")
        self.assertIsNotNone(self.parameters.GetResultVolumeNode())

    def test_slice_view_and_plane_follow_each_other(self):
        self.quick()
        self.start()
        self.assertTrue(until(self.ended))
        red = slicer.mrmlScene.GetNodeByID("vtkMRMLSliceNodeRed")
        self.find("QuerySection").collapsed = False
        self.find("SliceViewComboBox").setCurrentNode(red)
        shown = self.find("ModelInViewCheckBox")
        shown.setChecked(True)
        followed = slicer.mrmlScene.GetNodeByID(self.background())
        self.assertTrue(self.logic.IsFollowing(followed))
        red.SetOrientationToCoronal()
        red.JumpSliceByOffsetting(0, 15, 0)
        until(lambda: False, 0.5)
        matrix = vtk.vtkMatrix4x4()
        followed.GetIJKToRASMatrix(matrix)
        normal = np.array([matrix.GetElement(a, 2) for a in range(3)])
        self.assertAlmostEqual(abs(normal[1]) / np.linalg.norm(normal), 1, places=5)
        shown.setChecked(False)
        self.assertNotEqual(self.background(), followed.GetID())
        self.find("SliceViewComboBox").setCurrentNode(None)

    def test_model_files(self):
        self.quick()
        self.start()
        self.assertTrue(until(self.ended))
        model = self.parameters.GetResultModelNode()
        with tempfile.TemporaryDirectory() as folder:
            for name in ("ball.innergs", "ball.ply"):
                file = os.path.join(folder, name)
                self.assertTrue(slicer.util.saveNode(model, file), name)
                if name.endswith(".innergs"):
                    self.assertEqual(slicer.app.coreIOManager().fileType(file), "InnerGSModelFile")
                loaded = slicer.util.loadNodeFromFile(file, "InnerGSModelFile")
                self.assertEqual(loaded.GetModel().GetNumberOfGaussians(), model.GetModel().GetNumberOfGaussians())
            bad = os.path.join(folder, "bad.innergs")
            with open(bad, "w") as file:
                file.write("nothing")
            count = slicer.mrmlScene.GetNumberOfNodesByClass("vtkMRMLInnerGSModelNode")
            self.assertFalse(slicer.app.coreIOManager().loadNodes("InnerGSModelFile", {"fileName": bad}))
            self.assertEqual(count, slicer.mrmlScene.GetNumberOfNodesByClass("vtkMRMLInnerGSModelNode"))

    def test_python_package(self):
        import innergs

        self.assertEqual(innergs.logic(), self.logic)
        result = innergs.reconstruct(self.volume, spacing=2.0, preset="fast")
        np.testing.assert_allclose(result.volume.GetSpacing(), (2, 2, 2), atol=1e-6)
        values = innergs.query(result.model, [[0, 0, 0], [15, 0, 0]])
        np.testing.assert_allclose(values, [400, 1000], atol=120)
        import vtkInnerGSPython

        self.assertTrue(isinstance(result.model.GetModel(), vtkInnerGSPython.vtkInnerGSModel))

    def test_ellipsoids(self):
        self.quick()
        self.start()
        self.assertTrue(until(self.ended))
        self.find("ModelSection").collapsed = False
        self.find("modelEllipsoids").click()
        self.assertTrue(until(lambda: self.meshes()))
        mesh = self.meshes()[0]
        self.assertTrue(mesh.GetDisplayVisibility())
        self.assertTrue(self.find("modelEllipsoids").checked)
        self.assertGreater(mesh.GetPolyData().GetNumberOfPolys(), 1000)
        # Those of a model that is made again follow.
        before = mesh.GetPolyData()
        self.parameters.SetOutputModelNode(mesh.GetNodeReference("InnerGSModel"))
        self.parameters.SetNumberOfGaussians(300)
        self.start()
        self.assertTrue(until(self.ended))
        self.assertTrue(until(lambda: mesh.GetPolyData() != before))
        self.assertEqual(self.meshes(), [mesh])
        self.find("modelEllipsoids").click()
        self.assertFalse(mesh.GetDisplayVisibility())

    def meshes(self):
        nodes = slicer.util.getNodesByClass("vtkMRMLModelNode")
        return [n for n in nodes if n.GetNodeReference("InnerGSModel") and n.GetPolyData()]

    def test_a_script_keeps_its_parameters_once_the_module_is_left(self):
        slicer.util.selectModule("Data")
        node = self.parameters
        node.SetOutputGrid(node.SpacingGrid)
        node.SetOutputSpacing(0.9375)
        node.SetPreset(node.Best)
        node.SetSeed(7)
        ball("Another")
        until(lambda: False, 0.8)
        self.assertEqual((node.GetOutputSpacing(), node.GetPreset(), node.GetSeed()), (0.9375, node.Best, 7))
        self.assertEqual(node.GetOutputGrid(), node.SpacingGrid)
        slicer.util.selectModule("InnerGS")
        self.assertEqual(self.find("preset").currentIndex, 2)

    def test_a_volume_that_is_put_right_can_be_reconstructed(self):
        button = self.find("reconstruct")
        self.assertTrue(until(lambda: button.enabled, 10))
        bend = self.bend()
        self.volume.SetAndObserveTransformNodeID(bend.GetID())
        self.assertTrue(until(lambda: not button.enabled, 10))
        self.assertIn("bends", button.toolTip)
        self.volume.SetAndObserveTransformNodeID(None)
        self.assertTrue(until(lambda: button.enabled, 10))
        # The slow parts of the estimate come by themselves.
        self.assertTrue(until(lambda: self.find("deviceReason").text, 30))

    def bend(self, name="Bend"):
        grid = vtk.vtkGridTransform() if not hasattr(slicer, "vtkOrientedGridTransform") else None
        grid = grid or slicer.vtkOrientedGridTransform()
        field = vtk.vtkImageData()
        field.SetDimensions(3, 3, 3)
        field.SetOrigin(-60, -60, -60)
        field.SetSpacing(60, 60, 60)
        field.AllocateScalars(vtk.VTK_DOUBLE, 3)
        field.GetPointData().GetScalars().Fill(0)
        field.SetScalarComponentFromDouble(1, 1, 1, 0, 5)
        grid.SetDisplacementGridData(field)
        node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLGridTransformNode", name)
        node.SetAndObserveTransformFromParent(grid)
        return node

    def transforms(self):
        """One of each kind that a model may lie under."""
        add = slicer.mrmlScene.AddNewNodeByClass
        turn = vtk.vtkTransform()
        turn.Translate(4, -3, 2)
        turn.RotateWXYZ(33, 1, 2, 0.5)
        turned = add("vtkMRMLLinearTransformNode", "Turned")
        turned.SetMatrixTransformToParent(turn.GetMatrix())
        matrix = vtk.vtkMatrix4x4()
        matrix.DeepCopy((1.2, 0.4, 0, 3, 0, 0.9, 0.1, -2, 0, 0, -1, 1, 0, 0, 0, 1))
        sheared = add("vtkMRMLLinearTransformNode", "Sheared")
        sheared.SetMatrixTransformToParent(matrix)
        source, target = vtk.vtkPoints(), vtk.vtkPoints()
        for point in ((-30, -30, -30), (30, -30, -30), (-30, 30, -30), (-30, -30, 30), (30, 30, 30), (0, 0, 0)):
            source.InsertNextPoint(point)
            target.InsertNextPoint(point[0] + 4, point[1] - 2, point[2] + (5 if point == (0, 0, 0) else 0))
        spline = vtk.vtkThinPlateSplineTransform()
        spline.SetBasisToR()
        spline.SetSourceLandmarks(source)
        spline.SetTargetLandmarks(target)
        bent = add("vtkMRMLTransformNode", "Bent by points")
        bent.SetAndObserveTransformToParent(spline)
        both = self.bend("Bend in turned")
        both.SetAndObserveTransformNodeID(turned.GetID())
        return [None, turned, sheared, self.bend(), bent, both]

    def expected(self, volume, model):
        """Values at some pixels of a plane: of the model at the points that its transform takes them from."""
        fixed = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLInnerGSModelNode", "Fixed")
        fixed.SetModel(model.GetModel())
        matrix, columns = vtk.vtkMatrix4x4(), volume.GetImageData().GetDimensions()[0]
        volume.GetIJKToRASMatrix(matrix)
        place = vtk.vtkGeneralTransform()
        if model.GetParentTransformNode():
            model.GetParentTransformNode().GetTransformFromWorld(place)
        points, pixels = vtk.vtkPoints(), range(0, volume.GetImageData().GetNumberOfPoints(), 23)
        points.SetDataTypeToDouble()
        for n in pixels:
            at = matrix.MultiplyPoint((n % columns, n // columns, 0, 1))[:3]
            points.InsertNextPoint(place.TransformPoint(at))
        values = vtk.vtkFloatArray()
        self.assertTrue(self.logic.GetValuesAtRAS(fixed, points, values))
        slicer.mrmlScene.RemoveNode(fixed)
        return np.array([values.GetValue(n) for n in range(len(pixels))]), list(pixels)

    def assertShows(self, volume, model):
        expected, pixels = self.expected(volume, model)
        np.testing.assert_allclose(slicer.util.arrayFromVolume(volume).ravel()[pixels], expected, atol=0.5)
        self.assertGreater(expected.max() - expected.min(), 300, "The plane shows nothing of the ball")

    def exported(self):
        """The plane of the panel as a volume."""
        before = set(slicer.util.getNodesByClass("vtkMRMLScalarVolumeNode"))
        made = lambda: set(slicer.util.getNodesByClass("vtkMRMLScalarVolumeNode")) - before
        self.find("queryExportVolume").click()
        self.assertTrue(until(made, 20))
        return made().pop()

    def test_planes_of_models_under_transforms(self):
        self.quick()
        self.start()
        self.assertTrue(until(self.ended))
        self.find("QuerySection").collapsed = False
        model, message = self.parameters.GetResultModelNode(), self.find("TransformMessageLabel")
        gaussians, view = model.GetModel(), self.find("queryView")
        red = slicer.mrmlScene.GetNodeByID("vtkMRMLSliceNodeRed")
        self.find("SliceViewComboBox").setCurrentNode(red)
        self.find("ModelInViewCheckBox").setChecked(True)
        turn = vtk.vtkTransform()
        turn.RotateWXYZ(20, 1, 1, 0)
        red.GetSliceToRAS().DeepCopy(turn.GetMatrix())
        red.UpdateMatrices()
        followed = slicer.mrmlScene.GetNodeByID(self.background())
        for transform in self.transforms():
            with self.subTest(transform=transform.GetName() if transform else "None"):
                until(lambda: False, 1)  # the plane is at rest
                before = view.grab().toImage()
                model.SetAndObserveTransformNodeID(transform.GetID() if transform else None)
                if transform:
                    self.assertTrue(until(lambda: view.grab().toImage() != before, 10), "The plane stays as it was")
                self.assertFalse(message.visible, message.text)
                self.assertShows(self.exported(), model)
                self.assertShows(followed, model)
                self.assertShows(self.logic.QueryPlane(model, turn.GetMatrix(), 60, 50, 1.0), model)
        # It follows a transform that is moved, and nothing was hardened.
        turned = slicer.util.getNode("Turned")
        model.SetAndObserveTransformNodeID(turned.GetID())
        until(lambda: False, 1)
        before = view.grab().toImage()
        turned.SetMatrixTransformToParent(turn.GetMatrix())
        self.assertTrue(until(lambda: view.grab().toImage() != before, 10))
        self.assertShows(self.exported(), model)
        self.assertEqual(model.GetModel(), gaussians)
        # One that cannot be inverted shows nothing.
        flat = vtk.vtkMatrix4x4()
        flat.SetElement(2, 2, 0)
        turned.SetMatrixTransformToParent(flat)
        self.assertTrue(until(lambda: message.visible, 10))
        self.assertIn("cannot be inverted", message.text)
        turned.SetMatrixTransformToParent(turn.GetMatrix())
        self.assertTrue(until(lambda: not message.visible, 10))
        self.find("SliceViewComboBox").setCurrentNode(None)

    def test_the_plane_in_3d(self):
        self.quick()
        self.start()
        self.assertTrue(until(self.ended))
        self.find("QuerySection").collapsed = False
        planes = lambda: [n for n in slicer.util.getNodesByClass("vtkMRMLModelNode") if n.GetName() == "InnerGS plane"]
        self.assertEqual(planes(), [])
        shown = self.find("PlaneIn3DCheckBox")
        shown.setChecked(True)
        self.assertTrue(until(planes, 10))
        node = planes()[0]
        self.assertTrue(node.GetHideFromEditors() and not node.GetSaveWithScene())
        self.assertFalse(node.GetDisplayNode().GetSaveWithScene())
        tree = slicer.mrmlScene.GetSubjectHierarchyNode()
        self.assertEqual(tree.GetItemByDataNode(node), 0)
        # It lies where the plane does, and goes with it.
        red = slicer.mrmlScene.GetNodeByID("vtkMRMLSliceNodeRed")
        self.find("SliceViewComboBox").setCurrentNode(red)
        red.SetOrientationToAxial()
        red.SetSliceOffset(7)
        level = lambda: (node.GetPolyData().GetBounds()[4], node.GetPolyData().GetBounds()[5])
        self.assertTrue(until(lambda: np.allclose(level(), 7, atol=0.01), 10), level())
        self.assertGreater(node.GetPolyData().GetBounds()[1] - node.GetPolyData().GetBounds()[0], 50)
        # With the picture on it, in the panel's window.
        node.GetDisplayNode().GetTextureImageDataConnection().GetProducer().Update()
        picture = node.GetDisplayNode().GetTextureImageDataConnection().GetProducer().GetOutput()
        self.assertLess(picture.GetScalarRange()[0], 10)
        self.assertEqual(picture.GetScalarRange()[1], 255)
        # Not while another module is shown, nor a closed section; and no more when it is not wanted.
        slicer.util.selectModule("Data")
        self.assertEqual(planes(), [])
        slicer.util.selectModule("InnerGS")
        self.assertTrue(until(planes, 10))
        self.find("QuerySection").collapsed = True
        self.assertEqual(planes(), [])
        self.find("QuerySection").collapsed = False
        self.assertTrue(until(planes, 10))
        slicer.mrmlScene.Clear(0)
        until(lambda: False, 0.5)
        self.assertEqual(planes(), [])
        shown.setChecked(False)

    def combo(self, name):
        return slicer.util.findChildren(self.find(name), className="qMRMLNodeComboBox")[0]

    def test_edits_of_the_mask_and_the_region_are_seen(self):
        button, text = self.find("reconstruct"), self.find("estimateText")
        self.assertTrue(until(lambda: button.enabled, 10))
        mask = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLSegmentationNode", "Mask")
        mask.SetReferenceImageGeometryParameterFromVolumeNode(self.volume)
        self.combo("maskSelector").setCurrentNode(mask)
        self.assertTrue(until(lambda: not button.enabled, 10))
        self.assertIn("is empty", button.toolTip)
        segment = mask.GetSegmentation().AddEmptySegment("Core")
        self.assertTrue(until(lambda: button.enabled, 10), button.toolTip)
        mask.GetSegmentation().RemoveSegment(segment)
        self.assertTrue(until(lambda: not button.enabled, 10))
        self.combo("maskSelector").setCurrentNode(None)
        self.assertTrue(until(lambda: button.enabled, 10))

        region = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsROINode", "Region")
        region.SetCenter(0, 0, 0)
        region.SetSize(50, 50, 40)
        self.combo("regionSelector").setCurrentNode(region)
        self.assertTrue(until(lambda: "MB" in text.text, 10), text.text)
        until(lambda: False, 1)
        before = text.text
        region.SetSize(14, 14, 14)
        self.assertTrue(until(lambda: text.text != before, 10), text.text)
        region.SetCenter(0, 0, 900)
        self.assertTrue(until(lambda: not button.enabled, 10), text.text)
        # What changes while another module is shown is seen when this one is entered again.
        slicer.util.selectModule("Data")
        region.SetCenter(0, 0, 0)
        until(lambda: False, 0.6)
        self.assertFalse(button.enabled, "The hidden panel works")
        slicer.util.selectModule("InnerGS")
        self.assertTrue(until(lambda: button.enabled, 10), button.toolTip)

    def test_other_layers_stay_and_the_log_says_all_once(self):
        self.find("clearLog").click()
        other = ball("Other")
        slicer.util.setSliceViewerLayers(foreground=other, foregroundOpacity=0.5)
        self.quick()
        self.start()
        self.assertTrue(until(self.ended))
        layers = slicer.app.layoutManager().sliceWidget("Red").sliceLogic().GetSliceCompositeNode()
        self.assertEqual(layers.GetForegroundVolumeID(), other.GetID())
        self.assertEqual(self.find("logText").plainText.count("Reconstruction started"), 1)


if __name__ == "__main__":
    unittest.main()
