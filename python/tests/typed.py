"""A program that uses the package with all its types. Type checkers read it; it is not run."""

from __future__ import annotations

from datetime import timedelta
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import sppm


def build() -> sppm.Scene:
    scene = sppm.Scene(
        sppm.Camera.look_at((0, 0, 9), np.zeros(3)),
        settings=sppm.Settings(width=320, height=240),
        background=[0.1, 0.1, 0.1],
    )
    centers: NDArray[np.float64] = np.zeros((10, 3))
    added: range = scene.add_spheres(centers, 1, sppm.Diffuse(0.5), velocity=[0, 1, 0])
    scene.add_spheres([[1, 2, 3]], [1.5], [sppm.Dielectric(ior=1.3)], emission=(1, 2, 3))
    scene.add_spheres([1, 2, 3], 1, scene.add_material(sppm.Specular([0.9, 0.9, 0.9])))
    scene.centers = scene.centers + 1
    scene.camera = scene.camera.replace(eye=[0, 0, 8])
    scene.remove_spheres([added[0]])
    scene.remove_spheres(scene.radii > 3)
    scene.save(Path("mine.toml"))
    return scene


def show(path: Path) -> sppm.Film:
    particles: sppm.Particles = sppm.Particles.load(path, frame="last", properties=["charge"])
    places: NDArray[np.float64] = particles.positions
    charges = particles.properties["charge"] * 2
    cell: sppm.Cell | None = particles.cell
    mine = sppm.Particles(places, elements=["C"] * len(particles), properties={"q": charges}, cell=cell, unit="angstrom")
    scene: sppm.Scene = sppm.load_particles(
        mine, color="q", range=("5%", 3), radius=0.5, style=["z > 3: hide", {"where": "x < 1", "scale": 2.0}], view="iso"
    )
    added: range = scene.add_particles(path, bonds="distance", cut="x > 0", origin=(1, 2, 3))
    print(added, sppm.frame_count(path), scene.method)
    return sppm.render(scene)


def use(scene: sppm.Scene) -> float:
    film: sppm.Film = sppm.render(scene, iterations=8, engine="reference", progress=print, time=timedelta(minutes=1))
    radiance: NDArray[np.float32] = film.radiance
    if film.radius is not None:
        radiance = radiance * film.radius[..., None]
    with sppm.Render(scene, checkpoint="a.sppm", every=10) as render:
        for progress in render:
            if progress.mean_radius is not None and progress.mean_radius < 0.1:
                render.stop()
        for snapshot in render.films(every=4):
            snapshot.save("a.exr")
        result: sppm.Film = render.result(interrupt="return")
    hits = sppm.trace(scene, [0, 0, 9], np.array([[0, 0, -1.0]]))
    metrics: sppm.Metrics = sppm.compare(result, "truth.exr")
    distance: NDArray[np.float32] = hits.t
    picture, scale = sppm.difference_image(radiance, result)
    picture.save("where.png")
    return metrics.rmse.all + scale + float(distance.min())
