"""Tests whether two noisy images are equal: Welch's t-test per pixel, per block and of the whole image.

Differences are judged by the measured noise, never by a tolerance. An image has thousands of values, some of which
differ a lot by chance. Sidak's correction for multiple tests keeps the probability of a false alarm, over all of them
together, at `SIGNIFICANCE`.

A t-test needs means that are nearly normal. A mean of few samples is not where its samples are skewed, as they are
where light is rare: most renders miss it, so both their mean and their measured error are too small, and t is far from
zero in images without a fault. A level is judged only if it holds enough samples for its skewness, by the rule of
Cochran ("Sampling Techniques", 3rd edition 1977, section 2.15): n > 25 G1^2, with G1 Fisher's skewness. Where it does
not hold, a difference is no evidence, and the verdict is that there is none: undecided.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum

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
# Images of at least this many values in a side have neighbours that are alike, and whose samples can be taken together.
MANY = 8
# Cochran's factor: a mean of n samples is near enough to normal if n is at least this times the square of the skewness.
COCHRAN = 25.0


class Answer(StrEnum):
    """Whether two images are equal, as far as it can be told."""

    SAME = "the same"
    DIFFERENT = "different"
    UNDECIDED = "undecided"


@dataclass(frozen=True)
class Estimate:
    """Means, their standard errors, and the degrees of freedom of these; arrays of the same shape.

    `skewness` is that of the samples, typical of all means (see `skewness`); 0 if the samples are not known.
    """

    mean: np.ndarray
    stderr: np.ndarray
    dof: np.ndarray
    skewness: float = 0.0

    @property
    def is_normal(self) -> bool:
        """Whether there are enough samples for the distribution of the means to be near a normal one."""
        return float(np.min(self.dof)) + 1 >= COCHRAN * self.skewness**2

    @staticmethod
    def of_samples(samples: np.ndarray) -> Estimate:
        """The estimate from independent samples along the first axis."""
        count = len(samples)
        if count < 2:
            raise ValueError("it takes two samples to know an error")
        stderr = samples.std(axis=0, ddof=1) / np.sqrt(count)
        mean = samples.mean(axis=0)
        return Estimate(mean, stderr, np.full(stderr.shape, count - 1.0), skewness(samples))

    def steadied(self) -> Estimate:
        """Raises each error to at least the root mean square of the errors in its 3x3 neighbourhood.

        Where light is rare, some pixels or blocks have received none of it yet, so their measured error is far too
        small, while their neighbours have received some. At edges this uses the larger error of both sides, which makes
        the test less sensitive but causes no false alarms.
        """
        around = ndimage.uniform_filter(self.stderr**2, size=(3, 3, 1), mode="nearest")
        stderr = np.maximum(self.stderr, np.sqrt(np.maximum(around, 0.0)))
        return Estimate(self.mean, stderr, self.dof, self.skewness)


def skewness(samples: np.ndarray) -> float:
    """Fisher's skewness of independent samples along the first axis, typical of all values of an image.

    The skewness of a few samples is uncertain, so it is that of the samples of 3x3 neighbours, if there are many. It
    is the median over the image, less its standard error in normal samples, and at least 0.
    """
    residuals = samples - samples.mean(axis=0)
    second, third = ((residuals**power).mean(axis=0) for power in (2, 3))
    count = float(len(samples))
    if samples.ndim == 4 and min(samples.shape[1:3]) >= MANY:
        second, third = (ndimage.uniform_filter(moment, size=(3, 3, 1), mode="nearest") for moment in (second, third))
        count *= 9
    floor = (ROUNDING * np.abs(samples).max(initial=0.0)) ** 2
    noisy = second > floor
    if count < 3 or not noisy.any():
        return 0.0
    found = np.abs(third[noisy]) / second[noisy] ** 1.5 * np.sqrt(count * (count - 1)) / (count - 2)
    stderr = np.sqrt(6 * count * (count - 1) / ((count - 2) * (count + 1) * (count + 3)))
    return max(0.0, float(np.median(found) - stderr))


@dataclass(frozen=True)
class Level:
    """The result of a comparison at one block size. `is_judged` tells whether it has enough samples for its skewness."""

    block: str
    tests: int
    largest_z: float
    p: float
    place: str
    skewness: float
    is_judged: bool


@dataclass(frozen=True)
class Verdict:
    """The result at all block sizes.

    `p` is the probability of at least this much difference by chance, over the levels that are judged. The images are
    different if these say so, and undecided if only others do or if none is judged.
    """

    answer: Answer
    p: float
    levels: list[Level]

    @property
    def same(self) -> bool:
        """Whether no level differs, and at least one is judged."""
        return self.answer is Answer.SAME

    @property
    def different(self) -> bool:
        """Whether a level that is judged differs."""
        return self.answer is Answer.DIFFERENT

    def __str__(self) -> str:
        worst = min(self.levels, key=lambda level: level.p)
        answer = "DIFFERENT" if self.different else str(self.answer)
        text = (
            f"{answer} (p = {self.p:.2g}; {worst.tests} {worst.block}, largest |t| = {worst.largest_z:.1f} "
            f"at {worst.place}"
        )
        unjudged = [f"{level.block} (skewness {level.skewness:.1f})" for level in self.levels if not level.is_judged]
        return text + (f"; too few samples to judge {', '.join(unjudged)})" if unjudged else ")")


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
    judged = [level.p for level in levels if level.is_judged]
    p = family_p(np.array(judged)) if judged else 1.0
    if p < significance:
        return Verdict(Answer.DIFFERENT, p, levels)
    is_sure = bool(judged) and family_p(np.array([level.p for level in levels])) >= significance
    return Verdict(Answer.SAME if is_sure else Answer.UNDECIDED, p, levels)


def _level(block: int, a: Estimate, b: Estimate) -> Level:
    t, p = welch(a, b)
    y, x, channel = np.unravel_index(int(np.argmin(p)), p.shape)
    place = f"({x * block}, {y * block}) {('red', 'green', 'blue')[channel]}"
    what = {1: "pixels", WHOLE: "channel means"}.get(block, f"blocks of {block}x{block}")
    largest = float(np.abs(t[y, x, channel]))
    is_judged = a.is_normal and b.is_normal
    return Level(what, p.size, largest, family_p(p), place, max(a.skewness, b.skewness), is_judged)
