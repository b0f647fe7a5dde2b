"""Planes of models in the application: in a slice view, under transforms, in 3D views."""

import unittest

import numpy as np
import slicer
import vtk

from InnerGSModuleFixture import ModuleFixture, until


class InnerGSModulePlanesTest(ModuleFixture):
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

    def transforms(self):
        """One of each kind that a model may be under."""
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
        """The model's values at some pixels of a plane, through its transform."""
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
                    self.assertTrue(until(lambda: view.grab().toImage() != before), "The plane stays as it was")
                self.assertFalse(message.visible, message.text)
                self.assertShows(self.exported(), model)
                self.assertShows(followed, model)
                self.assertShows(self.logic.QueryPlane(model, turn.GetMatrix(), 60, 50, 1.0), model)
        # It follows a transform that moves, and nothing was hardened.
        turned = slicer.util.getNode("Turned")
        model.SetAndObserveTransformNodeID(turned.GetID())
        until(lambda: False, 1)
        before = view.grab().toImage()
        turned.SetMatrixTransformToParent(turn.GetMatrix())
        self.assertTrue(until(lambda: view.grab().toImage() != before))
        self.assertShows(self.exported(), model)
        self.assertEqual(model.GetModel(), gaussians)
        # With a non-invertible one, it shows nothing.
        flat = vtk.vtkMatrix4x4()
        flat.SetElement(2, 2, 0)
        turned.SetMatrixTransformToParent(flat)
        self.assertTrue(until(lambda: message.visible))
        self.assertIn("cannot be inverted", message.text)
        turned.SetMatrixTransformToParent(turn.GetMatrix())
        self.assertTrue(until(lambda: not message.visible))
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
        self.assertTrue(until(planes))
        node = planes()[0]
        self.assertTrue(node.GetHideFromEditors() and not node.GetSaveWithScene())
        self.assertFalse(node.GetDisplayNode().GetSaveWithScene())
        tree = slicer.mrmlScene.GetSubjectHierarchyNode()
        self.assertEqual(tree.GetItemByDataNode(node), 0)
        # It has the plane's position and follows it.
        red = slicer.mrmlScene.GetNodeByID("vtkMRMLSliceNodeRed")
        self.find("SliceViewComboBox").setCurrentNode(red)
        red.SetOrientationToAxial()
        red.SetSliceOffset(7)
        level = lambda: (node.GetPolyData().GetBounds()[4], node.GetPolyData().GetBounds()[5])
        self.assertTrue(until(lambda: np.allclose(level(), 7, atol=0.01)), level())
        self.assertGreater(node.GetPolyData().GetBounds()[1] - node.GetPolyData().GetBounds()[0], 50)
        # An oblique plane ends where the model does.
        turn = vtk.vtkTransform()
        turn.RotateWXYZ(40, 1, 1, 0)
        red.GetSliceToRAS().DeepCopy(turn.GetMatrix())
        red.UpdateMatrices()
        self.assertTrue(until(lambda: level()[1] - level()[0] > 20), level())
        box = [0.0] * 6
        self.parameters.GetResultModelNode().GetRASBounds(box)
        for low, high in ((0, 1), (2, 3), (4, 5)):
            self.assertGreater(node.GetPolyData().GetBounds()[low], box[low] - 2)
            self.assertLess(node.GetPolyData().GetBounds()[high], box[high] + 2)
        self.assertGreater(node.GetPolyData().GetNumberOfPoints(), 3)
        # With the picture on it, in the panel's window.
        node.GetDisplayNode().GetTextureImageDataConnection().GetProducer().Update()
        picture = node.GetDisplayNode().GetTextureImageDataConnection().GetProducer().GetOutput()
        self.assertLess(picture.GetScalarRange()[0], 10)
        self.assertEqual(picture.GetScalarRange()[1], 255)
        # Not while another module is shown or the section is closed, and no longer once it is switched off.
        slicer.util.selectModule("Data")
        self.assertEqual(planes(), [])
        slicer.util.selectModule("InnerGS")
        self.assertTrue(until(planes))
        self.find("QuerySection").collapsed = True
        self.assertEqual(planes(), [])
        self.find("QuerySection").collapsed = False
        self.assertTrue(until(planes))
        slicer.mrmlScene.Clear(0)
        until(lambda: False, 0.5)
        self.assertEqual(planes(), [])
        shown.setChecked(False)


if __name__ == "__main__":
    unittest.main()
