"""Finds the pixels in which Mitsuba, and so the truth, leaks light where spheres touch.

Mitsuba starts a ray that leaves a surface at p a distance delta(p) beside it, along the normal (see docs/oracle.md).
Near a contact another sphere is closer than that: the ray starts beyond its surface, and sees what it should not. This
module follows paths from the eye, by the tracer, up to the first diffuse surface, through mirrors and glass. A pixel is
masked if any of its paths, or of its eight neighbours', meets a surface where another sphere is within `MARGIN` delta
along the normal.

The neighbours are needed because a leak to bright light matters even if few paths meet it: pixel (90, 88) of `random`
meets one with 0.7 % of its paths, and Mitsuba is 32 % too bright there.
"""

from __future__ import annotations

import re
from functools import cache

import numpy as np
from scipy import ndimage

from oracle import sppm, tracer, truth

# Mitsuba's offset of rays, per 1 + max |p|: 1500 roundings of float32 (RayEpsilon in its include/mitsuba/core/math.h).
OFFSET = 1500 * 2.0**-24
# Offsets that are masked. One reaches another sphere, and the rays that leave this one reach as far back.
MARGIN = 2.0
# Paths per pixel. Leaks that so few do not find are seen by a neighbour: see `mask`.
SAMPLES = 32
# Instants of a scene in motion, which share the paths.
INSTANTS = 16


@cache
def mask(name: str, width: int, height: int) -> np.ndarray:
    """1 for the pixels (height, width, 1) in which Mitsuba can be trusted, else 0."""
    leaks = np.zeros(width * height, dtype=bool)
    interval = truth.shutter(name)
    times = [None] if interval is None else [float(time) for time in np.linspace(*interval, INSTANTS)]
    random = np.random.default_rng(1)
    for time in times:
        world, camera = tracer.read(name, time)
        moved = _shift(name, width, height, time)
        for pixels, *rays in tracer.camera_rays(camera, width, height, SAMPLES // len(times), random):
            leaks[pixels[leaking(world, *rays, random, moved)]] = True
    around = ndimage.maximum_filter(leaks.reshape(height, width, 1), size=(3, 3, 1))
    return 1.0 - around


def leaking(
    world: tracer.World, origins: np.ndarray, directions: np.ndarray, random: np.random.Generator, moved: np.ndarray
) -> np.ndarray:
    """Which of the paths along these rays meet a leak, up to the first diffuse surface.

    `moved` is as of `near_contact`.
    """
    found = np.zeros(len(directions), dtype=bool)
    paths = tracer.Paths.begin(origins, directions, np.arange(len(directions)))
    for _ in range(sppm.DEEP):
        hits = tracer.intersect(world, paths.origins, paths.directions, paths.leaves)
        met = hits.spheres != tracer.NONE
        paths, hits = paths.only(met), hits.only(met)
        found[paths.pixels[near_contact(world, hits, moved)]] = True
        paths = tracer.after(world, paths, hits, random)
        paths = paths.only(~paths.has_met_diffuse)
        if not len(paths.pixels):
            break
    return found


def near_contact(world: tracer.World, hits: tracer.Hits, moved: np.ndarray) -> np.ndarray:
    """Whether another sphere is within `MARGIN` offsets of each hit, along its normal.

    `moved` (3,) is what the world was moved by for Mitsuba: the offset grows with the distance from the origin.
    """
    reach = MARGIN * OFFSET * (1 + np.abs(hits.points + moved).max(axis=1))
    found = np.zeros(len(reach), dtype=bool)
    near, others = _within(world, hits.points, reach)
    outwards = hits.points[near] - world.centers[others]
    distance = np.linalg.norm(outwards, axis=1)
    # The distance along the normal is longer than the least one, by the cosine between both: walls that meet at a right
    # angle do not leak.
    cosine = np.abs(np.einsum("ij,ij->i", outwards, hits.normals[near])) / np.maximum(distance, 1e-300)
    leaks = (np.abs(distance - world.radii[others]) < reach[near] * cosine) & (hits.spheres[near] != others)
    found[near[leaks]] = True
    return found


def _within(world: tracer.World, points: np.ndarray, reach: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of a point and a sphere whose surface may be within `reach` of it: all that are, and few that are not.

    A distance d that differs from the radius r by less than a reach e has |d^2 - r^2| < e (2 r + e).
    """
    rounding = tracer.ROUNDING
    points_squared, centers_squared = (np.einsum("ij,ij->i", of, of) for of in (points, world.centers))
    radii_squared, ones, each = world.radii**2, np.ones(len(points)), np.ones(len(world.radii))
    # The matrix of |d^2 - r^2| and that of e (2 r + e), widened by rounding, are each one product of matrices.
    terms = np.column_stack([points, points_squared, ones])
    apart = terms @ np.vstack([-2 * world.centers.T, each, centers_squared - radii_squared])
    np.abs(apart, out=apart)
    terms = np.column_stack([reach, reach**2 + rounding * points_squared, ones])
    most = terms @ np.vstack([2 * world.radii, each, rounding * (centers_squared + radii_squared)])
    return np.nonzero(apart < most)


def _shift(name: str, width: int, height: int, time: float | None) -> np.ndarray:
    """What `sppm export` moves the world by for Mitsuba, which the exported file tells in a comment."""
    told = re.search(r"moved by (\S+) along z", sppm.export(name, width, height, time))
    return np.array([0.0, 0.0, float(told[1]) if told else 0.0])
