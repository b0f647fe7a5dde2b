"""Drives the module's panel in the application as a person does: chooses a volume, reconstructs, cancels, looks at
what was made, saves and reopens the scene, and closes the scene while a reconstruction runs."""

import os
import tempfile
import unittest

import numpy as np
import slicer

from InnerGSModuleFixture import ModuleFixture, ball, until


class InnerGSModuleTest(ModuleFixture):
    def test_module(self):
        module = slicer.modules.innergs
        self.assertEqual(module.title, "InnerGS")
        self.assertEqual(list(module.categories), ["Tomographic Reconstruction"])
        self.assertIn("not a medical device", module.helpText)
        self.assertIn("2508.13287", module.acknowledgementText)
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
        # Position and content: isotropic at the finest spacing, with the ball's values at its shell and core.
        np.testing.assert_allclose(result.GetSpacing(), (1.5, 1.5, 1.5), atol=1e-6)
        self.assertAlmostEqual(self.logic.GetValueAtRAS(model, 0, 0, 0), 400, delta=80)
        self.assertAlmostEqual(self.logic.GetValueAtRAS(model, 15, 0, 0), 1000, delta=120)
        # Immediately in all slice views, with the scan's window and the views unchanged.
        for view in ("Red", "Yellow", "Green"):
            self.assertEqual(self.background(view), result.GetID())
        self.assertEqual((result.GetDisplayNode().GetWindow(), result.GetDisplayNode().GetLevel()), (870, 430))
        after = slicer.app.layoutManager().sliceWidget("Red").sliceLogic().GetSliceNode().GetFieldOfView()
        self.assertEqual(before, after)
        # Next to the scan in the Data module's tree, with its own kind of item.
        tree = slicer.mrmlScene.GetSubjectHierarchyNode()
        item = tree.GetItemByDataNode(model)
        self.assertEqual(tree.GetItemOwnerPluginName(item), "InnerGSModel")
        # 3D at the push of a button.
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
        self.assertTrue(until(lambda: self.logic.GetLastJob().GetState() == 1))
        self.find("reconstruct").click()
        self.assertFalse(self.ended(), "The button waits")
        self.assertTrue(until(self.ended))
        self.assertIn("Cancelled", self.said("message"))
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
        self.assertTrue(until(lambda: self.logic.GetLastJob().GetState() == 1))
        slicer.mrmlScene.Clear(0)
        self.assertTrue(until(self.ended), "The panel still waits")
        self.assertFalse(self.logic.IsRunning())
        self.assertIn("the scene ended", self.said("message"))
        self.assertIsNotNone(self.parameters)  # a new set, for the next volume
        self.assertEqual(self.parameters.GetNumberOfInputVolumeNodes(), 0)
        self.assertTrue(until(lambda: not self.find("reconstruct").enabled))

    def test_input_removed_while_running(self):
        self.quick()
        self.start()
        slicer.mrmlScene.RemoveNode(self.volume)
        self.assertTrue(until(self.ended))
        self.assertIsNotNone(self.parameters.GetResultVolumeNode())

    def test_parameter_set_removed_while_running(self):
        self.find("preset").setCurrentIndex(2)
        self.start()
        sets = self.find("ParameterNodeComboBox")
        self.assertFalse(sets.removeEnabled)  # not by the panel
        slicer.mrmlScene.RemoveNode(self.parameters)
        self.assertTrue(until(self.ended))
        self.assertFalse(self.logic.IsRunning())
        self.assertIn("its parameter set ended", self.said("message"))
        self.assertTrue(sets.removeEnabled)

    def test_leave_the_module_while_running(self):
        self.quick()
        self.start()
        slicer.util.selectModule("Data")
        self.assertTrue(until(self.ended))
        slicer.util.selectModule("InnerGS")
        self.assertIsNotNone(self.parameters.GetResultVolumeNode())

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

    def test_the_panel_loads_and_saves_models(self):
        self.reconstruct()
        self.find("ModelSection").collapsed = False
        model, nodes = self.parameters.GetResultModelNode(), lambda: slicer.util.getNodesByClass("vtkMRMLInnerGSModelNode")

        def answer(button, name, file):
            self.find(button).click()
            dialog = self.find(name)
            dialog.fileSelected(file)
            dialog.close()
            until(lambda: False, 0.1)

        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "ball.innergs")
            self.assertIn("Not saved", self.find("modelState").text)
            answer("modelSave", "modelSaveDialog", os.path.join(folder, "ball.ply"))
            self.assertIn("Not saved", self.find("modelState").text)
            answer("modelSave", "modelSaveDialog", file)
            self.assertEqual(self.find("modelState").text, "Saved", self.said("modelMessage"))
            self.assertEqual(model.GetStorageNode().GetFileName(), file)
            self.assertFalse(model.GetModifiedSinceRead())
            answer("modelLoad", "modelLoadDialog", file)
            self.assertEqual(len(nodes()), 2)
            loaded = self.combo("modelSelector").currentNode()
            self.assertNotEqual(loaded, model)
            self.assertEqual(loaded.GetModel().GetNumberOfGaussians(), model.GetModel().GetNumberOfGaussians())
            self.assertEqual(loaded.GetAttribute("InnerGS.Inputs"), "Ball")
            self.assertEqual(self.find("modelState").text, "Saved")
            with open(file, "w") as text:
                text.write("nothing")
            answer("modelLoad", "modelLoadDialog", file)
            self.assertEqual(len(nodes()), 2)
            self.assertIn("ball.innergs", self.said("modelMessage"))

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
        # Those of a model that is replaced are updated.
        before = mesh.GetPolyData()
        self.parameters.SetOutputModelNode(mesh.GetNodeReference("InnerGSModel"))
        self.parameters.SetNumberOfGaussians(300)
        self.start()
        self.assertTrue(until(self.ended))
        self.assertTrue(until(lambda: mesh.GetPolyData() != before))
        self.assertEqual(self.meshes(), [mesh])
        self.find("modelEllipsoids").click()
        self.assertFalse(mesh.GetDisplayVisibility())

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
        self.assertTrue(until(lambda: button.enabled))
        bend = self.bend()
        self.volume.SetAndObserveTransformNodeID(bend.GetID())
        self.assertTrue(until(lambda: not button.enabled))
        self.assertIn("bends", button.toolTip)
        self.volume.SetAndObserveTransformNodeID(None)
        self.assertTrue(until(lambda: button.enabled))
        # The slow parts of the estimate arrive on their own.
        reason = slicer.util.findChildren(self.find("deviceBox"), name="deviceReason")[0]  # dynamic scans have one, too
        self.assertTrue(until(lambda: reason.text))

    def test_edits_of_the_mask_and_the_region_are_seen(self):
        button, text = self.find("reconstruct"), self.find("estimateText")
        self.assertTrue(until(lambda: button.enabled))
        mask = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLSegmentationNode", "Mask")
        mask.SetReferenceImageGeometryParameterFromVolumeNode(self.volume)
        self.combo("maskSelector").setCurrentNode(mask)
        self.assertTrue(until(lambda: not button.enabled))
        self.assertIn("is empty", button.toolTip)
        segment = mask.GetSegmentation().AddEmptySegment("Core")
        self.assertTrue(until(lambda: button.enabled), button.toolTip)
        mask.GetSegmentation().RemoveSegment(segment)
        self.assertTrue(until(lambda: not button.enabled))
        self.combo("maskSelector").setCurrentNode(None)
        self.assertTrue(until(lambda: button.enabled))

        region = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLMarkupsROINode", "Region")
        region.SetCenter(0, 0, 0)
        region.SetSize(50, 50, 40)
        self.combo("regionSelector").setCurrentNode(region)
        self.assertTrue(until(lambda: "MB" in text.text), text.text)
        until(lambda: False, 1)
        before = text.text
        region.SetSize(14, 14, 14)
        self.assertTrue(until(lambda: text.text != before), text.text)
        region.SetCenter(0, 0, 900)
        self.assertTrue(until(lambda: not button.enabled), text.text)
        # Changes made while another module is shown are noticed when this one is entered again.
        slicer.util.selectModule("Data")
        region.SetCenter(0, 0, 0)
        until(lambda: False, 0.6)
        self.assertFalse(button.enabled, "The hidden panel works")
        slicer.util.selectModule("InnerGS")
        self.assertTrue(until(lambda: button.enabled), button.toolTip)

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