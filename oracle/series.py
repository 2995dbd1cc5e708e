"""The paper's figure 8: how SSIM grows as an image converges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from oracle import metrics
from oracle.sppm import Render

# Seeds of what is measured, and of the image that it is measured against: other noise.
SEED, OTHER_SEED = 1, 2
# As large as truth, and as quick.
WIDTH, HEIGHT, PHOTONS, DEPTH, RADIUS = 128, 96, 20_000, 5, 2.0


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
    """SSIM of fast and of reference, at 2, 4, 8, ... iterations, against the reference after as many as `most`.

    As in the paper, the settings are those of its timings (depth 5). The image that all are held against is converged,
    from another seed; it is fast's, which spares half the time and is the reference's in every bit.
    """
    converged = _image(scene, "fast", most, OTHER_SEED)
    counts = [2**k for k in range(1, most.bit_length()) if 2**k <= most]
    for engine in ("fast", "reference"):
        for iterations in counts:
            image = _image(scene, engine, iterations, SEED)
            yield Point(scene, engine, iterations, metrics.ssim(image, converged))


def _image(scene: str, engine: str, iterations: int, seed: int) -> np.ndarray:
    wanted = Render(
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
    return wanted.image()
