#!/usr/bin/env python3
"""Compares the first alignment of several scans with ITK's registration (SimpleITK).

    python3 -m venv peer && peer/bin/pip install SimpleITK
    peer/bin/python Testing/Benchmark/itk_alignment.py AX COR SAG --innergs build/bin/innergs
    peer/bin/python Testing/Benchmark/itk_alignment.py F1 F3 F5 --mask M1 M3 M5 --reference found --innergs build/bin/innergs

The headers of all scans but the first are displaced by random rigid motions of known size, about the middle of each
scan or its mask. Both methods must put the scans back to where they fit the first: by their headers, or, where these are
not right, by what InnerGS finds for the scans as they are. The error is the mean distance of the corners of a cube of 80
mm, and more than 2 mm is a failure. ITK: Euler3DTransform, correlation, random samples of 20 % (50 % inside a mask),
regular-step gradient descent with scales from physical shifts, shrunk by 4, 2, 1 and smoothed.
"""
import argparse
import itertools
import json
import subprocess
import sys
import time
from pathlib import Path

SKIPPED = 77
FAILURE = 2  # mm
CUBE = 80  # mm


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scans", type=Path, nargs="+", help="two scans of one body or more")
    parser.add_argument("--mask", type=Path, nargs="+", default=[], help="one per scan, in their order")
    parser.add_argument("--innergs", type=Path, required=True, help="the innergs command")
    parser.add_argument("--sizes", type=float, nargs="+", default=[5, 15, 30], metavar="X",
                        help="of displacements: X mm and X degrees [5 15 30]")
    parser.add_argument("--draws", type=int, default=3, help="random displacements of each size [3]")
    parser.add_argument("--reference", choices=["header", "found"], default="header",
                        help="where scans fit: by their headers, or as InnerGS finds without displacement [header]")
    parser.add_argument("--work", type=Path, default=Path("alignment-work"), help="folder for files [alignment-work]")
    return parser.parse_args()


def rigid(rotation, shift):
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = rotation, shift
    return matrix


def drawn(random, size, centre):
    """A turn by `size` degrees about the centre and a shift by `size` mm, in random directions (LPS)."""
    axis, shift = (v / np.linalg.norm(v) for v in random.normal(size=(2, 3)))
    cross = np.cross(np.eye(3), axis)
    angle = np.deg2rad(size)
    rotation = np.eye(3) + np.sin(angle) * cross.T + (1 - np.cos(angle)) * cross @ cross
    return rigid(rotation, centre + size * shift - rotation @ centre)


def displaced(image, motion):
    out = sitk.Image(image)
    direction = motion[:3, :3] @ np.reshape(image.GetDirection(), (3, 3))
    out.SetDirection(direction.ravel().tolist())
    out.SetOrigin((motion @ [*image.GetOrigin(), 1])[:3].tolist())
    return out


def middle(image, mask):
    if mask is None:
        return np.array(image.TransformContinuousIndexToPhysicalPoint([(n - 1) / 2 for n in image.GetSize()]))
    shape = sitk.LabelShapeStatisticsImageFilter()
    shape.Execute(mask)
    return np.array(shape.GetCentroid(1))


def aligned_by_innergs(options, images, masks):
    """The motion of each scan that InnerGS found, LPS, relative to the first, and seconds."""
    files = [[], []]
    for kind, (name, all_images) in enumerate((("scan", images), ("mask", masks))):
        for n, image in enumerate(all_images):
            files[kind].append(options.work / f"{name}{n}.nii.gz")
            sitk.WriteImage(image, str(files[kind][-1]))
    report = options.work / "report.json"
    words = [options.innergs, "reconstruct", *files[0], "-o", options.work / "volume.nii.gz", "--report", report,
             "--slice-motion", "off", "--preset", "fast", "--iterations", "1", "--gaussians", "1000", "--ensemble-size",
             "1", "--spacing", "8", "--prediction", "none", "--no-consistency", "--no-acquired-pixels", "-q"]
    if masks:
        words += ["--mask", *files[1]]
    begun = time.monotonic()
    subprocess.run([str(word) for word in words], check=True, stderr=subprocess.DEVNULL)
    found = [np.vstack([np.array(a["matrix_lps"])[:3], [0, 0, 0, 1]]) if a else np.eye(4)
             for a in json.loads(report.read_text())["alignment"]]
    return [np.linalg.inv(found[0]) @ matrix for matrix in found], time.monotonic() - begun


def cropped(image, mask, margin=40):
    shape = sitk.LabelShapeStatisticsImageFilter()
    shape.Execute(mask)
    box, spacing, size = shape.GetBoundingBox(1), image.GetSpacing(), image.GetSize()
    low = [max(0, box[a] - int(margin / spacing[a])) for a in range(3)]
    count = [min(size[a], box[a] + box[a + 3] + int(margin / spacing[a])) - low[a] for a in range(3)]
    return sitk.RegionOfInterest(image, count, low)


def aligned_by_itk(fixed, moving, fixed_mask, moving_mask):
    """The motion that puts the moving scan onto the fixed one, LPS."""
    method = sitk.ImageRegistrationMethod()
    method.SetMetricAsCorrelation()
    method.SetMetricSamplingStrategy(method.RANDOM)
    method.SetMetricSamplingPercentage(0.2 if fixed_mask is None else 0.5, 1)
    method.SetInterpolator(sitk.sitkLinear)
    transform = sitk.Euler3DTransform()
    transform.SetCenter(middle(fixed, fixed_mask).tolist())
    if fixed_mask is not None:
        near = sitk.SignedMaurerDistanceMap(fixed_mask, False, False, True) <= 4
        fixed, near = cropped(fixed, fixed_mask), cropped(near, fixed_mask)
        moving = cropped(moving, moving_mask)
        method.SetMetricFixedMask(near)
    method.SetInitialTransform(transform, inPlace=True)
    method.SetOptimizerAsRegularStepGradientDescent(learningRate=2 if fixed_mask is None else 1, minStep=1e-3,
                                                    numberOfIterations=300, relaxationFactor=0.5,
                                                    gradientMagnitudeTolerance=1e-8)
    method.SetOptimizerScalesFromPhysicalShift()
    method.SetShrinkFactorsPerLevel([4, 2, 1])
    method.SetSmoothingSigmasPerLevel([2, 1, 0])
    method.SetSmoothingSigmasAreSpecifiedInPhysicalUnits(fixed_mask is not None)
    try:
        method.Execute(fixed, moving)
    except RuntimeError:  # too few samples in common
        return np.eye(4)
    origin = np.array(transform.TransformPoint((0, 0, 0)))
    columns = [np.array(transform.TransformPoint(axis)) - origin for axis in np.eye(3).tolist()]
    return np.linalg.inv(rigid(np.array(columns).T, origin))


def error(found, motion, reference, centre):
    """mm, of a motion found for a scan whose header was displaced."""
    corners = np.array([[*(centre + CUBE / 2 * np.array(s)), 1] for s in itertools.product((-1, 1), repeat=3)]).T
    return float(np.mean(np.linalg.norm(((found @ motion - reference) @ corners)[:3], axis=0)))


def main():
    options = arguments()
    if options.mask and len(options.mask) != len(options.scans):
        sys.exit("Give one mask per scan.")
    options.work.mkdir(parents=True, exist_ok=True)
    images = [sitk.ReadImage(str(file), sitk.sitkFloat32) for file in options.scans]
    masks = [sitk.ReadImage(str(file), sitk.sitkFloat32) > 0 for file in options.mask]
    for image, mask in zip(images, masks):
        mask.CopyInformation(image)
    centres = [middle(image, masks[n] if masks else None) for n, image in enumerate(images)]
    reference = [np.eye(4)] * len(images)
    if options.reference == "found":
        reference, _ = aligned_by_innergs(options, images, masks)
    print("| displaced by | method | scans | median, mm | worst, mm | failures | seconds |\n|---|---|---|---|---|---|---|")
    for size in options.sizes:
        errors, seconds = {"InnerGS": [], "ITK": []}, {"InnerGS": 0.0, "ITK": 0.0}
        for draw in range(options.draws):
            motions = [np.eye(4)] + [drawn(np.random.default_rng([int(10 * size), draw, n]), size, centres[n])
                                     for n in range(1, len(images))]
            moved = [displaced(image, motion) for image, motion in zip(images, motions)]
            moved_masks = [displaced(mask, motion) for mask, motion in zip(masks, motions)]
            found, taken = aligned_by_innergs(options, moved, moved_masks)
            seconds["InnerGS"] += taken
            begun = time.monotonic()
            given = moved_masks or [None] * len(images)
            by_itk = [np.eye(4)] + [aligned_by_itk(moved[0], moved[n], given[0], given[n])
                                    for n in range(1, len(images))]
            seconds["ITK"] += time.monotonic() - begun
            for n in range(1, len(images)):
                errors["InnerGS"].append(error(found[n], motions[n], reference[n], centres[n]))
                errors["ITK"].append(error(by_itk[n], motions[n], reference[n], centres[n]))
        for method, all_errors in errors.items():
            print(f"| {size:g} mm, {size:g}° | {method} | {len(all_errors)} | {np.median(all_errors):.2f} | "
                  f"{max(all_errors):.2f} | {sum(e > FAILURE for e in all_errors)} | "
                  f"{seconds[method] / options.draws:.0f} |", flush=True)


if __name__ == "__main__":
    try:
        import numpy as np
        import SimpleITK as sitk
    except ImportError as missing:
        print(f"Skipped: {missing.name} is not installed; see --help.")
        sys.exit(SKIPPED)
    main()
