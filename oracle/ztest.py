"""Are two noisy images the same image? Welch's t-test per pixel, per block and of the whole, with Sidak's correction.

A difference is held against the noise that was measured, never against a tolerance. Of the thousands of values of an
image some are far off by chance; Sidak's correction asks of each so much that all of them together cry wolf with a
probability of `SIGNIFICANCE` only.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import ndimage, stats

# Probability that two renders of the same image are told apart, over all levels of a verdict.
SIGNIFICANCE = 1e-3
# Sides of the blocks whose means are compared, in pixels; 1 is single pixels, WHOLE is the image.
WHOLE = 0
BLOCKS = (1, 8, 32, WHOLE)
# Those so small that light which comes seldom may be lacking from one and not from the next.
STEADIED = (1, 8)
# Images are float32, summed from float32, and photons tell each channel as multiples of 2^-21 of their brightest: so far
# are two from each other, relative to the brightest channel, that have no noise at all. Of a channel that is fainter than
# that a few rare paths bring all, so nothing is known of its noise either.
ROUNDING = 1e-5


@dataclass(frozen=True)
class Estimate:
    """Means with their standard errors, and the degrees of freedom these were measured with; arrays of one shape."""

    mean: np.ndarray
    stderr: np.ndarray
    dof: np.ndarray

    @staticmethod
    def of_samples(samples: np.ndarray) -> Estimate:
        """From independent samples along the first axis."""
        count = len(samples)
        if count < 2:
            raise ValueError("it takes two samples to know an error")
        stderr = samples.std(axis=0, ddof=1) / np.sqrt(count)
        return Estimate(samples.mean(axis=0), stderr, np.full(stderr.shape, count - 1.0))

    def steadied(self) -> Estimate:
        """With errors at least as large as the root mean square of those around, over 3x3 of them.

        Where light comes seldom, some pixels or blocks have seen none of it yet, and their measured error is far too small; their
        neighbours have. At edges this takes the larger error of both sides: less power, but no false alarm.
        """
        around = ndimage.uniform_filter(self.stderr**2, size=(3, 3, 1), mode="nearest")
        return Estimate(self.mean, np.maximum(self.stderr, np.sqrt(np.maximum(around, 0.0))), self.dof)


@dataclass(frozen=True)
class Level:
    """What a comparison at one size of blocks found."""

    block: str
    tests: int
    largest_z: float
    p: float
    place: str


@dataclass(frozen=True)
class Verdict:
    """All levels of a comparison; `p` is the probability of so much difference, or more, by chance."""

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
    """Welch's t of every difference, and the two-sided probability of so large a one (Welch 1947)."""
    va, vb = (e.stderr**2 + (ROUNDING * np.abs(e.mean).max(axis=-1, keepdims=True)) ** 2 for e in (a, b))
    variance = va + vb
    with np.errstate(divide="ignore", invalid="ignore"):
        # Black on both sides, without error, is no difference.
        t = np.where(a.mean == b.mean, 0.0, (a.mean - b.mean) / np.sqrt(variance))
        dof = np.where(variance > 0, variance**2 / (va**2 / a.dof + vb**2 / b.dof), 1.0)
    return t, 2 * stats.t.sf(np.abs(t), dof)


def family_p(p: np.ndarray) -> float:
    """The probability that the least of so many independent probabilities is this small (Sidak 1967)."""
    least = float(np.min(p))
    return float(-np.expm1(p.size * np.log1p(-least))) if least < 1 else 1.0


def block_sums(image: np.ndarray, block: int) -> np.ndarray:
    """Sums over blocks of block x block pixels of (..., height, width, 3); what is left at the edges is left out."""
    if block == WHOLE:
        return image.sum(axis=(-3, -2), keepdims=True)
    height, width = (side // block for side in image.shape[-3:-1])
    trimmed = image[..., : height * block, : width * block, :]
    shape = (*image.shape[:-3], height, block, width, block, 3)
    return trimmed.reshape(shape).sum(axis=(-4, -2))


def of_renders(renders: np.ndarray, block: int, mask: np.ndarray) -> Estimate:
    """Block means over the pixels of `mask`, of independent renders (n, height, width, 3).

    The pixels of one render may depend on each other, as photons are shared: the error is that between renders.
    """
    found = Estimate.of_samples(block_sums(renders * mask, block) / _counts(mask, block))
    return found.steadied() if block in STEADIED else found


def of_pixels(mean: np.ndarray, stderr: np.ndarray, dof: int, block: int, mask: np.ndarray) -> Estimate:
    """Block means over the pixels of `mask`, of an image whose pixels are independent, each with its own error."""
    count = _counts(mask, block)
    variance = block_sums(stderr**2 * mask, block)
    fourth = block_sums(stderr**4 * mask, block)
    freedom = np.where(fourth > 0, dof * variance**2 / np.where(fourth > 0, fourth, 1.0), dof)
    found = Estimate(block_sums(mean * mask, block) / count, np.sqrt(variance) / count, freedom)
    return found.steadied() if block in STEADIED else found


def _counts(mask: np.ndarray, block: int) -> np.ndarray:
    return np.maximum(block_sums(mask.astype(np.float64), block), 1.0)


def compare(pairs: dict[int, tuple[Estimate, Estimate]], significance: float = SIGNIFICANCE) -> Verdict:
    """The verdict over several sizes of blocks, of which each gets an equal share of the significance."""
    levels = [_level(block, a, b) for block, (a, b) in pairs.items()]
    p = family_p(np.array([level.p for level in levels]))
    return Verdict(p >= significance, p, levels)


def _level(block: int, a: Estimate, b: Estimate) -> Level:
    t, p = welch(a, b)
    y, x, channel = np.unravel_index(int(np.argmin(p)), p.shape)
    place = f"({x * block}, {y * block}) {('red', 'green', 'blue')[channel]}"
    what = {1: "pixels", WHOLE: "channel means"}.get(block, f"blocks of {block}x{block}")
    return Level(what, p.size, float(np.abs(t[y, x, channel])), family_p(p), place)
