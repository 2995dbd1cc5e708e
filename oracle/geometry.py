"""Geometry in f64: the spheres of a scene file, random test rays, and the intersection of rays with shells."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from oracle import sppm


@dataclass(frozen=True)
class Spheres:
    """The spheres of a scene when the shutter opens; `centers` is (n, 3), the others (n,)."""

    centers: np.ndarray
    radii: np.ndarray
    is_glass: np.ndarray
    eye: np.ndarray

    def __len__(self) -> int:
        return len(self.radii)

    def distances(self, points: np.ndarray) -> np.ndarray:
        """Signed distances of points (n, 3) from every sphere, negative inside: (n, spheres)."""
        squared = sum((points[:, None, k] - self.centers[None, :, k]) ** 2 for k in range(3))
        return np.sqrt(squared) - self.radii

    def is_free(self, points: np.ndarray, margin: np.ndarray) -> np.ndarray:
        """True for points outside of opaque matter and more than `margin` (one per sphere) from every surface."""
        outside = self.distances(points)
        around_eye = (self.distances(self.eye[None])[0] < 0) & ~self.is_glass
        room = np.where(around_eye, -outside, outside)
        return (np.where(self.is_glass, np.abs(outside), room) > margin).all(axis=1)


def spheres(name: str) -> Spheres:
    """The spheres of a scene. It must not have a background, which would be an additional sphere."""
    document = sppm.scene(name)
    if any(document.get("background", [0])):
        raise sppm.OracleError(f"{name} has a background; name a scene without")
    time = np.float32(document["camera"].get("shutter", [0])[0])
    places = [_at(sphere, time) for sphere in document["sphere"]]
    return Spheres(
        np.array(places, dtype=np.float64),
        np.array([np.float32(sphere["radius"]) for sphere in document["sphere"]], dtype=np.float64),
        np.array([_is_glass(document, sphere["material"]) for sphere in document["sphere"]]),
        np.float32(document["camera"]["eye"]).astype(np.float64),
    )


def _at(sphere: dict[str, Any], time: np.float32) -> np.ndarray:
    # In f32, as in sppm.
    return np.float32(sphere["center"]) + np.float32(sphere.get("velocity", [0, 0, 0])) * time


def _is_glass(document: dict[str, Any], material: str | dict[str, Any]) -> bool:
    found = document["materials"][material] if isinstance(material, str) else material
    return found["type"] == "dielectric"


@dataclass(frozen=True)
class Crossing:
    """Where rays cross the shell between two radii around a centre, on the side where they hit the sphere.

    `touches` is true if the ray comes near enough to hit a surface within the shell; `first` and `last` then bound the
    distance of the hit. `may_miss` is true if the ray meets the outer sphere but not the inner one, so that a surface
    within the shell may be missed.
    """

    first: np.ndarray
    last: np.ndarray
    touches: np.ndarray
    may_miss: np.ndarray


def crossing(
    origins: np.ndarray, directions: np.ndarray, centers: np.ndarray, inner: np.ndarray, outer: np.ndarray
) -> Crossing:
    """The crossing of each ray (n, 3) with its own shell; directions are unit vectors."""
    to_origin = origins - centers
    along = -np.einsum("ij,ij->i", to_origin, directions)
    nearest = to_origin + along[:, None] * directions
    squared = np.einsum("ij,ij->i", nearest, nearest)
    half_outer = np.sqrt(np.maximum(outer**2 - squared, 0.0))
    half_inner = np.sqrt(np.maximum(inner**2 - squared, 0.0))
    from_outside = np.einsum("ij,ij->i", to_origin, to_origin) > outer**2
    touches = squared <= outer**2
    may_miss = touches & (squared >= inner**2)
    # From outside, the near side of the shell is hit. If the ray misses the inner sphere, the hit may be as far as the
    # far side.
    first = np.where(from_outside, along - half_outer, along + half_inner)
    last = np.where(from_outside, np.where(may_miss, along + half_outer, along - half_inner), along + half_outer)
    return Crossing(first, last, touches, may_miss)


def uniform_directions(count: int, random: np.random.Generator) -> np.ndarray:
    """Uniformly distributed unit vectors, (count, 3)."""
    vectors = random.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def rays(name: str, world: Spheres, count: int, margin: np.ndarray, seed: int) -> np.ndarray:
    """Rays (about count, 6) of float32 that start in free space, at least `margin` from every surface.

    A third start at the eye in random directions. A third start at random points along these, in random directions. A
    third start at the same points and aim at the rims of random spheres.
    """
    random = np.random.default_rng(seed)
    third = count // 3
    from_eye = np.concatenate([np.broadcast_to(world.eye, (third, 3)), uniform_directions(third, random)], axis=1)
    hits = sppm.trace(name, from_eye)
    way = np.where(np.isfinite(hits["t"]), hits["t"], 0.0) * random.random(third)
    points = from_eye[:, :3] + way[:, None] * from_eye[:, 3:]
    anywhere = np.concatenate([points, uniform_directions(third, random)], axis=1)
    at_rims = np.concatenate([points, _towards_rims(points, world, random)], axis=1)
    found = np.concatenate([from_eye, anywhere, at_rims]).astype(np.float32)
    return found[world.is_free(found[:, :3].astype(np.float64), margin)]


def _towards_rims(points: np.ndarray, world: Spheres, random: np.random.Generator) -> np.ndarray:
    """Directions towards the rim of a random sphere, off by up to a thousandth of its radius."""
    chosen = random.integers(len(world), size=len(points))
    to_center = world.centers[chosen] - points
    side = np.cross(to_center, uniform_directions(len(points), random))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    reach = world.radii[chosen] * (1 + 1e-3 * random.uniform(-1, 1, len(points)))
    aim = to_center + side * reach[:, None]
    return aim / np.linalg.norm(aim, axis=1, keepdims=True)
