"""Shared by the module's self tests: a scan of a ball, and the panel as a person uses it."""

import time
import unittest

import numpy as np
import slicer
import vtk


def until(condition, seconds=120.0):
    """Handles the application's events until the condition holds; returns whether it does."""
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


class ModuleFixture(unittest.TestCase):
    def setUp(self):
        slicer.mrmlScene.Clear(0)
        slicer.util.selectModule("Data")  # re-enters the module below
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
        self.assertTrue(until(lambda: button.enabled), self.find("refusal").toolTip)
        button.click()
        # Immediately: a short fit may end while events are handled.
        self.assertIn("ancel", button.text, self.find("refusal").toolTip)

    def ended(self):
        return "econstruct" in self.find("reconstruct").text

    def background(self, view="Red"):
        layers = slicer.app.layoutManager().sliceWidget(view).sliceLogic().GetSliceCompositeNode()
        return layers.GetBackgroundVolumeID()

    def reconstruct(self):
        """A result of a second or two."""
        self.quick()
        self.start()
        self.assertTrue(until(self.ended), "The reconstruction did not end")

    def combo(self, name):
        return slicer.util.findChildren(self.find(name), className="qMRMLNodeComboBox")[0]

    def meshes(self):
        nodes = slicer.util.getNodesByClass("vtkMRMLModelNode")
        return [n for n in nodes if n.GetNodeReference("InnerGSModel") and n.GetPolyData()]

    def exported(self):
        """The plane of the panel as a volume."""
        before = set(slicer.util.getNodesByClass("vtkMRMLScalarVolumeNode"))
        made = lambda: set(slicer.util.getNodesByClass("vtkMRMLScalarVolumeNode")) - before
        self.find("queryExportVolume").click()
        self.assertTrue(until(made))
        return made().pop()

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

    def said(self, name):
        """The text of a line of the panel."""
        return " ".join(label.text for label in slicer.util.findChildren(self.find(name), className="QLabel"))
