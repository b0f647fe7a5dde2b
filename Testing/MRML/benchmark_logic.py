#!/usr/bin/env python3
"""What the logic adds to the engine, and how fast it answers: python benchmark_logic.py [SCAN]

Run by `make bench-mrml`. The scan (NIfTI, NRRD...) is cut to 181x217x181 voxels in its middle; without one, or where it is
missing, a synthetic head of that size is made. Times are of the main thread, on all cores; the machine's load says what
else they had to do.
"""

import os
import statistics
import sys
import time

import innergs
import numpy
from slicer_core import vtkMRMLScalarVolumeNode, vtkMRMLScene, vtkMRMLSliceNode, vtkMRMLVolumeArchetypeStorageNode
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkCommonMath import vtkMatrix4x4
from vtkmodules.vtkCommonTransforms import vtkTransform


SIZE = 181, 217, 181
GAUSSIANS = 74088  # the paper's 42 along each axis


def peak_memory():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmHWM")) / 1024


def add_scan(scene, path=None):
    scan = vtkMRMLScalarVolumeNode()
    scene.AddNode(scan)
    if path and os.path.exists(path):
        scan.SetName(os.path.basename(path))
        storage = vtkMRMLVolumeArchetypeStorageNode()
        storage.SetFileName(path)
        if not storage.ReadData(scan):
            sys.exit("cannot read " + path)
        size = scan.GetImageData().GetDimensions()
        if any(have < want for have, want in zip(size, SIZE)):
            sys.exit("%s has %s voxels: at least %s are needed" % (path, size, SIZE))
        first = [(have - want) // 2 for have, want in zip(size, SIZE)]
        matrix = vtkMatrix4x4()
        scan.GetIJKToRASMatrix(matrix)
        scan.SetOrigin(matrix.MultiplyPoint([*first, 1])[:3])
        values = vtk_to_numpy(scan.GetImageData().GetPointData().GetScalars()).reshape(size[::-1])
        values = values[tuple(slice(f, f + n) for f, n in zip(first[::-1], SIZE[::-1]))]
    else:
        scan.SetName("Synthetic head")
        k, j, i = numpy.ogrid[-1:1:181j, -1:1:217j, -1:1:181j]
        radius = numpy.sqrt((i / 0.8) ** 2 + (j / 0.9) ** 2 + (k / 0.85) ** 2)
        folds = 60 * numpy.sin(19 * i + 5 * j) * numpy.sin(17 * j + 3 * k) * numpy.sin(15 * k + 7 * i)
        values = numpy.where(radius < 0.85, 500 + folds, numpy.where(radius < 1, 900 - 40 * radius, 0))
        values += numpy.random.default_rng(1).normal(0, 5, values.shape)
        scan.SetOrigin(-90, -108, -90)
    image = vtkImageData()
    image.SetDimensions(*SIZE)
    image.GetPointData().SetScalars(numpy_to_vtk(numpy.ascontiguousarray(values, numpy.float32).ravel(), deep=True))
    scan.SetAndObserveImageData(image)
    scan.CreateDefaultDisplayNodes()
    return scan


def print_load(when):
    if hasattr(os, "getloadavg"):
        print("load of the machine %-10s %7.1f (mean of the last minute)" % (when, os.getloadavg()[0]))


def main():
    scene = vtkMRMLScene()
    logic = innergs.logic(scene)
    scan = add_scan(scene, *sys.argv[1:2])
    voxels = scan.GetImageData().GetNumberOfPoints()
    print("%s, %s voxels, %d Gaussians, %d cores" % (scan.GetName(), "x".join(map(str, SIZE)), GAUSSIANS, os.cpu_count()))
    print_load("before")

    begun = time.monotonic()
    first = []

    def on_preview(job):
        first.append(time.monotonic() - begun)

    job = innergs.start(scan, preview=on_preview, gaussians=GAUSSIANS)
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
    print("first preview after           %7.2f s (limit 2)" % (first[0] if first else float("nan")))
    print("reconstruction, engine alone  %7.2f s" % engine)
    print("reconstruction, Start to end  %7.2f s (%.1f %% more, limit 5)" % (whole, 100 * (whole / engine - 1)))
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
    print("oblique 512x512 plane node    %7.1f ms (median of 200; %d Gaussians; limit 16)"
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
        job = innergs.start(scan, gaussians=GAUSSIANS, iterations=3, held_out=0.1)
        delay = whole * 0.1 * n / 24 if n < 12 else 0.25 * (n - 11)
        end = time.monotonic() + delay
        while time.monotonic() < end and job.running:
            time.sleep(0.002)
        phase = logic.GetLastJob().GetPhase()
        at = time.monotonic()
        job.cancel()
        slowest[phase] = max(slowest.get(phase, 0), time.monotonic() - at)
    for phase, seconds in slowest.items():
        print("Cancel in phase %-13s %7.0f ms at most (limit 200)" % (phase, 1e3 * seconds))
    print_load("after")


if __name__ == "__main__":
    main()
