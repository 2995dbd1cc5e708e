"""Tests whether the renders of a scene agree with the ground truth.

SPPM is consistent but biased: its density estimate blurs over the search radius R. Near an edge (of a shadow, a caustic
or a wall) the error is confined to a strip of width R, so a block's mean has an error that is linear in R; elsewhere it
is quadratic. We render at R, R / 2 and R / 4 with the same seeds, hence with the same photons, and extrapolate to
R = 0. No tolerance is needed: the extrapolated image is compared with the truth by its measured noise alone. The path
tracer has no bias and is compared directly.

- Means of blocks are extrapolated linearly, from R and R / 2. This removes the linear error, and leaves half of the
  quadratic one with opposite sign.
- A single pixel may lie in such a strip with all of its area, where its error is neither. It is extrapolated
  quadratically, from all three. This removes the quadratic error too, and makes the noise larger: for blocks it would
  be 1.1 to 1.7 times the linear one (measured on `random`), for nothing, as their errors are linear.

Pixels in which Mitsuba leaks light where spheres touch are left out (see `contacts`).
"""

from __future__ import annotations

import os
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from oracle import contacts, tracer, truth, ztest
from oracle.sppm import Render
from oracle.truth import Truth
from oracle.ztest import Verdict

# Initial radii for the extrapolation, in pixels at 128x96 (`pixel`).
RADII = (2.0, 1.0, 0.5)
# Photons that a pixel must have counted, in all renders together, for their variance to be a valid error estimate. With
# fewer, as on walls far behind a mirror, all renders may be missing the same rare light.
ENOUGH_PHOTONS = 30


@dataclass(frozen=True)
class Renders:
    """Independent renders of the same image, with SPPM's bias removed: (n, height, width, 3).

    `images` are for means of blocks, `pixels` for single pixels; the path tracer's are the same. `is_known` is (height,
    width, 1): 1 where the noise of a single pixel can be estimated, else 0.
    """

    images: np.ndarray
    pixels: np.ndarray
    is_known: np.ndarray


@dataclass(frozen=True)
class Effort:
    """The number of independent renders, with seeds from `first_seed` on, and the iterations and photons of each."""

    seeds: int = 16
    iterations: int = 48
    photons: int = 50_000
    first_seed: int = 1


def renders(wanted: Render, effort: Effort) -> Renders:
    """Renders an image several times with different seeds."""
    # Small renders use many threads badly: as many renders at once as there are cores, of one thread each.
    some = replace(wanted, iterations=effort.iterations, photons=effort.photons, threads=1)
    seeds = range(effort.first_seed, effort.first_seed + effort.seeds)

    def stack(radius: float) -> tuple[np.ndarray, np.ndarray]:
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            each = [replace(some, seed=seed, radius=radius) for seed in seeds]
            pairs = list(pool.map(Render.image_and_count, each))
        pictures, counts = (np.stack(list(of)).astype(np.float64) for of in zip(*pairs, strict=True))
        return pictures, counts.sum(axis=0)

    size = pixel(wanted.scene)
    if wanted.engine == "path":
        pictures, counts = stack(RADII[0] * size)
        return Renders(pictures, pictures, np.ones_like(counts))
    (large, _), (half, _), (quarter, counts) = (stack(radius * size) for radius in RADII)
    is_known = (counts >= ENOUGH_PHOTONS).astype(np.float64)
    return Renders(linear(large, half), quadratic(large, half, quarter), is_known)


@cache
def pixel(scene: str, width: int = 128, height: int = 96) -> float:
    """The side of a pixel on what is seen, in units of the scene: the median over its rays. About 1 in the scenes that are
    built in, and taken to be 1 there."""
    if not scene.endswith(".toml"):
        return 1.0
    world, camera = tracer.read(scene, time=0.0)
    _, origins, directions = next(tracer.camera_rays(camera, width, height, 1, np.random.default_rng(1)))
    hits = tracer.intersect(world, origins, directions, np.full(len(origins), tracer.NONE))
    away = np.linalg.norm(hits.points - origins, axis=1)[hits.spheres != tracer.NONE]
    side = 2 * np.tan(np.radians(camera.vertical_fov_degrees) / 2) / height
    return float(np.median(away) * side) if len(away) else 1.0


def linear(large: np.ndarray, half: np.ndarray) -> np.ndarray:
    """Extrapolates linearly to radius 0 from renders at a radius and at half of it."""
    return 2 * half - large


def quadratic(large: np.ndarray, half: np.ndarray, quarter: np.ndarray) -> np.ndarray:
    """Extrapolates quadratically to radius 0 from renders at a radius, half and a quarter of it.

    This is the value at 0 of the parabola through the three (Lagrange; Richardson's extrapolation, taken twice).
    """
    return (large - 6 * half + 8 * quarter) / 3


def verdict(ours: Renders, expected: Truth, mask: np.ndarray | None = None) -> Verdict:
    """Compares renders with the truth at all block sizes. `mask` (height, width, 1) is 1 for pixels to use, else 0."""
    whole = np.ones_like(ours.is_known) if mask is None else mask
    pairs = {}
    for block in ztest.BLOCKS:
        if block <= min(expected.mean.shape[:2]):
            counts = np.broadcast_to(whole * ours.is_known if block == 1 else whole, expected.mean.shape)
            theirs = ztest.of_pixels(expected.mean, expected.stderr, expected.batches - 1, block, counts)
            images = ours.pixels if block == 1 else ours.images
            pairs[block] = (ztest.of_renders(images, block, counts), theirs)
    return ztest.compare(pairs)


def scene(name: str, engine: str, effort: Effort) -> tuple[np.ndarray, Verdict]:
    """Renders a built-in scene and compares it with its truth; returns the mean of the renders and the verdict."""
    expected = truth.load(name)
    height, width = expected.mean.shape[:2]
    ours = renders(Render(name, width=width, height=height, engine=engine), effort)
    return ours.images.mean(axis=0), verdict(ours, expected, contacts.mask(name, width, height))
