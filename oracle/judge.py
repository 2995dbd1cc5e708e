"""The verdict on a scene: is what sppm renders the truth?

SPPM is consistent but biased: at a search radius R its density estimate blurs, and what it blurs over an edge (of a
shadow, a caustic, a wall) is off in a strip of width R, so that a block's mean is off by a share that is linear in R,
and quadratic elsewhere. Rendering at R and at R / 2 with the same seeds, hence the same photons, and extrapolating
linearly to R = 0 removes the first, and leaves half as much of the second with the other sign. No tolerance is needed:
what is extrapolated is compared with truth by its measured noise alone. The path tracer has no bias, and is compared
as it is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from oracle import truth, ztest
from oracle.sppm import Render
from oracle.truth import Truth
from oracle.ztest import Verdict

# First radii of the extrapolation, in scene units: one and two pixels of the built-in scenes at 128x96.
RADII = (2.0, 1.0)
# Photons that all renders together must have counted in a pixel before the noise between them says how far off they
# may be. Where fewer came, as on walls far behind a mirror, all renders may lack the same light.
ENOUGH_PHOTONS = 30


@dataclass(frozen=True)
class Renders:
    """Independent renders of one image: (n, height, width, 3), without SPPM's bias.

    `is_known` is (height, width, 1), 1 where the noise of a single pixel is known, else 0.
    """

    images: np.ndarray
    is_known: np.ndarray


@dataclass(frozen=True)
class Effort:
    """How much is rendered: independent renders (seeds from `first_seed` on), and the size of each."""

    seeds: int = 16
    iterations: int = 48
    photons: int = 50_000
    first_seed: int = 1


def renders(wanted: Render, effort: Effort) -> Renders:
    """Renders an image several times, each from other seeds."""
    some = replace(wanted, iterations=effort.iterations, photons=effort.photons)
    seeds = range(effort.first_seed, effort.first_seed + effort.seeds)

    def stack(radius: float) -> tuple[np.ndarray, np.ndarray]:
        pairs = [replace(some, seed=seed, radius=radius).image_and_count() for seed in seeds]
        pictures, counts = (np.stack(list(of)).astype(np.float64) for of in zip(*pairs, strict=True))
        return pictures, counts.sum(axis=0)

    if wanted.engine == "path":
        pictures, counts = stack(RADII[0])
        return Renders(pictures, np.ones_like(counts))
    (large, _), (small, counts) = (stack(radius) for radius in RADII)
    return Renders(extrapolated(large, small), (counts >= ENOUGH_PHOTONS).astype(np.float64))


def extrapolated(large: np.ndarray, small: np.ndarray) -> np.ndarray:
    """What renders at a radius and at half of it tell of radius 0."""
    return 2 * small - large


def verdict(ours: Renders, expected: Truth, mask: np.ndarray | None = None) -> Verdict:
    """Holds renders against truth on all sizes of blocks; `mask` (height, width, 1) is 1 where pixels count, else 0."""
    whole = np.ones_like(ours.is_known) if mask is None else mask
    pairs = {}
    for block in ztest.BLOCKS:
        if block <= min(expected.mean.shape[:2]):
            counts = np.broadcast_to(whole * ours.is_known if block == 1 else whole, expected.mean.shape)
            theirs = ztest.of_pixels(expected.mean, expected.stderr, expected.batches - 1, block, counts)
            pairs[block] = (ztest.of_renders(ours.images, block, counts), theirs)
    return ztest.compare(pairs)


def scene(name: str, engine: str, effort: Effort) -> tuple[np.ndarray, Verdict]:
    """Renders a built-in scene and judges it by its truth; the mean of the renders, and the verdict."""
    expected = truth.load(name)
    height, width = expected.mean.shape[:2]
    ours = renders(Render(name, width=width, height=height, engine=engine), effort)
    return ours.images.mean(axis=0), verdict(ours, expected)
