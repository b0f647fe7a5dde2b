"""Updates the module's screenshots in Docs/screenshots from a real Slicer:

Slicer --no-splash --disable-settings --additional-module-paths <build>/lib/Slicer-5.x/qt-loadable-modules \
    --python-script Utilities/slicer-screenshots.py <folder> <scan>...
"""

import os
import sys
import time

import qt
import slicer
import vtk

FOLDER, SCANS = os.path.abspath(sys.argv[1]), sys.argv[2:]


def until(condition, seconds):
    end = time.time() + seconds
    while time.time() < end and not condition():
        slicer.app.processEvents()
        time.sleep(0.02)
    return condition()


def rest(seconds=1.0):
    until(lambda: False, seconds)


def picture(name, widget=None):
    rest()
    slicer.util.forceRenderAllViews()
    rest(0.5)
    file = os.path.join(FOLDER, "slicer-%s.png" % name)
    (widget or slicer.util.mainWindow()).grab().save(file)
    print(file, flush=True)


def find(name):
    return slicer.util.findChildren(slicer.modules.innergs.widgetRepresentation(), name=name)[0]


def main():
    os.makedirs(FOLDER, exist_ok=True)
    window = slicer.util.mainWindow()
    window.resize(1500, 1100)
    slicer.util.setPythonConsoleVisible(False)
    slicer.util.setDataProbeVisible(False)
    slicer.util.setModuleHelpSectionVisible(False)
    slicer.app.layoutManager().setLayout(slicer.vtkMRMLLayoutNode.SlicerLayoutFourUpView)
    panel = [dock for dock in window.findChildren("QDockWidget") if dock.objectName == "PanelDockWidget"][0]
    window.resizeDocks([panel], [460], qt.Qt.Horizontal)

    scans = [slicer.util.loadVolume(scan) for scan in SCANS]
    slicer.util.setSliceViewerLayers(background=scans[0], fit=True)
    slicer.util.selectModule("InnerGS")
    for scan in scans[1:]:
        find("ParameterNodeComboBox").currentNode().AddInputVolumeNode(scan)
    if len(scans) > 1:  # measures the first scan only
        find("evaluateQuality").setChecked(False)
    find("preset").setCurrentIndex(0)
    rest(2)
    picture("panel")

    find("reconstruct").click()
    until(lambda: slicer.modules.innergs.logic().GetLastJob().GetPreviewImage() is not None, 120)
    rest(2)
    scroll_to("progressCard")
    picture("progress")
    until(lambda: "econstruct" in find("reconstruct").text, 900)
    result = find("ParameterNodeComboBox").currentNode().GetResultVolumeNode()
    find("VolumeRenderingButton").click()
    view = slicer.app.layoutManager().threeDWidget(0).threeDView()
    view.resetFocalPoint()
    view.rotateToViewAxis(3)
    for _ in range(4):
        view.zoomIn()
    scroll_to("VolumeRenderingButton")  # and the part above it
    picture("result")

    find("ReconstructSection").collapsed = True
    find("QuerySection").collapsed = False
    red = slicer.mrmlScene.GetNodeByID("vtkMRMLSliceNodeRed")
    find("SliceViewComboBox").setCurrentNode(red)
    find("ModelInViewCheckBox").setChecked(True)
    find("VolumeRenderingButton").click()  # off: it would hide the plane
    find("PlaneIn3DCheckBox").setChecked(True)
    turn = vtk.vtkTransform()
    turn.Concatenate(red.GetSliceToRAS())
    turn.RotateX(35)
    turn.RotateY(20)
    red.GetSliceToRAS().DeepCopy(turn.GetMatrix())
    red.UpdateMatrices()
    for _ in range(2):
        view.zoomOut()
    rest(1)
    picture("query")

    find("QuerySection").collapsed = True
    find("ModelSection").collapsed = False
    find("modelEllipsoids").click()
    rest(1)
    view.resetFocalPoint()
    picture("model")
    assert result is not None


def scroll_to(name):
    widget = find(name)
    parent = widget.parentWidget()
    while parent is not None and not isinstance(parent, qt.QScrollArea):
        parent = parent.parentWidget()
    if parent is not None:
        slicer.app.processEvents()
        parent.ensureWidgetVisible(widget)


try:
    main()
    slicer.util.exit(0)
except Exception:
    import traceback

    traceback.print_exc()
    slicer.util.exit(1)
