#!/usr/bin/env python3
"""Reconstructs every scan of a folder: NIfTI, NRRD and MHA in, volumes and models out.

    python batch_reconstruct.py scans/ results/ --spacing 1 --preset fast
    Slicer --no-main-window --python-script batch_reconstruct.py scans/ results/

Runs wherever `import innergs` works: in a Python with slicer-core, or in Slicer with the extension. The results' folder must
differ from the scans'. If a scan cannot be reconstructed, one line says why, the other scans continue, and the exit status
is 1.
"""

import argparse
import contextlib
import csv
import pathlib
import sys
import time

with contextlib.suppress(ImportError):
    import slicer_core  # noqa: F401  (Slicer has no such module: its classes are loaded already)
import slicer

import innergs

EXTENSIONS = (".nii.gz", ".nii", ".nrrd", ".mha")


def stem(path):
    """The name without its extension: dots before that belong to the name."""
    for extension in EXTENSIONS:
        if path.name.lower().endswith(extension):
            return path.name[:-len(extension)]
    return path.name


def storage_for(path):
    storage = slicer.vtkMRMLVolumeArchetypeStorageNode()
    storage.SetFileName(str(path))
    storage.AddObserver("ErrorEvent", lambda *_: None)  # reported in our own line
    return storage


def read_volume(scene, path):
    storage = storage_for(path)
    node = slicer.vtkMRMLScalarVolumeNode()
    node.SetName(stem(path))
    scene.AddNode(node)
    if not storage.ReadData(node):
        raise innergs.Error("'%s' could not be read as a volume." % path)
    return node


def write_volume(node, path):
    if not storage_for(path).WriteData(node):
        raise innergs.Error("'%s' could not be written." % path)


def plan(source, target):
    """The scans with the names of their results. Exits when anything in the way of a scan would be overwritten."""
    if not source.is_dir():
        sys.exit("'%s' is not a folder: give the folder with the scans." % source)
    scans = sorted(p for p in source.iterdir() if p.is_file() and p.name.lower().endswith(EXTENSIONS))
    if not scans:
        sys.exit("There is no scan (%s) in '%s'." % (", ".join(EXTENSIONS), source))
    if target.exists() and not target.is_dir():
        sys.exit("'%s' is a file: give a folder for the results." % target)
    if target.resolve() == source.resolve() or (target.exists() and target.samefile(source)):
        sys.exit("Scans and results are in the same folder: give another one for the results.")
    names = {}
    for path in scans:
        other = names.setdefault(stem(path).casefold(), path)  # some file systems are case-insensitive
        if other is not path:
            sys.exit("'%s' and '%s' would give results of the same name: rename one." % (other.name, path.name))
        for extension in (".nii.gz", ".innergs"):
            result = target / (stem(path) + extension)
            if result.exists() and any(result.samefile(scan) for scan in scans):
                sys.exit("The result '%s' is one of the scans itself: give another folder." % result)
    return [(path, stem(path)) for path in scans]


def reconstruct(path, folder, name, options):
    scene = slicer.vtkMRMLScene()  # one per scan, so that memory stays that of a single scan
    innergs.logic(scene)
    result = innergs.reconstruct(read_volume(scene, path), options.spacing, preset=options.preset,
                                 held_out=options.held_out)
    write_volume(result.volume, folder / (name + ".nii.gz"))
    innergs.save(result.model, folder / (name + ".innergs"))
    return result.training_psnr, result.held_out_psnr


def main(arguments=None):
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("input", type=pathlib.Path, help="folder with scans")
    parser.add_argument("output", type=pathlib.Path, help="another folder for results; made if it does not exist")
    parser.add_argument("--spacing", type=float, help="output voxel size, mm (default: each scan's finest spacing)")
    parser.add_argument("--preset", default="balanced", choices=("fast", "balanced", "best"))
    parser.add_argument("--held-out", type=float, default=0.1, help="share of slices held out from a second fit to judge the quality")
    options = parser.parse_args(arguments)

    scans = plan(options.input, options.output)
    options.output.mkdir(parents=True, exist_ok=True)
    failed = 0
    with open(options.output / "report.csv", "w", newline="") as file:
        report = csv.writer(file)
        report.writerow(["scan", "seconds", "psnr_fitted_db", "psnr_held_out_db", "error"])
        for path, name in scans:
            begun = time.monotonic()
            try:
                fitted, held_out = reconstruct(path, options.output, name, options)
            except Exception as error:  # whatever it is, continue with the other scans
                failed += 1
                reason = " ".join((str(error) or type(error).__name__).split())
                print("%s: %s" % (path.name, reason), file=sys.stderr)
                report.writerow([path.name, "", "", "", reason])
            else:
                seconds = time.monotonic() - begun
                print("%s: %.1f s, %.2f dB on held-out slices" % (path.name, seconds, held_out))
                report.writerow([path.name, "%.2f" % seconds, "%.3f" % fitted, "%.3f" % held_out, ""])
            file.flush()
    return 1 if failed else 0


if __name__ == "__main__":
    status = main()
    if getattr(slicer, "app", None) is not None and hasattr(slicer.app, "commandOptions"):
        slicer.util.exit(status)  # ends the application
    else:
        sys.exit(status)
