"""The paper's figure 8: how SSIM grows as an image converges."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

from oracle import images, metrics, sppm
from oracle.sppm import Render

# Seeds of what is measured, and of the image that it is measured against: other noise.
SEED, OTHER_SEED = 1, 2
# As large as truth, and as quick.
WIDTH, HEIGHT, PHOTONS, DEPTH, RADIUS = 128, 96, 20_000, 5, 2.0
# Rows of the ladder: the engine and the paper's stages.
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
    """SSIM of fast, of reference and of the paper's stages, at 2, 4, 8, ... iterations, against as many as `most`.

    As in the paper, the settings are those of its timings (depth 5), and its stages have their own random numbers. The
    image that all are held against is converged, from another seed; it is fast's, which spares half the time and is the
    reference's in every bit.
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
    """The points of each scene, as many scenes at a time as there are processors."""
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
