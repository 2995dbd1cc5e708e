"""The paper's figure 8: SSIM over iterations, as an image converges."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from oracle import images, metrics, sppm
from oracle.sppm import Render

# Seeds of the measured images and of the converged image, different so that their noise is independent.
SEED, OTHER_SEED = 1, 2
# The size of the ground truth, with settings that render quickly.
WIDTH, HEIGHT, PHOTONS, DEPTH, RADIUS = 128, 96, 20_000, 5, 2.0
# Rows of the ladder: the fast engine and the paper's stages.
ROWS = ("fast", "0", "1", "2", "3", "4", "5", "6")


@dataclass(frozen=True)
class Point:
    """SSIM of one image after some iterations."""

    scene: str
    what: str
    iterations: int
    ssim: float

    def __str__(self) -> str:
        return f"{self.scene:8} {self.what:10} {self.iterations:5} iterations  SSIM {self.ssim:.4f}"


def measure(scene: str, most: int = 2048) -> Iterator[Point]:
    """SSIM of fast, reference and the paper's stages after 2, 4, 8, ... iterations, against an image of `most`.

    As in the paper, the settings are those of the timings (depth 5), and the stages use their own random numbers. All
    are compared with a converged image from another seed. That image is rendered by fast, which halves the time and
    gives the same bits as the reference.
    """
    converged = _render(scene, "fast", most, OTHER_SEED).image()
    counts = [2**k for k in range(1, most.bit_length()) if 2**k <= most]
    for iterations in counts:
        image = _render(scene, "reference", iterations, SEED).image()
        yield Point(scene, "reference", iterations, metrics.ssim(image, converged))
    with tempfile.TemporaryDirectory() as folder:
        options = [*_render(scene, "fast", most, SEED).settings(), "--rows", ",".join(ROWS), "--images", folder]
        sppm.run("ladder", "--scene", scene, *options)
        for row in ROWS:
            for iterations in counts:
                image = images.read(Path(folder) / f"{scene}-{row}-{iterations}.pfm")
                yield Point(scene, f"stage {row}" if row.isdigit() else row, iterations, metrics.ssim(image, converged))


def measure_all(scenes: Sequence[str], most: int) -> Iterator[list[Point]]:
    """The points of each scene; runs one scene per processor at a time."""
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        yield from pool.map(lambda scene: list(measure(scene, most)), scenes)


def _render(scene: str, engine: str, iterations: int, seed: int) -> Render:
    return Render(
        scene,
        width=WIDTH,
        height=HEIGHT,
        iterations=iterations,
        photons=PHOTONS,
        radius=RADIUS,
        depth=DEPTH,
        seed=seed,
        engine=engine,
    )
