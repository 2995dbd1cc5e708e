"""Compares sppm and Mitsuba with the oracle's own path tracer, as a second witness where Mitsuba is inaccurate.

All images are rendered several times with different seeds, and judged by their measured noise (see `ztest`): means of
blocks, and of the whole image. Single pixels are too noisy to be judged, as the tracer has one plain estimator.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from oracle import judge, sppm, tracer, truth, ztest
from oracle.sppm import Render
from oracle.ztest import Verdict

SCENES = tuple(str(sppm.ROOT / "fixtures" / "scenes" / f"{name}.toml") for name in ("glass_lamp", "glass_lamp_aside"))
# The engines of sppm that are compared with the tracer.
ENGINES = ("path", "fast")
WIDTH, HEIGHT = 48, 36
BLOCKS = (8, ztest.WHOLE)


@dataclass(frozen=True)
class Effort:
    """The number of independent renders of each renderer, and the samples per pixel of each of them.

    SPPM takes `iterations` of `photons` instead of samples, at each of its radii.
    """

    renders: int = 16
    samples: int = 1024
    iterations: int = 64
    photons: int = 50_000


@dataclass(frozen=True)
class Ratio:
    """The mean of an image over that of another, per channel, and its standard error."""

    value: np.ndarray
    stderr: np.ndarray

    def __str__(self) -> str:
        names = ("red", "green", "blue")
        each = zip(names, self.value, self.stderr, strict=True)
        return ", ".join(f"{name} {value:.4f} +- {stderr:.4f}" for name, value, stderr in each)


def ratio(ours: np.ndarray, theirs: np.ndarray) -> Ratio:
    """The ratio of the mean images of independent renders (n, height, width, 3); errors to first order."""
    a, b = (ztest.of_renders(renders, ztest.WHOLE, np.ones(renders.shape[1:])) for renders in (ours, theirs))
    value = (a.mean / b.mean).ravel()
    return Ratio(value, value * np.hypot(a.stderr / a.mean, b.stderr / b.mean).ravel())


def verdict(ours: np.ndarray, theirs: np.ndarray) -> Verdict:
    """Compares independent renders (n, height, width, 3) of two renderers."""

    def estimate(renders: np.ndarray, block: int) -> ztest.Estimate:
        return ztest.of_renders(renders, block, np.ones(renders.shape[1:]))

    return ztest.compare({block: (estimate(ours, block), estimate(theirs, block)) for block in BLOCKS})


def traced(scene: str, effort: Effort, depth: int | None = None) -> np.ndarray:
    """Independent renders by the tracer, (renders, height, width, 3)."""
    seeds = range(effort.renders)
    return np.stack([tracer.render(scene, WIDTH, HEIGHT, effort.samples, seed, depth) for seed in seeds])


def rendered(scene: str, renderer: str, effort: Effort, depth: int = sppm.DEEP) -> np.ndarray:
    """Independent renders by an engine of sppm, or by `mitsuba`, whose paths are of any length."""
    if renderer == "mitsuba":
        return truth.batches(scene, truth.Plan(effort.renders, effort.samples), WIDTH, HEIGHT)
    iterations = effort.samples if renderer == "path" else effort.iterations
    wanted = Render(scene, width=WIDTH, height=HEIGHT, engine=renderer, depth=depth)
    return judge.renders(wanted, judge.Effort(effort.renders, iterations, effort.photons)).images


def scene(name: str, renderers: Sequence[str], effort: Effort) -> dict[str, tuple[Ratio, Verdict]]:
    """Compares renderers with the tracer in one scene."""
    expected = traced(name, effort)
    found = {renderer: rendered(name, renderer, effort) for renderer in renderers}
    return {renderer: (ratio(images, expected), verdict(images, expected)) for renderer, images in found.items()}
