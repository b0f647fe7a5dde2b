"""The panel as volumes and scenes come and go, and before a running fit ends."""

import os
import tempfile
import unittest

import numpy as np
import qt
import slicer
import vtk
from vtk.util.numpy_support import vtk_to_numpy

from InnerGSModuleFixture import ModuleFixture, ball, until


class InnerGSModuleScenesTest(ModuleFixture):
    def reopen(self):
        """Saves the scene and opens it in place of itself."""
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "scene.mrb")
            self.assertTrue(slicer.util.saveScene(scene))
            slicer.util.loadScene(scene, {"clear": True})
            slicer.app.processEvents()

    def answer(self, button, action):
        """Does what leads to a question and answers it; returns the question."""
        asked = []

        def click():
            box = slicer.app.activeModalWidget()
            for one in slicer.util.findChildren(box, className="QPushButton") if box else []:
                if one.text.replace("&", "") == button:
                    asked.append(box.text)
                    return one.click()

        timer = qt.QTimer()
        timer.connect("timeout()", click)
        timer.start(20)
        action()
        timer.stop()
        return " ".join(asked)

    def test_a_volume_that_comes_while_nothing_is_chosen_is_chosen(self):
        slicer.mrmlScene.Clear(0)
        self.assertTrue(until(lambda: self.parameters is not None))
        self.assertEqual(self.parameters.GetNumberOfInputVolumeNodes(), 0)
        empty = slicer.mrmlScene.AddNewNodeByClass("vtkMRMLScalarVolumeNode", "No voxels")
        first = ball("First")
        self.assertTrue(until(lambda: self.parameters.GetInputVolumeNode(0) == first))
        ball("Second")
        self.assertTrue(until(lambda: self.combo("inputSelector").nodeCount() == 3))
        self.assertEqual(self.parameters.GetNumberOfInputVolumeNodes(), 1)
        self.assertEqual(self.parameters.GetInputVolumeNode(0), first)
        slicer.mrmlScene.RemoveNode(empty)
        # Nor is one selected again that the user removed from the list.
        self.combo("inputSelector").setCurrentNode(None)
        first.SetName("Renamed")
        self.assertTrue(until(lambda: self.combo("inputSelector").currentNode() is None))
        self.assertEqual(self.parameters.GetNumberOfInputVolumeNodes(), 0)

    def test_what_is_told_of_a_result_goes_with_its_scene(self):
        self.reconstruct()
        card = self.find("qualityCard")
        self.assertTrue(card.visible)
        slicer.mrmlScene.Clear(0)
        self.assertFalse(card.visible)
        self.assertFalse(self.find("progressCard").visible)

    def test_a_scene_that_is_opened_shows_what_was_chosen(self):
        self.reconstruct()
        self.parameters.GetResultModelNode().SetName("Of the first set")
        sets = self.find("ParameterNodeComboBox")
        sets.addNode().SetName("The second set")
        self.parameters.SetInputVolumeNode(self.volume)
        self.reconstruct()
        self.find("QuerySection").collapsed = False
        self.combo("queryModel").setCurrentNode(slicer.util.getNode("Of the first set"))
        self.reopen()
        self.assertTrue(until(lambda: self.parameters and self.parameters.GetName() == "The second set"))
        self.assertEqual(len(slicer.util.getNodesByClass("vtkMRMLInnerGSParameterNode")), 2)
        for name in ("queryModel", "modelSelector"):
            self.assertTrue(until(lambda: self.combo(name).currentNode() is not None), name)
            self.assertEqual(self.combo(name).currentNode().GetName(), "Of the first set")
        self.assertNotIn("no longer there", self.find("modelFile").text)  # in the bundle

    def test_where_slices_measured_something_is_kept_with_the_scene(self):
        self.parameters.EstimateUncertaintyOn()
        self.parameters.SetInputSliceThickness(self.volume, 2)
        self.reconstruct()
        measured = lambda node: vtk_to_numpy(node.GetImageData().GetPointData().GetArray("Measured"))
        before = measured(self.parameters.GetResultUncertaintyNode()).copy()
        self.assertEqual(set(before), {0, 1})
        self.reopen()
        self.assertTrue(until(lambda: self.parameters and self.parameters.GetResultUncertaintyNode()))
        model = self.parameters.GetResultModelNode()
        self.assertIsNotNone(self.logic.QueryUncertaintyPlane(model, vtk.vtkMatrix4x4(), 8, 8, 1))
        self.assertTrue((measured(self.parameters.GetResultUncertaintyNode()) == before).all())

    def test_a_scene_that_is_added_leaves_what_is_in_use(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = os.path.join(folder, "scene.mrb")
            self.assertTrue(slicer.util.saveScene(scene))
            self.parameters.SetName("In use")
            slicer.util.loadScene(scene)
            slicer.app.processEvents()
        self.assertEqual(len(slicer.util.getNodesByClass("vtkMRMLInnerGSParameterNode")), 2)
        self.assertEqual(self.parameters.GetName(), "In use")

    def test_a_view_that_shows_the_model_does_so_in_the_reopened_scene(self):
        self.reconstruct()
        result = self.parameters.GetResultVolumeNode().GetName()
        self.find("QuerySection").collapsed = False
        shown, views = self.find("ModelInViewCheckBox"), self.find("SliceViewComboBox")
        views.setCurrentNode(slicer.mrmlScene.GetNodeByID("vtkMRMLSliceNodeRed"))
        shown.setChecked(True)
        views.currentNode().SetOrientationToSagittal()
        views.currentNode().SetSliceOffset(6)
        self.reopen()
        self.assertTrue(until(lambda: shown.checked))
        self.assertEqual(views.currentNode().GetLayoutName(), "Red")
        picture = slicer.mrmlScene.GetNodeByID(self.background())
        self.assertTrue(self.logic.IsFollowing(picture))
        self.assertAlmostEqual(views.currentNode().GetSliceOffset(), 6, places=3)
        shown.setChecked(False)
        self.assertEqual(slicer.mrmlScene.GetNodeByID(self.background()).GetName(), result)
        # Once hidden, it is not shown again.
        self.reopen()
        self.assertTrue(until(lambda: self.combo("queryModel").currentNode() is not None))
        self.assertFalse(shown.checked)
        views.setCurrentNode(None)

    def test_a_model_that_is_deleted_is_no_longer_shown(self):
        self.reconstruct()
        self.find("QuerySection").collapsed = False
        shown = self.find("ModelInViewCheckBox")
        self.find("SliceViewComboBox").setCurrentNode(slicer.mrmlScene.GetNodeByID("vtkMRMLSliceNodeRed"))
        before = self.background()
        shown.setChecked(True)
        picture = slicer.mrmlScene.GetNodeByID(self.background())
        slicer.mrmlScene.RemoveNode(self.parameters.GetResultModelNode())
        self.assertTrue(until(lambda: not shown.checked))
        self.assertFalse(shown.enabled)
        self.assertFalse(slicer.mrmlScene.IsNodePresent(picture))
        self.assertEqual(self.background(), before)
        self.find("SliceViewComboBox").setCurrentNode(None)

    def test_a_new_region_is_an_outline(self):
        region = self.combo("regionSelector").addNode()
        display = region.GetDisplayNode()
        self.assertFalse(display.GetFillVisibility())
        self.assertTrue(display.GetOutlineVisibility())
        bounds = [0.0] * 6
        self.volume.GetRASBounds(bounds)
        self.assertAlmostEqual(region.GetSize()[0], bounds[1] - bounds[0], places=3)

    def test_3d_views_that_nobody_moved_are_framed_on_the_result(self):
        camera = slicer.util.getNodesByClass("vtkMRMLCameraNode")[0]
        camera.SetFocalPoint(0, 0, 0)
        camera.SetPosition(0, 500, 0)
        origin = np.array(self.volume.GetOrigin()) + (80, 0, 40)
        self.volume.SetOrigin(*origin)
        self.reconstruct()
        bounds = [0.0] * 6
        self.parameters.GetResultVolumeNode().GetRASBounds(bounds)
        middle = [(bounds[2 * a] + bounds[2 * a + 1]) / 2 for a in range(3)]
        np.testing.assert_allclose(camera.GetFocalPoint(), middle, atol=1e-3)
        camera.SetFocalPoint(10, 20, 30)
        self.reconstruct()
        np.testing.assert_allclose(camera.GetFocalPoint(), (10, 20, 30))

    def test_a_person_is_asked_before_a_running_fit_is_ended(self):
        window = slicer.util.mainWindow()
        self.assertIsNotNone(window)
        closeScene = slicer.util.findChildren(window, name="FileCloseSceneAction")[0]
        self.find("preset").setCurrentIndex(2)
        self.start()
        self.assertIn("is running", self.answer("Keep Running", window.close))
        self.assertTrue(window.visible)
        self.assertIn("close the scene", self.answer("Keep Running", closeScene.trigger))
        self.assertTrue(slicer.mrmlScene.IsNodePresent(self.volume))
        self.assertFalse(self.ended())

    def dicomSeries(self, folder):
        """Eight slices of 3 mm, 4 mm apart."""
        import pydicom
        from pydicom.uid import ExplicitVRLittleEndian, generate_uid

        study, series = generate_uid(), generate_uid()
        for n in range(8):
            meta = pydicom.dataset.FileMetaDataset()
            meta.MediaStorageSOPClassUID = "1.2.840.10008.5.1.4.1.1.4"
            meta.MediaStorageSOPInstanceUID = generate_uid()
            meta.TransferSyntaxUID = ExplicitVRLittleEndian
            slice = pydicom.dataset.FileDataset(None, {}, file_meta=meta, preamble=b"\0" * 128)
            slice.is_little_endian, slice.is_implicit_VR = True, False
            slice.SOPClassUID, slice.SOPInstanceUID = meta.MediaStorageSOPClassUID, meta.MediaStorageSOPInstanceUID
            slice.PatientName, slice.PatientID, slice.Modality = "Ball", "InnerGS", "MR"
            slice.StudyInstanceUID, slice.SeriesInstanceUID = study, series
            slice.SeriesNumber, slice.InstanceNumber = 1, n + 1
            slice.SliceThickness, slice.SpacingBetweenSlices = "3", "4"
            slice.AcquisitionTime = "1015%02d" % (n // 2 + 30 * (n % 2))  # even slices, then odd ones
            slice.PixelSpacing, slice.ImageOrientationPatient = ["1.5", "1.5"], ["1", "0", "0", "0", "1", "0"]
            slice.ImagePositionPatient = ["0", "0", str(4 * n)]
            slice.Rows = slice.Columns = 16
            slice.SamplesPerPixel, slice.PhotometricInterpretation = 1, "MONOCHROME2"
            slice.BitsAllocated = slice.BitsStored = 16
            slice.HighBit, slice.PixelRepresentation = 15, 1
            slice.PixelData = (100 * n + np.arange(256, dtype=np.int16)).astype(np.int16).tobytes()
            slice.save_as(os.path.join(folder, "%d.dcm" % n), write_like_original=False)

    @unittest.skipUnless(hasattr(slicer, "dicomDatabase"), "This Slicer was built without DICOM")
    def test_slice_thickness_and_order_are_what_the_dicom_files_say(self):
        from DICOMLib import DICOMUtils

        with tempfile.TemporaryDirectory() as folder:
            self.dicomSeries(folder)
            with DICOMUtils.TemporaryDICOMDatabase() as database:
                DICOMUtils.importDicom(folder, database)
                loaded = DICOMUtils.loadPatientByUID(database.patients()[0])
                volume = slicer.mrmlScene.GetNodeByID(loaded[0])
                self.assertAlmostEqual(volume.GetSpacing()[2], 4, places=3)
                self.assertAlmostEqual(self.logic.GetDicomSliceThickness(volume), 3)
                self.combo("inputSelector").setCurrentNode(volume)
                field = self.find("sliceThickness")
                self.assertTrue(until(lambda: "3 mm" in field.text), field.text)
                self.assertIn("as the file says", self.find("inputDescription").text)
                self.assertEqual(self.logic.GetNumberOfInterleavedPasses(volume), 2)
                self.assertIn("2 interleaved passes", self.find("inputDescription").text)


if __name__ == "__main__":
    unittest.main()
