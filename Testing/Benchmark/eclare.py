#!/usr/bin/env python3
"""Compares InnerGS with ECLARE (https://pypi.org/project/eclare), which also learns from a scan's own in-plane detail.

    python3 -m venv peer && peer/bin/pip install eclare
    peer/bin/python Testing/Benchmark/eclare.py VOLUME --innergs build/bin/innergs --thickness 4 --patches 30000

Both see the slices that `innergs simulate` takes from the volume and are scored as `innergs evaluate` scores: PSNR and
SSIM inside the body mask of the truth. The rule is applied to our volume as well and must give what `evaluate` says.
ECLARE is given the true slice profile; --estimate-profile lets it estimate its own. What it made elsewhere, such as on
a GPU, of the scan that this script leaves in its folder (scan.nii) is scored with --result FILE, without the package.
"""
import argparse
import importlib.metadata
import json
import os
import platform
import resource
import subprocess
import sys
import time
from pathlib import Path

SKIPPED = 77
AGREEMENT = 0.005  # dB


def arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("volume", type=Path, help="the truth, with cubic voxels")
    parser.add_argument("--innergs", type=Path, required=True, help="the innergs command")
    case = parser.add_mutually_exclusive_group(required=True)
    case.add_argument("--thickness", type=int, metavar="K", help="axial slices averaged over K voxels")
    case.add_argument("--keep-every", type=int, metavar="K", help="every K-th axial slice kept")
    parser.add_argument("--patches", type=int, nargs="+", default=[30000], metavar="N",
                        help="patches that ECLARE trains on, one run for each number [30000; its default: 1000000]")
    parser.add_argument("--preset", default="balanced", help="of InnerGS [balanced]")
    parser.add_argument("--threads", type=int, default=1, help="of both [1]")
    parser.add_argument("--estimate-profile", action="store_true", help="ECLARE estimates the slice profile")
    parser.add_argument("--result", type=Path, nargs="+", default=[], metavar="FILE",
                        help="volumes that ECLARE made elsewhere of the same scan, to score in place of running it")
    parser.add_argument("--work", type=Path, default=Path("eclare-work"), help="folder for results [eclare-work]")
    return parser.parse_args()


def run(words, log, threads):
    """Runs a program, which prints to a log, and returns its CPU and wall seconds."""
    environment = dict(os.environ, OMP_NUM_THREADS=str(threads))
    before, begun = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic()
    with open(log, "w") as output:
        status = subprocess.run([str(word) for word in words], stdout=output, stderr=subprocess.STDOUT, env=environment)
    if status.returncode:
        sys.exit(f"{words[0]} failed with exit code {status.returncode}, see {log}.")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    cpu = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    return cpu, time.monotonic() - begun


def body_mask(truth):
    """Above Otsu's threshold, largest component, holes filled slice by slice."""
    import numpy as np
    from scipy import ndimage
    low, width = truth.min(), (truth.max() - truth.min()) / 256
    bins = np.minimum(255, ((truth - low) / width).astype(int))
    counts = np.bincount(bins.ravel(), minlength=256).astype(float)
    below, moment = np.cumsum(counts)[:-1], np.cumsum(counts * np.arange(256))
    above = counts.sum() - below
    with np.errstate(divide="ignore", invalid="ignore"):
        between = below * above * (moment[:-1] / below - (moment[-1] - moment[:-1]) / above) ** 2
    between = np.nan_to_num(between)
    best = np.flatnonzero(between >= between.max() * (1 - 1e-12))
    parts, _ = ndimage.label(truth > low + width * (0.5 * (best[0] + best[-1]) + 1))
    sizes = np.bincount(parts.ravel())
    sizes[0] = 0
    body = parts == sizes.argmax()
    for k in range(body.shape[2]):
        body[:, :, k] = ndimage.binary_fill_holes(body[:, :, k])
    return body


def ssim_map(image, truth, peak):
    """Of one slice: window of 11 x 11, sigma 1.5."""
    import numpy as np
    from scipy import ndimage
    window = np.exp(-0.5 * (np.arange(-5, 6) / 1.5) ** 2)
    window /= window.sum()

    def mean(x):
        return ndimage.correlate1d(ndimage.correlate1d(x, window, 0), window, 1)

    a, b = mean(image), mean(truth)
    variances = mean(image * image) - a * a, mean(truth * truth) - b * b
    covariance = mean(image * truth) - a * b
    c1, c2 = (0.01 * peak) ** 2, (0.03 * peak) ** 2
    return (2 * a * b + c1) * (2 * covariance + c2) / ((a * a + b * b + c1) * (variances[0] + variances[1] + c2))


def score(image, truth, body, slices):
    """PSNR and SSIM pooled over the body in these slices, and the number of voxels."""
    import numpy as np
    peak = truth.max() - truth.min()
    squares, ssim, count = 0.0, 0.0, 0
    for k in slices:
        inside = body[:, :, k]
        squares += ((image[:, :, k] - truth[:, :, k])[inside] ** 2).sum()
        ssim += ssim_map(image[:, :, k], truth[:, :, k], peak)[inside].sum()
        count += int(inside.sum())
    return 10 * np.log10(peak ** 2 * count / squares), ssim / count, count


def on_grid(image, shape, affine, order):
    """A NIfTI image's values at the voxels of another grid: cubic B-spline, or nearest with order 0."""
    import numpy as np
    from scipy import ndimage
    move = np.linalg.inv(image.affine) @ affine
    return ndimage.affine_transform(image.get_fdata(), move[:3, :3], move[:3, 3], shape, order=order, mode="nearest")


def main():
    o = arguments()
    version = "elsewhere"
    if not o.result:
        try:
            version = importlib.metadata.version("eclare")
        except importlib.metadata.PackageNotFoundError:
            print("Skipped: the package eclare is not installed for " + sys.executable + "; see the head of this file.")
            return SKIPPED
    import nibabel

    o.work.mkdir(parents=True, exist_ok=True)
    thick = o.thickness is not None
    factor = o.thickness if thick else o.keep_every
    case = ["--thickness" if thick else "--keep-every", factor]
    scan, ours, report = o.work / "scan.nii", o.work / "innergs.nii", o.work / "innergs.json"
    run([o.innergs, "simulate", o.volume, *case, "--axis", "axial", "--quiet", "-o", scan],
        o.work / "simulate.log", o.threads)
    run([o.innergs, "evaluate", o.volume, *case, "--preset", o.preset, "--threads", o.threads, "--quiet",
         "--json", report, "--save-volume", ours], o.work / "evaluate.log", o.threads)

    reported = json.loads(report.read_text())
    volume = nibabel.load(ours)
    shape, affine = volume.shape, volume.affine
    truth = on_grid(nibabel.load(o.volume), shape, affine, 0)
    body = body_mask(truth)
    slices = [k for k in range(shape[2]) if thick or k % factor]
    psnr, ssim, count = score(volume.get_fdata(), truth, body, slices)
    said = reported["methods"]["gaussians"]
    if count != reported["voxels"] or abs(psnr - said["psnr"]) > AGREEMENT or abs(ssim - said["ssim"]) > 1e-3:
        print(f"This script scores our volume with {psnr:.3f} dB, SSIM {ssim:.4f}, on {count} voxels, innergs evaluate "
              f"with {said['psnr']:.3f} dB, SSIM {said['ssim']:.4f}, on {reported['voxels']}: its rule is wrong.")
        return 1

    rows = [(name, m["psnr"], m["ssim"], m["cpu_seconds"], m["seconds"]) for name, m in reported["methods"].items()
            if name != "gaussians"]
    rows.append((f"InnerGS, preset {o.preset}", psnr, ssim, said["cpu_seconds"], said["seconds"]))
    profile = [] if o.estimate_profile else ["--relative-slice-thickness", factor if thick else 1,
                                             "--relative-slice-profile-type", "boxcar"]
    for path in o.result:
        found = on_grid(nibabel.load(path), shape, affine, 3)
        rows.append((f"ECLARE, {path.name}", *score(found, truth, body, slices)[:2], float("nan"), float("nan")))
    for patches in [] if o.result else o.patches:
        folder = o.work / f"patches-{patches}"
        folder.mkdir(exist_ok=True)
        cpu, wall = run([Path(sys.executable).parent / "run-eclare", "--in-fpath", scan, "--out-dir", folder,
                         "--n-patches", patches, *profile], folder / "eclare.log", o.threads)
        found = on_grid(nibabel.load(folder / "scan_eclare.nii"), shape, affine, 3)
        rows.append((f"ECLARE, {patches:,} patches", *score(found, truth, body, slices)[:2], cpu, wall))

    names = ("numpy", "scipy") if o.result else ("torch", "numpy", "scipy")
    versions = ", ".join(f"{name} {importlib.metadata.version(name)}" for name in names)
    innergs = subprocess.run([str(o.innergs), "--version"], check=True, capture_output=True, text=True).stdout.strip()
    print(f"\n{o.volume.name}, {' '.join(map(str, case))}: {reported['samples']}\n"
          f"ECLARE {version} ({versions}, Python {platform.python_version()}), "
          f"{'profile estimated' if o.estimate_profile else 'true slice profile given'}; {innergs}; "
          f"{o.threads} thread(s) each\n")
    print("| method | PSNR, dB | SSIM | CPU seconds | seconds |\n|---|---|---|---|---|")
    for name, *figures in rows:
        print("| {} | {:.2f} | {:.4f} | {:.1f} | {:.1f} |".format(name, *figures))
    return 0


if __name__ == "__main__":
    sys.exit(main())
