"""How errors fall: convergence.py [--iterations N] [--seeds N] [--truth N] [--radius R] [SCENE]...

The error is the mean square over pixels and channels, without the noise of the truth: the mean product of the differences
from two long renders with other seeds and a first radius of a quarter, so that their bias is a sixteenth. It is averaged
over seeds. Its slope is fitted over the iterations from 16 on, in logarithms. Then as many seeds as make the same number of
iterations are averaged, each of few iterations: their noise falls, but not their bias.

The first radius is the one that the quality `good` chooses for the small image, unless one is given; of global radii it is
smaller by the root of 2/3. `caustics` is a scene of this script: a lamp within glass, so that all light is caustics.
"""

from __future__ import annotations

import argparse
import time

import numpy as np

import sppm
from sppm import _sppm
from sppm._scene import native
from sppm._settings import of_tuple, to_tuple

SMALL = {"width": 64, "height": 48, "photons_per_iteration": 20_000}
SCENES = ["caustics", "cornell", "large", "mirror", "random", "surgery", "dusk"]
FEW = 4
"""Iterations of each of the seeds that are averaged."""


def image(scene: sppm.Scene, **settings: object) -> np.ndarray:
    """The radiance, in double precision."""
    return sppm.render(scene, progress=False, **settings).radiance.astype(np.float64)  # type: ignore[arg-type]


def error(radiance: np.ndarray, truths: list[np.ndarray]) -> float:
    """Mean square error, with the brightest twentieth of the pixels left out: lamps and their rims."""
    square = ((radiance - truths[0]) * (radiance - truths[1])).mean(axis=2).ravel()
    keep = np.argsort((truths[0] + truths[1]).sum(axis=2).ravel())[: int(0.95 * len(square))]
    return float(square[keep].mean())


def caustics() -> sppm.Scene:
    """A round room whose lamp is within a ball of glass, beside two more of them: no light is direct."""
    camera = sppm.Camera.look_at([0, 1, 8], [0, -3, -4], vertical_fov_degrees=60)
    scene = sppm.Scene(camera, name="caustics")
    scene.add_spheres([0, 0, 0], 10, sppm.Diffuse(0.5))
    scene.add_spheres([0, 3, -3], 0.4, sppm.Diffuse(0), emission=[60, 60, 60])
    scene.add_spheres([[0, 3, -3], [-2.5, -4, -3], [2.5, -4, -4]], [1.2, 1.5, 1.5], sppm.Dielectric(1.0, 1.5))
    return scene


def opened(name: str) -> sppm.Scene:
    """The scene in small."""
    scene = caustics() if name == "caustics" else sppm.Scene.load(name)
    scene.settings = scene.settings.replace(**SMALL, max_depth=16)
    return scene


def first_radius(scene: sppm.Scene, schedule: str) -> float:
    """The radius that is chosen."""
    settings = scene.settings.replace(radius_schedule=schedule)  # type: ignore[arg-type]
    chosen = _sppm.choose_settings(native(scene), to_tuple(settings), "good", [True, True, True, False, True])
    return float(of_tuple(chosen).initial_radius)


def errors_of(
    scene: sppm.Scene, schedule: str, radius: float, seeds: int, counts: list[int], truth: list[np.ndarray]
) -> list[float]:
    """The errors after so many iterations."""
    sums = np.zeros(len(counts))
    for seed in range(seeds):
        settings = {"seed": seed, "radius_schedule": schedule, "initial_radius": radius, "iterations": counts[-1]}
        with sppm.Render(scene, paused=True, **settings) as render:  # type: ignore[arg-type]
            done = 0
            for k, count in enumerate(counts):
                film = render.iterate(count - done)
                done = count
                assert film is not None
                sums[k] += error(film.radiance.astype(np.float64), truth)
    return list(sums / seeds)


def measure(name: str, words: argparse.Namespace) -> None:
    """Prints the table of a scene."""
    began = time.process_time()
    scene = opened(name)
    radii = {schedule: words.radius or first_radius(scene, schedule) for schedule in ("global", "per-pixel")}
    small = min(radii.values()) / 4
    long = {"iterations": words.truth, "initial_radius": small, "radius_schedule": "global",
            "photons_per_iteration": 100_000}
    truth = [image(scene, seed=seed, **long) for seed in (1000, 1001)]
    counts = [4 << k for k in range(20) if 4 << k <= words.iterations]
    print(f"{name}, first radius {radii['global']:.3g} (global), {radii['per-pixel']:.3g} (per pixel), {words.seeds} seeds")
    print("iterations  " + "  ".join(f"{count:9}" for count in counts))
    table = {schedule: errors_of(scene, schedule, radius, words.seeds, counts, truth) for schedule, radius in radii.items()}
    for schedule, errors in table.items():
        slope = np.polyfit(np.log(counts[2:]), np.log(errors[2:]), 1)[0]
        print(f"{schedule:10}  " + "  ".join(f"{value:9.3e}" for value in errors) + f"   slope {slope:.3f}")
    ratio = table["global"][-1] / table["per-pixel"][-1]
    seeds = counts[-1] // FEW
    few = {"iterations": FEW, "initial_radius": radii["global"], "radius_schedule": "global"}
    mean = sum(image(scene, seed=2000 + k, **few) for k in range(seeds)) / seeds
    print(f"global over per pixel at {counts[-1]}: {ratio:.2f}; {seeds} seeds of {FEW} iterations: {error(mean, truth):.3e}, "
          f"{error(mean, truth) / table['global'][-1]:.2f} times the error of {counts[-1]} iterations "
          f"({time.process_time() - began:.0f} s of CPU)\n", flush=True)


def main() -> None:
    """Prints the tables."""
    parser = argparse.ArgumentParser()
    parser.add_argument("scenes", nargs="*", default=SCENES)
    parser.add_argument("--iterations", type=int, default=512)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--truth", type=int, default=1024)
    parser.add_argument("--radius", type=float)
    words = parser.parse_args()
    for name in words.scenes:
        measure(name, words)


if __name__ == "__main__":
    main()
