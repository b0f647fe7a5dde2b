"""Nodes: results in 3D, ellipsoids, pictures of views, masks of one segment, waiting jobs."""

import os
import tempfile
import unittest
import zipfile

import slicer

from InnerGSModuleFixture import ModuleFixture, until


class InnerGSModuleNodesTest(ModuleFixture):
    def isIn3D(self, volume):
        display = slicer.modules.volumerendering.logic().GetFirstVolumeRenderingDisplayNode(volume)
        return bool(display and display.GetVisibility())

    def test_3d_goes_to_the_new_result(self):
        self.reconstruct()
        first, button = self.parameters.GetResultVolumeNode(), self.find("VolumeRenderingButton")
        button.click()
        self.assertTrue(self.isIn3D(first))
        self.reconstruct()
        second = self.parameters.GetResultVolumeNode()
        self.assertNotEqual(first, second)
        self.assertEqual((self.isIn3D(first), self.isIn3D(second)), (False, True))
        self.assertTrue(button.checked)
        button.click()
        self.assertEqual((self.isIn3D(first), self.isIn3D(second)), (False, False))

    def test_3d_is_of_the_result_made_last(self):
        sets, button = self.find("ParameterNodeComboBox"), self.find("VolumeRenderingButton")
        first = self.parameters
        self.quick()
        self.start()
        other = sets.addNode()
        self.assertTrue(until(self.ended))
        self.assertEqual(self.parameters, other)
        button.click()
        self.assertTrue(self.isIn3D(first.GetResultVolumeNode()))
        # Nor of the set that is chosen later.
        sets.setCurrentNode(first)
        self.assertTrue(button.enabled and button.checked)
        sets.setCurrentNode(other)
        self.assertFalse(button.enabled)

    def test_a_result_is_not_the_next_input(self):
        self.reconstruct()
        self.assertEqual(self.background(), self.parameters.GetResultVolumeNode().GetID())
        self.find("ParameterNodeComboBox").addNode()
        slicer.util.selectModule("Data")
        slicer.util.selectModule("InnerGS")
        self.assertEqual(self.parameters.GetNumberOfInputVolumeNodes(), 0)

    def test_ellipsoids_lie_where_the_model_does_and_go_with_it(self):
        self.reconstruct()
        model = self.parameters.GetResultModelNode()
        points = self.logic.CreateGaussianModel(model, 100)
        made = points.GetPolyData()
        self.find("ModelSection").collapsed = False
        self.find("modelEllipsoids").click()
        self.assertTrue(until(lambda: len(self.meshes()) == 2))
        mesh = [node for node in self.meshes() if node != points][0]
        shown = self.find("modelEllipsoidsShown")
        self.assertTrue(until(lambda: shown.visible))
        self.assertIn("of {:,} Gaussians".format(model.GetModel().GetNumberOfGaussians()), shown.text)
        moved = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLLinearTransformNode", "Moved")
        model.SetAndObserveTransformNodeID(moved.GetID())
        self.assertEqual(mesh.GetParentTransformNode(), moved)
        model.SetAndObserveTransformNodeID(None)
        self.assertIsNone(mesh.GetParentTransformNode())
        display = mesh.GetDisplayNode()
        slicer.mrmlScene.RemoveNode(model)
        present = lambda node: bool(slicer.mrmlScene.IsNodePresent(node))
        self.assertTrue(until(lambda: not present(mesh)))
        self.assertFalse(present(display))
        # A script's own point node is kept.
        self.assertTrue(present(points))
        self.assertEqual(points.GetPolyData(), made)

    def test_the_picture_in_a_view_is_no_volume_of_the_scene(self):
        self.reconstruct()
        red = slicer.mrmlScene.GetNodeByID("vtkMRMLSliceNodeRed")
        self.find("QuerySection").collapsed = False
        self.find("SliceViewComboBox").setCurrentNode(red)
        before = self.background()
        self.find("ModelInViewCheckBox").setChecked(True)
        picture = slicer.mrmlScene.GetNodeByID(self.background())
        self.assertTrue(self.logic.IsFollowing(picture))
        self.assertTrue(picture.GetHideFromEditors())
        for node in (picture, picture.GetDisplayNode()):
            self.assertFalse(node.GetSaveWithScene())
        self.assertEqual(slicer.mrmlScene.GetSubjectHierarchyNode().GetItemByDataNode(picture), 0)
        listed = self.combo("inputSelector")
        self.assertNotIn(picture, [listed.nodeFromIndex(i) for i in range(listed.nodeCount())])
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "scene.mrb")
            self.assertTrue(slicer.util.saveScene(scene))
            self.assertEqual(self.background(), picture.GetID())
            display = picture.GetDisplayNode()
            self.find("ModelInViewCheckBox").setChecked(False)
            self.assertEqual(self.background(), before)
            self.assertFalse(slicer.mrmlScene.IsNodePresent(picture) or slicer.mrmlScene.IsNodePresent(display))
            self.find("SliceViewComboBox").setCurrentNode(None)
            with zipfile.ZipFile(scene) as bundle:
                files = bundle.namelist()
                nodes = bundle.read([name for name in files if name.endswith(".mrml")][0]).decode()
            self.assertNotIn(picture.GetName(), nodes)
            self.assertFalse([name for name in files if picture.GetName() in name])
            slicer.util.loadScene(scene, {"clear": True})
            self.assertTrue(until(lambda: self.find("ModelInViewCheckBox").checked))
        # For what was saved; the view's picture is made again.
        volumes = slicer.util.getNodesByClass("vtkMRMLScalarVolumeNode")
        saved = [node.GetName() for node in volumes if not self.logic.IsFollowing(node)]
        self.assertEqual(len(saved), 2, saved)
        self.assertEqual(len(volumes), 3)
        self.assertTrue(self.logic.IsFollowing(slicer.mrmlScene.GetNodeByID(self.background())))
        self.find("SliceViewComboBox").setCurrentNode(None)

    def segmentation(self, name):
        node = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLSegmentationNode", name)
        node.SetReferenceImageGeometryParameterFromVolumeNode(self.volume)
        return node, [node.GetSegmentation().AddEmptySegment("", n) for n in ("Core", "Shell")]

    def test_a_mask_of_one_segment_is_told_and_can_be_changed(self):
        button, line = self.find("reconstruct"), self.find("MaskSegmentLabel")
        first, segments = self.segmentation("First")
        second, _ = self.segmentation("Second")
        self.assertFalse(line.visible)
        self.parameters.SetMaskNode(first)
        self.parameters.SetMaskSegmentID(segments[1])
        self.assertTrue(until(lambda: line.visible))
        self.assertIn("Shell", line.text)
        # It does not belong to another mask.
        self.combo("maskSelector").setCurrentNode(second)
        self.assertTrue(until(lambda: self.parameters.GetMaskNode() == second))
        self.assertEqual(self.parameters.GetMaskSegmentID(), "")
        self.assertFalse(line.visible)
        self.assertTrue(until(lambda: button.enabled), button.toolTip)
        self.parameters.SetMaskSegmentID(segments[0])
        self.assertTrue(until(lambda: line.visible))
        line.linkActivated("all")
        self.assertEqual(self.parameters.GetMaskSegmentID(), "")
        self.assertFalse(line.visible)

    def test_waits_behind_a_scripts_job(self):
        script = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLInnerGSParameterNode", "Script")
        script.SetHideFromEditors(1)
        script.SetInputVolumeNode(self.volume)
        script.SetPreset(script.Best)
        job = self.logic.StartReconstruction(script)
        self.assertIsNotNone(job)
        self.quick()
        self.start()
        phase = self.find("phaseText")
        self.assertIn("Waiting", phase.text)
        self.logic.Cancel(job)
        self.assertTrue(until(lambda: "Waiting" not in phase.text))
        self.assertTrue(until(self.ended))
        self.assertIsNotNone(self.parameters.GetResultVolumeNode())

    def test_a_device_that_is_not_there_is_refused_beforehand(self):
        button = self.find("reconstruct")
        self.assertTrue(until(lambda: button.enabled))
        self.parameters.SetDevice("cuda:99")
        self.assertTrue(until(lambda: not button.enabled))
        self.assertIn("There is no", self.said("refusal"))
        self.parameters.SetDevice("cpu")
        self.assertTrue(until(lambda: button.enabled), button.toolTip)

    def test_a_set_that_is_chosen_elsewhere_is_not_watched(self):
        sets, preset = self.find("ParameterNodeComboBox"), self.find("preset")
        second = sets.addNode()
        slicer.util.selectModule("Data")
        sets.setCurrentNode(slicer.mrmlScene.GetFirstNodeByClass("vtkMRMLInnerGSParameterNode"))
        sets.setCurrentNode(second)
        shown = preset.currentIndex
        self.assertNotEqual(shown, 2)
        second.SetPreset(second.Best)
        self.volume.SetName("Renamed")
        until(lambda: False, 0.5)
        self.assertEqual(preset.currentIndex, shown, "The panel that is not shown works")
        slicer.util.selectModule("InnerGS")
        self.assertEqual(preset.currentIndex, 2)

    def test_slices_lie_where_a_sequence_of_transforms_says(self):
        import innergs

        places = self.find("slicePosesSelector")
        self.assertFalse(places.visible)
        shift = [[1, 0, 0, 30], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
        poses = innergs.slice_poses([shift] * self.volume.GetImageData().GetDimensions()[2])
        self.assertTrue(until(lambda: places.visible))
        self.parameters.SetInputSlicePosesNode(self.volume, poses)
        self.assertTrue(until(lambda: self.combo("slicePosesSelector").currentNode() == poses))
        self.find("sliceThickness").setValue(3)  # what a script chose stays
        self.assertTrue(until(lambda: self.parameters.GetInputSliceThickness(self.volume) == 3))
        self.assertEqual(self.parameters.GetInputSlicePosesNode(self.volume), poses)
        self.reconstruct()
        bounds, before = [0] * 6, [0] * 6
        self.parameters.GetResultVolumeNode().GetRASBounds(bounds)
        self.volume.GetRASBounds(before)
        self.assertAlmostEqual((bounds[0] + bounds[1] - before[0] - before[1]) / 2, 30, delta=4)

    def test_an_exported_plane_says_where_it_is_from(self):
        self.reconstruct()
        self.find("QuerySection").collapsed = False
        model, tree = self.parameters.GetResultModelNode(), slicer.mrmlScene.GetSubjectHierarchyNode()
        folder = tree.CreateFolderItem(tree.GetSceneItemID(), "Folder")
        tree.SetItemParent(tree.GetItemByDataNode(model), folder)
        volume = self.exported()
        self.assertEqual(volume.GetNodeReference("InnerGSModel"), model)
        self.assertEqual(volume.GetAttribute("InnerGS.Inputs"), "Ball")
        self.assertEqual(volume.GetAttribute("InnerGS.Version"), self.logic.GetVersion())
        self.assertEqual(tree.GetItemParent(tree.GetItemByDataNode(volume)), folder)
        display = volume.GetDisplayNode()
        self.assertFalse(display.GetAutoWindowLevel())
        self.assertAlmostEqual(display.GetWindow(), 870, delta=1)
        self.assertAlmostEqual(display.GetLevel(), 430, delta=1)

    def test_every_alt_key_goes_to_one_place(self):
        def key(text):
            at = text.replace("&&", "  ").find("&")
            return text[at + 1].upper() if at >= 0 else ""

        places = {}
        add = lambda text: places.setdefault(key(text), []).append(text)
        for action in slicer.util.mainWindow().menuBar().actions():
            add(action.text)
        for label in slicer.util.findChildren(self.panel, className="QLabel"):
            if label.buddy():
                add(label.text)
        for kind in ("QPushButton", "QCheckBox", "QToolButton"):
            for button in slicer.util.findChildren(self.panel, className=kind):
                add(button.text)
        places.pop("")
        self.assertEqual([texts for texts in places.values() if len(texts) > 1], [])
        # The first ones in the panel keep theirs.
        self.assertEqual(key(self.find("reconstruct").text), "R")
        self.assertGreater(len(places), 20, places)
        labels = slicer.util.findChildren(self.panel, className="QLabel")
        self.assertTrue(key([label.text for label in labels if label.buddy() == self.find("preset")][0]))


if __name__ == "__main__":
    unittest.main()
