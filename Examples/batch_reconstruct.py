#!/usr/bin/env python3
"""Reconstructs every scan of a folder: NIfTI, NRRD and MHA in, volumes and models out.

    python batch_reconstruct.py scans/ results/ --spacing 1 --preset fast

Runs where `import innergs` works: in a Python with slicer-core, or in Slicer (--no-main-window --python-script). A scan that
cannot be reconstructed is named with the reason, and the others go on; the exit status is then 1.
"""

import argparse
import csv
import pathlib
import sys
import time

import innergs

EXTENSIONS = (".nii", ".nii.gz", ".nrrd", ".mha")


def read_volume(scene, path):
    from slicer_core import vtkMRMLScalarVolumeNode, vtkMRMLVolumeArchetypeStorageNode

    storage = vtkMRMLVolumeArchetypeStorageNode()
    storage.SetFileName(str(path))
    node = vtkMRMLScalarVolumeNode()
    node.SetName(path.name.split(".")[0])
    scene.AddNode(node)
    if not storage.ReadData(node):
        raise innergs.Error("'%s' could not be read as a volume." % path)
    return node


def write_volume(node, path):
    from slicer_core import vtkMRMLVolumeArchetypeStorageNode

    storage = vtkMRMLVolumeArchetypeStorageNode()
    storage.SetFileName(str(path))
    if not storage.WriteData(node):
        raise innergs.Error("'%s' could not be written." % path)


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("input", type=pathlib.Path, help="folder with scans")
    parser.add_argument("output", type=pathlib.Path, help="folder for results; made if it does not exist")
    parser.add_argument("--spacing", type=float, help="output voxel size, mm (default: each scan's finest spacing)")
    parser.add_argument("--preset", default="balanced", choices=("fast", "balanced", "best"))
    parser.add_argument("--held-out", type=float, default=0.1, help="share of slices withheld to measure quality")
    options = parser.parse_args(arguments)

    scans = sorted(p for p in options.input.iterdir() if p.name.lower().endswith(EXTENSIONS))
    if not scans:
        sys.exit("There is no scan (%s) in '%s'." % (", ".join(EXTENSIONS), options.input))
    options.output.mkdir(parents=True, exist_ok=True)
    from slicer_core import vtkMRMLScene

    failed = 0
    with open(options.output / "report.csv", "w", newline="") as file:
        report = csv.writer(file)
        report.writerow(["scan", "seconds", "psnr_fitted_db", "psnr_held_out_db", "error"])
        for path in scans:
            scene = vtkMRMLScene()  # one for each: memory stays that of one scan
            begun = time.monotonic()
            try:
                result = innergs.logic(scene) and innergs.reconstruct(
                    read_volume(scene, path), options.spacing, preset=options.preset, held_out=options.held_out)
                name = path.name.split(".")[0]
                write_volume(result.volume, options.output / (name + ".nii.gz"))
                innergs.save(result.model, options.output / (name + ".innergs"))
                seconds = time.monotonic() - begun
                print("%s: %.1f s, %.2f dB on withheld slices" % (path.name, seconds, result.held_out_psnr))
                report.writerow([path.name, "%.2f" % seconds, "%.3f" % result.training_psnr,
                                 "%.3f" % result.held_out_psnr, ""])
            except innergs.Error as error:
                failed += 1
                print("%s: %s" % (path.name, error), file=sys.stderr)
                report.writerow([path.name, "", "", "", error])
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
