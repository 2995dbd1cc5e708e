"""How errors fall: convergence.py [--scene NAME] [--iterations N] [--seeds N] [--truth N]

The error is the mean square over pixels and channels, without the noise of the truth: the mean product of the differences
from two long renders with other seeds and a first radius of a quarter, so that their bias is a sixteenth. It is averaged
over seeds. Its slope is fitted over the iterations from 16 on, in logarithms. Then as many seeds as make the same number of
iterations are averaged, each of few iterations: their noise falls, but not their bias.
"""

from __future__ import annotations

import argparse

import numpy as np

import sppm

SMALL = {"width": 64, "height": 48, "photons_per_iteration": 20_000}


def image(scene: sppm.Scene, **settings: object) -> np.ndarray:
    """The radiance, in double precision."""
    return sppm.render(scene, progress=False, **settings).radiance.astype(np.float64)  # type: ignore[arg-type]


def error(radiance: np.ndarray, truths: list[np.ndarray]) -> float:
    """Mean square error, with the brightest twentieth of the pixels left out: lamps and their rims."""
    square = ((radiance - truths[0]) * (radiance - truths[1])).mean(axis=2).ravel()
    keep = np.argsort((truths[0] + truths[1]).sum(axis=2).ravel())[: int(0.95 * len(square))]
    return float(square[keep].mean())


def main() -> None:
    """Prints the table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", default="cornell")
    parser.add_argument("--iterations", type=int, default=256)
    parser.add_argument("--seeds", type=int, default=4)
    parser.add_argument("--truth", type=int, default=2048)
    parser.add_argument("--radius", type=float)
    words = parser.parse_args()
    scene = sppm.Scene.load(words.scene)
    scene.settings = scene.settings.replace(**SMALL, initial_radius=words.radius)
    small = scene.settings.initial_radius / 4
    long = {"iterations": words.truth, "initial_radius": small, "radius_schedule": "global",
            "photons_per_iteration": 100_000}
    truth = [image(scene, seed=seed, **long) for seed in (1000, 1001)]
    counts = [4 << k for k in range(20) if 4 << k <= words.iterations]
    table: dict[str, list[float]] = {}
    for schedule in ("global", "per-pixel"):
        sums = np.zeros(len(counts))
        for seed in range(words.seeds):
            settings = {"seed": seed, "radius_schedule": schedule, "iterations": words.iterations}
            with sppm.Render(scene, paused=True, **settings) as render:  # type: ignore[arg-type]
                done = 0
                for k, count in enumerate(counts):
                    film = render.iterate(count - done)
                    done = count
                    assert film is not None
                    sums[k] += error(film.radiance.astype(np.float64), truth)
        table[schedule] = list(sums / words.seeds)
    few = 4
    seeds = counts[-1] // few
    mean = sum(image(scene, seed=2000 + k, iterations=few, radius_schedule="global") for k in range(seeds)) / seeds
    print(f"{words.scene}, first radius {scene.settings.initial_radius}, {words.seeds} seeds")
    print("iterations  " + "  ".join(f"{count:9}" for count in counts))
    for name, errors in table.items():
        slope = np.polyfit(np.log(counts[2:]), np.log(errors[2:]), 1)[0]
        print(f"{name:10}  " + "  ".join(f"{value:9.3e}" for value in errors) + f"   slope {slope:.3f}")
    ratio = table["global"][-1] / table["per-pixel"][-1]
    print(f"global over per pixel at {counts[-1]}: {ratio:.2f}")
    print(f"{seeds} seeds of {few} iterations: {error(mean, truth):.3e}, {error(mean, truth) / table['global'][-1]:.2f} "
          f"times the error of {counts[-1]} iterations")


if __name__ == "__main__":
    main()
