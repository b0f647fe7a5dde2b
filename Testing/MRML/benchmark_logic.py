#!/usr/bin/env python3
"""What the logic adds to the engine: python benchmark_logic.py SCAN MODEL_GAUSSIANS. Prints a table for Docs/benchmarks.md.

Run by `cmake --build build-mrml --target bench_mrml`. Times are of the main thread, on all cores.
"""

import statistics
import sys
import time

import innergs
import numpy
from slicer_core import vtkMRMLScalarVolumeNode, vtkMRMLScene, vtkMRMLSliceNode, vtkMRMLVolumeArchetypeStorageNode
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonTransforms import vtkTransform


def peak_memory():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1024


def main():
    scene = vtkMRMLScene()
    logic = innergs.logic(scene)
    storage = vtkMRMLVolumeArchetypeStorageNode()
    storage.SetFileName(sys.argv[1])
    scan = vtkMRMLScalarVolumeNode()
    scan.SetName("Scan")
    scene.AddNode(scan)
    if not storage.ReadData(scan):
        sys.exit("cannot read " + sys.argv[1])
    scan.CreateDefaultDisplayNodes()
    voxels = scan.GetImageData().GetNumberOfPoints()
    print("scan %s, %d voxels" % (scan.GetImageData().GetDimensions(), voxels))

    begun = time.monotonic()
    first = []

    def on_preview(job):
        first.append(time.monotonic() - begun)

    job = innergs.start(scan, preview=on_preview, gaussians=int(sys.argv[2]))
    print("Start returned after          %7.1f ms" % (1e3 * (time.monotonic() - begun)))
    deliveries = []
    running = True
    while running:
        at = time.monotonic()
        running = job.running  # delivers
        deliveries.append(time.monotonic() - at)
        time.sleep(0.005)
    whole = time.monotonic() - begun
    result = job.result()
    engine = logic.GetLastJob().GetElapsedSeconds()
    print("first preview after           %7.2f s" % (first[0] if first else float("nan")))
    print("reconstruction, engine alone  %7.2f s" % engine)
    print("reconstruction, Start to end  %7.2f s (%.1f %% more)" % (whole, 100 * (whole / engine - 1)))
    print("delivery of the outputs       %7.1f ms" % (1e3 * deliveries.pop()))
    print("any other event delivery      %7.1f ms at most" % (1e3 * max(deliveries)))
    print("peak memory of the process    %7.0f MB (%.0f MB of voxels as float)" % (peak_memory(), voxels * 4 / 2**20))

    pose = vtkTransform()
    times = []
    for n in range(200):
        pose.Identity()
        pose.Translate(0.1 * n - 10, 5, -8)
        pose.RotateWXYZ(20 + 0.3 * n, 1, 0.7, 0.2)
        at = time.perf_counter()
        plane = innergs.plane(result.model, pose.GetMatrix(), 512, 0.4, plane if n else None)
        times.append(time.perf_counter() - at)
    print("oblique 512x512 plane node    %7.1f ms (median of 200; %d Gaussians)"
          % (1e3 * statistics.median(times), result.model.GetModel().GetNumberOfGaussians()))
    slice_node = vtkMRMLSliceNode()
    slice_node.SetLayoutName("Red")
    scene.AddNode(slice_node)
    slice_node.SetDimensions(512, 512, 1)
    slice_node.SetFieldOfView(205, 205, 1)
    innergs.follow(result.model, slice_node)
    times = []
    for n in range(200):
        pose.Identity()
        pose.Translate(0.1 * n - 10, 5, -8)
        pose.RotateWXYZ(20 + 0.3 * n, 1, 0.7, 0.2)
        slice_node.GetSliceToRAS().DeepCopy(pose.GetMatrix())
        at = time.perf_counter()
        slice_node.UpdateMatrices()
        times.append(time.perf_counter() - at)
    print("followed 512x512 slice view   %7.1f ms (median of 200)" % (1e3 * statistics.median(times)))

    slowest = {}
    for n in range(24):
        job = innergs.start(scan, gaussians=int(sys.argv[2]), iterations=3, held_out=0.1)
        delay = whole * 0.1 * n / 24 if n < 12 else 0.25 * (n - 11)
        end = time.monotonic() + delay
        while time.monotonic() < end and job.running:
            time.sleep(0.002)
        phase = logic.GetLastJob().GetPhase()
        at = time.monotonic()
        job.cancel()
        slowest[phase] = max(slowest.get(phase, 0), time.monotonic() - at)
    for phase, seconds in slowest.items():
        print("Cancel in phase %-13s %7.0f ms at most" % (phase, 1e3 * seconds))


if __name__ == "__main__":
    main()
