#!/usr/bin/env python3
"""Draws the icon: an axial slice of a head, splatted from a few hundred Gaussians. Needs NumPy.

    Utilities/draw-icon.py Resources/Icons/InnerGS.png
"""

import struct
import sys
import zlib

import numpy as np

SIZE = 128
OVER = 3  # samples per pixel and axis


def gaussians():
    """(x, y, along, across, angle, colour, weight) in units of the icon's half width."""
    random = np.random.default_rng(7)
    cortex, white, deep = np.array([[255, 186, 73], [98, 182, 224], [46, 92, 160]]) / 255
    # The folded rim: its radius undulates, so that gyri bulge and sulci cut in; a fissure divides the halves.
    for angle in np.arange(0, 2 * np.pi, 2 * np.pi / 110):
        wave = 0.045 * np.cos(13 * angle) + 0.03 * np.cos(22 * angle + 1)
        radius = 0.80 + wave
        x, y = 0.80 * radius * np.sin(angle), radius * np.cos(angle)
        if abs(x) > 0.06:
            yield x, y, 0.055, 0.04, np.arctan2(y, x), cortex * random.uniform(0.88, 1), 1.0
    for _ in range(420):
        radius, angle = np.sqrt(random.uniform()) * 0.68, random.uniform(0, 2 * np.pi)
        x, y = 0.80 * radius * np.sin(angle), radius * np.cos(angle)
        if abs(x) < 0.05 and abs(y) > 0.28:
            continue
        ventricle = (abs(x) - 0.11) ** 2 / 0.07**2 + y**2 / 0.24**2 < 1
        yield x, y, random.uniform(0.04, 0.075), 0.03, angle, (deep if ventricle else white) * random.uniform(0.85, 1), 0.8


def render():
    n = SIZE * OVER
    axis = (np.arange(n) + 0.5) / n * 2 - 1
    x, y = np.meshgrid(axis, -axis)
    colour = np.zeros((n, n, 3))
    total = np.full((n, n), 1e-6)
    for cx, cy, along, across, angle, rgb, weight in gaussians():
        u = (x - cx) * np.cos(angle) + (y - cy) * np.sin(angle)
        v = -(x - cx) * np.sin(angle) + (y - cy) * np.cos(angle)
        splat = weight * np.exp(-0.5 * ((u / along) ** 2 + (v / across) ** 2))
        colour += splat[..., None] * rgb
        total += splat
    brain = colour / total[..., None]
    opacity = 1 - np.exp(-3 * total)
    # On a dark disc, so that it is visible on light and dark toolbars.
    disc = np.clip((0.985 - np.hypot(x, y)) * n / 2, 0, 1)
    rgb = brain * opacity[..., None] + np.array([0.07, 0.10, 0.17]) * (1 - opacity[..., None])
    rgba = np.dstack([rgb * disc[..., None], disc])
    rgba = rgba.reshape(SIZE, OVER, SIZE, OVER, 4).mean(axis=(1, 3))
    rgba[..., :3] /= np.maximum(rgba[..., 3:], 1e-6)
    return np.clip(np.round(255 * rgba), 0, 255).astype(np.uint8)


def write(path, pixels):
    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    rows = b"".join(b"\0" + row.tobytes() for row in pixels)
    header = struct.pack(">IIBBBBB", pixels.shape[1], pixels.shape[0], 8, 6, 0, 0, 0)
    with open(path, "wb") as file:
        file.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(rows, 9)) + chunk(b"IEND", b""))


if __name__ == "__main__":
    for name in sys.argv[1:]:
        write(name, render())
