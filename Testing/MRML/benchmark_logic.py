#!/usr/bin/env python3
"""What the logic adds to the engine, and how fast it answers: python benchmark_logic.py [--size N] [--engine PROGRAM] [SCAN]

Run by `make bench-mrml`. The scan (NIfTI, NRRD...) is cut to 181x217x181 voxels in its middle; without one, or where it is
missing, a synthetic head of that size is made. --size: a synthetic head of N voxels a side instead, for a quick look.
--engine: the program innergs_mrml_engine, which runs the same job without the logic, to compare with. Times are of the
main thread, on all cores; the machine's load says what else they had to do.
"""

import argparse
import os
import statistics
import subprocess
import sys
import tempfile
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


def add_scan(scene, size, path=None):
    """The middle of a file's voxels, or a synthetic head, 1 mm a voxel."""
    scan = vtkMRMLScalarVolumeNode()
    scene.AddNode(scan)
    if path and os.path.exists(path):
        scan.SetName(os.path.basename(path))
        storage = vtkMRMLVolumeArchetypeStorageNode()
        storage.SetFileName(path)
        if not storage.ReadData(scan):
            sys.exit("cannot read " + path)
        there = scan.GetImageData().GetDimensions()
        if any(have < want for have, want in zip(there, size)):
            sys.exit("%s has %s voxels: at least %s are needed" % (path, there, size))
        first = [(have - want) // 2 for have, want in zip(there, size)]
        matrix = vtkMatrix4x4()
        scan.GetIJKToRASMatrix(matrix)
        scan.SetOrigin(matrix.MultiplyPoint([*first, 1])[:3])
        values = vtk_to_numpy(scan.GetImageData().GetPointData().GetScalars()).reshape(there[::-1])
        values = values[tuple(slice(f, f + n) for f, n in zip(first[::-1], size[::-1]))]
    else:
        scan.SetName("Synthetic head")
        k, j, i = (numpy.linspace(-1, 1, n).reshape(shape) for n, shape in
                   zip(size[::-1], ((-1, 1, 1), (1, -1, 1), (1, 1, -1))))
        radius = numpy.sqrt((i / 0.8) ** 2 + (j / 0.9) ** 2 + (k / 0.85) ** 2)
        folds = 60 * numpy.sin(19 * i + 5 * j) * numpy.sin(17 * j + 3 * k) * numpy.sin(15 * k + 7 * i)
        values = numpy.where(radius < 0.85, 500 + folds, numpy.where(radius < 1, 900 - 40 * radius, 0))
        values += numpy.random.default_rng(1).normal(0, 5, values.shape)
        scan.SetOrigin(*(-n / 2 for n in size))
    set_values(scan, values)
    return scan


def set_values(scan, values):
    image = vtkImageData()
    image.SetDimensions(*values.shape[::-1])
    image.GetPointData().SetScalars(numpy_to_vtk(numpy.ascontiguousarray(values, numpy.float32).ravel(), deep=True))
    scan.SetAndObserveImageData(image)
    scan.CreateDefaultDisplayNodes()


def values_of(scan):
    image = scan.GetImageData()
    return vtk_to_numpy(image.GetPointData().GetScalars()).reshape(image.GetDimensions()[::-1])


def add_thick(scene, scan, axis):
    """The scan as slices of 4 voxels along an axis (0: I)."""
    values = numpy.moveaxis(values_of(scan), 2 - axis, 0)
    values = values[:len(values) // 4 * 4].reshape(-1, 4, *values.shape[1:]).mean(axis=1)
    thick = vtkMRMLScalarVolumeNode()
    thick.SetName("Thick " + "IJK"[axis])
    scene.AddNode(thick)
    matrix = vtkMatrix4x4()
    scan.GetIJKToRASMatrix(matrix)
    middle = [0, 0, 0, 1]
    middle[axis] = 1.5
    origin = matrix.MultiplyPoint(middle)
    for row in range(3):
        matrix.SetElement(row, axis, 4 * matrix.GetElement(row, axis))
        matrix.SetElement(row, 3, origin[row])
    set_values(thick, numpy.moveaxis(values, 0, 2 - axis))
    thick.SetIJKToRASMatrix(matrix)
    return thick


def engine_seconds(program, scan, gaussians):
    """The same job on the same voxels without the logic, in a process of its own."""
    with tempfile.NamedTemporaryFile(suffix=".raw") as raw:
        values_of(scan).astype("<f4").tofile(raw.name)
        words = [program, raw.name, *scan.GetImageData().GetDimensions(), *scan.GetSpacing(), gaussians]
        return float(subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True).stdout)


def print_overhead(scan, program, gaussians, rounds=3):
    engine, logic = [], []
    for _ in range(rounds):  # alternating, so that both see the same load
        engine.append(engine_seconds(program, scan, gaussians))
        at = time.monotonic()
        result = innergs.reconstruct(scan, preview=lambda job: None, gaussians=gaussians)
        logic.append(time.monotonic() - at)
        scan.GetScene().RemoveNode(result.volume)
        scan.GetScene().RemoveNode(result.model)
    a, b = statistics.median(engine), statistics.median(logic)
    print("engine in a process of its own %6.2f s (median of %d: %s)" % (a, rounds, " ".join("%.2f" % t for t in engine)))
    print("the same through the logic    %7.2f s (%s): %+.1f %% (limit 5)"
          % (b, " ".join("%.2f" % t for t in logic), 100 * (b / a - 1)))


def print_cancel_times(scene, logic, scan, gaussians, rounds=4):
    """The slowest Cancel() in every phase: of a scan, of a thick one (which is refined), of two, and of the quality."""
    across = [add_thick(scene, scan, 2), add_thick(scene, scan, 0)]
    cases = {
        "one scan": dict(volumes=scan, gaussians=gaussians, iterations=4, held_out=0.1),
        "thick slices": dict(volumes=across[0], iterations=2, ensemble_size=2, held_out=0.1),
        "two stacks": dict(volumes=across, iterations=2, ensemble_size=1),
        "quality table": dict(volumes=scan, gaussians=gaussians, iterations=2, quality=True),
    }
    for name, choices in cases.items():
        begun = time.monotonic()
        phases = {}  # in order of appearance: seconds per phase
        job = innergs.start(**choices)
        at = begun
        while job.running:
            now = time.monotonic()
            phase = logic.GetLastJob().GetPhase()
            phases[phase] = phases.get(phase, 0) + now - at
            at = now
            time.sleep(0.001)
        result = job.result()
        for node in (result.volume, result.model, result.table):
            if node:
                scene.RemoveNode(node)
        slowest = {}
        for phase, seconds in phases.items():
            for n in range(rounds):
                job = innergs.start(**choices)
                while job.running and logic.GetLastJob().GetPhase() != phase:
                    time.sleep(0.0005)
                end = time.monotonic() + seconds * n / rounds
                while time.monotonic() < end and job.running:
                    time.sleep(0.0005)
                if not job.running:
                    continue
                met = logic.GetLastJob().GetPhase()
                at = time.monotonic()
                job.cancel()
                slowest[met] = max(slowest.get(met, 0), time.monotonic() - at)
        for phase, seconds in slowest.items():
            print("Cancel, %-13s %-34s %5.0f ms at most (limit 200)" % (name, phase, 1e3 * seconds))


def print_load(when):
    if hasattr(os, "getloadavg"):
        print("load of the machine %-10s %7.1f (mean of the last minute)" % (when, os.getloadavg()[0]))


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("scan", nargs="?")
    options.add_argument("--size", type=int)
    options.add_argument("--engine")
    options = options.parse_args()
    size = (options.size,) * 3 if options.size else SIZE
    gaussians = GAUSSIANS * size[0] * size[1] * size[2] // (SIZE[0] * SIZE[1] * SIZE[2])
    scene = vtkMRMLScene()
    logic = innergs.logic(scene)
    scan = add_scan(scene, size, None if options.size else options.scan)
    voxels = scan.GetImageData().GetNumberOfPoints()
    print("%s, %s voxels, %d Gaussians, %d cores" % (scan.GetName(), "x".join(map(str, size)), gaussians, os.cpu_count()))
    print_load("before")

    begun = time.monotonic()
    first = []

    def on_preview(job):
        first.append(time.monotonic() - begun)

    job = innergs.start(scan, preview=on_preview, gaussians=gaussians)
    print("Start returned after          %7.1f ms" % (1e3 * (time.monotonic() - begun)))
    deliveries = []
    running = True
    while running:
        at = time.monotonic()
        running = job.running  # delivers events
        deliveries.append(time.monotonic() - at)
        time.sleep(0.005)
    whole = time.monotonic() - begun
    result = job.result()
    engine = logic.GetLastJob().GetElapsedSeconds()
    print("first preview after           %7.2f s (limit 2)" % (first[0] if first else float("nan")))
    print("reconstruction, engine's share %6.2f s" % engine)
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

    print_cancel_times(scene, logic, scan, gaussians)
    if options.engine:
        print_overhead(scan, options.engine, gaussians)
    print_load("after")


if __name__ == "__main__":
    main()
