"""Tests whether two noisy images are equal: Welch's t-test per pixel, per block and of the whole image.

Differences are judged by the measured noise, never by a tolerance. An image has thousands of values, some of which
differ a lot by chance. Sidak's correction for multiple tests keeps the probability of a false alarm, over all of them
together, at `SIGNIFICANCE`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage, stats

# Probability of a false alarm: that equal images are judged different, over all levels of a verdict.
SIGNIFICANCE = 1e-3
# Sides of the blocks whose means are compared, in pixels: 1 is single pixels, WHOLE is the whole image.
WHOLE = 0
BLOCKS = (1, 8, 32, WHOLE)
# Blocks so small that rare light may be missing from one and present in the next; their errors are smoothed.
STEADIED = (1, 8)
# Error without noise, relative to the brightest channel: images are sums of float32, and the channels of photons are
# quantised to 2^-21 of their brightest one. The noise of channels fainter than this cannot be measured either, as a few
# rare paths carry all of their light.
ROUNDING = 1e-5


@dataclass(frozen=True)
class Estimate:
    """Means, their standard errors, and the degrees of freedom of these; arrays of the same shape."""

    mean: np.ndarray
    stderr: np.ndarray
    dof: np.ndarray

    @staticmethod
    def of_samples(samples: np.ndarray) -> Estimate:
        """The estimate from independent samples along the first axis."""
        count = len(samples)
        if count < 2:
            raise ValueError("it takes two samples to know an error")
        stderr = samples.std(axis=0, ddof=1) / np.sqrt(count)
        return Estimate(samples.mean(axis=0), stderr, np.full(stderr.shape, count - 1.0))

    def steadied(self) -> Estimate:
        """Raises each error to at least the root mean square of the errors in its 3x3 neighbourhood.

        Where light is rare, some pixels or blocks have received none of it yet, so their measured error is far too
        small, while their neighbours have received some. At edges this uses the larger error of both sides, which makes
        the test less sensitive but causes no false alarms.
        """
        around = ndimage.uniform_filter(self.stderr**2, size=(3, 3, 1), mode="nearest")
        return Estimate(self.mean, np.maximum(self.stderr, np.sqrt(np.maximum(around, 0.0))), self.dof)


@dataclass(frozen=True)
class Level:
    """The result of a comparison at one block size."""

    block: str
    tests: int
    largest_z: float
    p: float
    place: str


@dataclass(frozen=True)
class Verdict:
    """The result at all block sizes. `p` is the probability of at least this much difference by chance."""

    same: bool
    p: float
    levels: list[Level]

    def __str__(self) -> str:
        worst = min(self.levels, key=lambda level: level.p)
        answer = "the same" if self.same else "DIFFERENT"
        return (
            f"{answer} (p = {self.p:.2g}; {worst.tests} {worst.block}, largest |t| = {worst.largest_z:.1f} "
            f"at {worst.place})"
        )


def welch(a: Estimate, b: Estimate) -> tuple[np.ndarray, np.ndarray]:
    """Welch's t of every difference, and its two-sided p-value (Welch 1947)."""
    va, vb = (e.stderr**2 + (ROUNDING * np.abs(e.mean).max(axis=-1, keepdims=True)) ** 2 for e in (a, b))
    variance = va + vb
    with np.errstate(divide="ignore", invalid="ignore"):
        # Equal values without error, such as black in both images, give 0 rather than 0 / 0.
        t = np.where(a.mean == b.mean, 0.0, (a.mean - b.mean) / np.sqrt(variance))
        dof = np.where(variance > 0, variance**2 / (va**2 / a.dof + vb**2 / b.dof), 1.0)
    return t, 2 * stats.t.sf(np.abs(t), dof)


def family_p(p: np.ndarray) -> float:
    """The probability that the least of this many independent p-values is this small (Sidak 1967)."""
    least = float(np.min(p))
    return float(-np.expm1(p.size * np.log1p(-least))) if least < 1 else 1.0


def block_sums(image: np.ndarray, block: int) -> np.ndarray:
    """Sums over blocks of block x block pixels of (..., height, width, 3), without incomplete blocks at the edges."""
    if block == WHOLE:
        return image.sum(axis=(-3, -2), keepdims=True)
    height, width = (side // block for side in image.shape[-3:-1])
    trimmed = image[..., : height * block, : width * block, :]
    shape = (*image.shape[:-3], height, block, width, block, 3)
    return trimmed.reshape(shape).sum(axis=(-4, -2))


def of_renders(renders: np.ndarray, block: int, mask: np.ndarray) -> Estimate:
    """Block means over the pixels in `mask`, from independent renders (n, height, width, 3).

    The pixels of one render are correlated, because they share photons. So the error is taken from the variance between
    renders.
    """
    found = Estimate.of_samples(block_sums(renders * mask, block) / _counts(mask, block))
    return found.steadied() if block in STEADIED else found


def of_pixels(mean: np.ndarray, stderr: np.ndarray, dof: int, block: int, mask: np.ndarray) -> Estimate:
    """Block means over the pixels in `mask`, from an image with independent pixels, each with its own error."""
    count = _counts(mask, block)
    variance = block_sums(stderr**2 * mask, block)
    fourth = block_sums(stderr**4 * mask, block)
    freedom = np.where(fourth > 0, dof * variance**2 / np.where(fourth > 0, fourth, 1.0), dof)
    found = Estimate(block_sums(mean * mask, block) / count, np.sqrt(variance) / count, freedom)
    return found.steadied() if block in STEADIED else found


def _counts(mask: np.ndarray, block: int) -> np.ndarray:
    return np.maximum(block_sums(mask.astype(np.float64), block), 1.0)


def compare(pairs: dict[int, tuple[Estimate, Estimate]], significance: float = SIGNIFICANCE) -> Verdict:
    """The verdict over several block sizes, with Sidak's correction for their number."""
    levels = [_level(block, a, b) for block, (a, b) in pairs.items()]
    p = family_p(np.array([level.p for level in levels]))
    return Verdict(p >= significance, p, levels)


def _level(block: int, a: Estimate, b: Estimate) -> Level:
    t, p = welch(a, b)
    y, x, channel = np.unravel_index(int(np.argmin(p)), p.shape)
    place = f"({x * block}, {y * block}) {('red', 'green', 'blue')[channel]}"
    what = {1: "pixels", WHOLE: "channel means"}.get(block, f"blocks of {block}x{block}")
    return Level(what, p.size, float(np.abs(t[y, x, channel])), family_p(p), place)
