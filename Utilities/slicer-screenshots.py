"""Updates the module's screenshots in Docs/screenshots from a real Slicer:

Slicer --no-splash --disable-settings --additional-module-paths <build>/lib/Slicer-5.x/qt-loadable-modules \
    --python-script Utilities/slicer-screenshots.py <folder> <scan>...

or, in place of the scans, --moving <.seq.nrrd, seconds>, --find <scan> <labels> <names.json> ({"1": "liver"}), or
--slices <scan> <mask> <scan> <mask>...
"""

import json
import os
import sys
import time

import qt
import slicer
import vtk

FOLDER, FILES = os.path.abspath(sys.argv[1]), sys.argv[2:]


def until(condition, seconds):
    end = time.time() + seconds
    while time.time() < end and not condition():
        slicer.app.processEvents()
        time.sleep(0.02)
    return condition()


def rest(seconds=1.0):
    until(lambda: False, seconds)


def picture(name, dialog=None):
    rest()
    slicer.util.forceRenderAllViews()
    rest(0.5)
    file = os.path.join(FOLDER, "slicer-%s.png" % name)
    image = slicer.util.mainWindow().grab()
    if dialog is not None:
        painter = qt.QPainter(image)
        painter.drawPixmap(image.width() - dialog.width - 20, image.height() - dialog.height - 40, dialog.grab())
        painter.end()
    image.save(file)
    print(file, flush=True)


def find(name):
    return slicer.util.findChildren(slicer.modules.innergs.widgetRepresentation(), name=name)[0]


def selector(name):
    return slicer.util.findChildren(find(name), className="qMRMLNodeComboBox")[0]


def show_module():
    window = slicer.util.mainWindow()
    window.resize(1500, 1100)
    slicer.util.setPythonConsoleVisible(False)
    slicer.util.setDataProbeVisible(False)
    slicer.util.setModuleHelpSectionVisible(False)
    slicer.app.layoutManager().setLayout(slicer.vtkMRMLLayoutNode.SlicerLayoutFourUpView)
    panel = [dock for dock in window.findChildren("QDockWidget") if dock.objectName == "PanelDockWidget"][0]
    window.resizeDocks([panel], [460], qt.Qt.Horizontal)
    slicer.util.selectModule("InnerGS")


def open_section(name):
    for section in ("ReconstructSection", "QuerySection", "FindSection", "MotionSection", "ModelSection", "LogSection"):
        find(section).collapsed = section != name


def reconstruct():
    scans = [slicer.util.loadVolume(scan) for scan in FILES]
    slicer.util.setSliceViewerLayers(background=scans[0], fit=True)
    show_module()
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

    open_section("QuerySection")
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

    open_section("ModelSection")
    find("modelEllipsoids").click()
    rest(1)
    view.resetFocalPoint()
    picture("model")
    assert result is not None


def moving():
    series = slicer.util.loadSequence(FILES[1])
    series.SetIndexName("time")
    series.SetIndexUnit("s")
    show_module()
    open_section("MotionSection")
    selector("motionSeries").setCurrentNode(series)
    rest()
    find("motionRun").click()
    assert until(lambda: find("motionQuality").text != "" and selector("motionModel").currentNode() is not None, 900)
    slicer.util.resetSliceViews()
    picture("moving")


def find_structure():
    import innergs

    scan = slicer.util.loadVolume(FILES[1])
    segmentation = slicer.util.loadSegmentation(FILES[2])
    with open(FILES[3], encoding="utf-8") as file:
        names = json.load(file)
    segments = segmentation.GetSegmentation()
    for n in range(segments.GetNumberOfSegments()):
        segment = segments.GetNthSegment(n)
        segment.SetName(names[str(segment.GetLabelValue())])
    segmentation.GetDisplayNode().SetVisibility(False)
    show_module()
    open_section("FindSection")
    model = innergs.reconstruct(scan, preset="fast", quality=False).model
    innergs.learn(model, segmentation)
    selector("findModel").setCurrentNode(model)
    find("findText").setEditText("livr")
    find("findGo").click()
    assert until(lambda: find("findAdd").enabled, 300)
    find("findAdd").click()
    slicer.util.setSliceViewerLayers(background=scan, fit=True)
    picture("find")


def slices():
    scans = [slicer.util.loadVolume(scan) for scan in FILES[1::2]]
    masks = [slicer.util.loadLabelVolume(mask) for mask in FILES[2::2]]
    slicer.util.setSliceViewerLayers(background=scans[0], label=None, fit=True)
    show_module()
    parameters = find("ParameterNodeComboBox").currentNode()
    for scan in scans[1:]:
        parameters.AddInputVolumeNode(scan)
    for scan, mask in zip(scans, masks):
        parameters.SetInputMaskNode(scan, mask)
    find("preset").setCurrentIndex(0)
    find("evaluateQuality").setChecked(False)
    find("estimateUncertainty").setChecked(True)
    rest(2)
    find("reconstruct").click()
    until(lambda: find("showSlices").enabled and find("showSlices").visible, 900)
    result, deviation = parameters.GetResultVolumeNode(), parameters.GetResultUncertaintyNode()
    slicer.util.setSliceViewerLayers(background=result, label=None, fit=True)
    scroll_to("createSliceTransforms")
    find("createSliceTransforms").click()
    find("showSlices").click()
    rest()
    dialog = [w for w in slicer.app.topLevelWidgets() if w.objectName == "slicesDialog"][0]
    picture("slices", dialog)
    dialog.close()
    scroll_to("reconstruct")
    slicer.util.setSliceViewerLayers(background=deviation, fit=True)
    picture("uncertainty")


def scroll_to(name):
    widget = find(name)
    parent = widget.parentWidget()
    while parent is not None and not isinstance(parent, qt.QScrollArea):
        parent = parent.parentWidget()
    if parent is not None:
        slicer.app.processEvents()
        parent.ensureWidgetVisible(widget)


try:
    os.makedirs(FOLDER, exist_ok=True)
    {"--moving": moving, "--find": find_structure, "--slices": slices}.get(FILES[0], reconstruct)()
    slicer.util.exit(0)
except Exception:
    import traceback

    traceback.print_exc()
    slicer.util.exit(1)
