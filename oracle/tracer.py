"""An independent path tracer in double precision: the oracle's second witness of light, beside Mitsuba.

It reads a scene file and shares no code with sppm. It is made to be checked by reading, so a path from the eye adds the
emission of whatever it hits, and that is all, but for lamps that are small and far, such as a sun: diffuse surfaces ask these
straight (`far_lamps`), and paths from there do not count them. There is no offset along rays: a ray that leaves a sphere
knows it, and meets that sphere again only at the far end of its chord.

The formulas are those of textbooks:

- rays and spheres, from the nearest approach: Haines, Gunther and Akenine-Moller, "Precision improvements for
  ray/sphere intersection", Ray Tracing Gems (2019), chapter 7;
- Lambertian reflection, sampled in proportion to the cosine: Pharr, Jakob and Humphreys, "Physically Based Rendering",
  4th edition (2023), sections 9.2 and A.5.3;
- Snell's law and Fresnel's equations for unpolarised light: the same, section 9.5;
- radiance that grows with the square of the index: Veach, "Robust Monte Carlo methods for light transport simulation"
  (1997), section 5.2;
- the cone in which a sphere is seen: Pharr, Jakob and Humphreys, section 6.2.4;
- Russian roulette: Arvo and Kirk, "Particle transport and image synthesis", SIGGRAPH 1990.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from oracle import sppm

DIFFUSE, SPECULAR, DIELECTRIC = range(3)
KINDS = {"diffuse": DIFFUSE, "specular": SPECULAR, "dielectric": DIELECTRIC}
# "No sphere", for a ray that leaves the eye or meets nothing.
NONE = -1
# Segments after which a path is an error rather than a sample. Only light caught in lossless glass is so long.
SEGMENTS_AT_MOST = 10_000
# A lamp is asked straight if its radius is so small a part of its distance from the eye, and that is so many times the distance
# of the nearest thing.
SMALL, FAR = 0.1, 100.0
# Some ten roundings of float64, relative to the terms of a sum.
ROUNDING = 1e-14
# Rays that are traced together, which bounds the memory.
TOGETHER = 1 << 14


@dataclass(frozen=True)
class World:
    """The spheres of a scene: `centers`, `albedos` and `emissions` are (n, 3), the others (n,).

    `background` (3,) is the radiance of rays that meet nothing.
    """

    centers: np.ndarray
    radii: np.ndarray
    kinds: np.ndarray
    albedos: np.ndarray
    iors: np.ndarray
    emissions: np.ndarray
    background: np.ndarray


@dataclass(frozen=True)
class Camera:
    """A thin lens, or a pinhole if `aperture_radius` is 0. `frame` has the rows right, up and forward, orthonormal."""

    eye: np.ndarray
    frame: np.ndarray
    vertical_fov_degrees: float
    aperture_radius: float
    focus_distance: float

    def rays(
        self, x: np.ndarray, y: np.ndarray, width: int, height: int, random: np.random.Generator
    ) -> tuple[np.ndarray, np.ndarray]:
        """Origins and unit directions (n, 3) of rays through positions x, y, in pixels from the image's top left."""
        pixel = 2 * np.tan(np.radians(self.vertical_fov_degrees) / 2) / height
        in_focus = np.stack([(x - width / 2) * pixel, (height / 2 - y) * pixel, np.ones_like(x)], axis=1)
        in_focus *= self.focus_distance
        radius, angle = self.aperture_radius * np.sqrt(random.random(len(x))), 2 * np.pi * random.random(len(x))
        on_lens = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros_like(x)], axis=1)
        return self.eye + on_lens @ self.frame, _unit((in_focus - on_lens) @ self.frame)


@dataclass
class Paths:
    """Paths on their way: the next ray of each, and what it has gathered.

    `leaves` is the sphere that the ray starts on, or NONE. `scale` is the product of the factors from refraction; it is
    kept out of `throughput`, which decides roulette. `length` counts segments, from the eye or from the first diffuse
    surface. `pixels` tells whose paths they are.
    """

    origins: np.ndarray
    directions: np.ndarray
    leaves: np.ndarray
    throughput: np.ndarray
    scale: np.ndarray
    length: np.ndarray
    has_met_diffuse: np.ndarray
    # Far lamps were asked where the path was last scattered.
    has_asked: np.ndarray
    pixels: np.ndarray

    @staticmethod
    def begin(origins: np.ndarray, directions: np.ndarray, pixels: np.ndarray) -> Paths:
        """Paths that leave the eye."""
        count = len(directions)
        return Paths(
            origins,
            directions,
            np.full(count, NONE),
            np.ones((count, 3)),
            np.ones(count),
            np.zeros(count, dtype=np.int64),
            np.zeros(count, dtype=bool),
            np.zeros(count, dtype=bool),
            pixels,
        )

    def only(self, kept: np.ndarray) -> Paths:
        """Those of the paths that a mask or an array of indices names."""
        return Paths(**{name: values[kept] for name, values in vars(self).items()})


@dataclass(frozen=True)
class Hits:
    """Where rays meet spheres: points and unit normals that face the ray, (n, 3); `is_inside` if from within."""

    points: np.ndarray
    normals: np.ndarray
    spheres: np.ndarray
    is_inside: np.ndarray

    def only(self, kept: np.ndarray) -> Hits:
        """Those of the hits that a mask names."""
        return Hits(**{name: values[kept] for name, values in vars(self).items()})


def read(name: str, time: float | None = None) -> tuple[World, Camera]:
    """The spheres and the camera of a scene, at an instant if it moves."""
    document = sppm.scene(name)
    moves = any("velocity" in sphere for sphere in document["sphere"])
    if moves and time is None:
        raise sppm.OracleError(f"{name} moves; the tracer takes spheres at rest")
    materials = [_material(document, sphere) for sphere in document["sphere"]]

    def column(values: list[Any]) -> np.ndarray:
        # Rounded to f32, as sppm does, so that both see the same scene.
        return np.array(values, dtype=np.float32).astype(np.float64)

    velocities = column([sphere.get("velocity", [0, 0, 0]) for sphere in document["sphere"]])
    world = World(
        column([sphere["center"] for sphere in document["sphere"]]) + velocities * (time or 0),
        column([sphere["radius"] for sphere in document["sphere"]]),
        np.array([KINDS[material["type"]] for material in materials]),
        column([material["albedo"] for material in materials]),
        column([material.get("ior", 1) for material in materials]),
        column([sphere.get("emission", [0, 0, 0]) for sphere in document["sphere"]]),
        column(document.get("background", [0, 0, 0])),
    )
    return world, _camera(document["camera"])


def _material(document: dict[str, Any], sphere: dict[str, Any]) -> dict[str, Any]:
    stated = sphere["material"]
    return document["materials"][stated] if isinstance(stated, str) else stated


def _camera(stated: dict[str, Any]) -> Camera:
    eye = np.array(stated["eye"], dtype=np.float64)
    towards = stated["direction"] if "direction" in stated else np.subtract(stated["target"], eye)
    forward = _unit(np.array([towards], dtype=np.float64))[0]
    right = _unit(np.cross(forward, stated.get("up", [0, 1, 0]))[None])[0]
    to_target = float(np.linalg.norm(np.subtract(stated["target"], eye))) if "target" in stated else 1.0
    return Camera(
        eye,
        np.stack([right, np.cross(right, forward), forward]),
        stated["vertical_fov_degrees"],
        stated.get("aperture_radius", 0.0),
        stated.get("focus_distance", to_target),
    )


def render(name: str, width: int, height: int, samples: int, seed: int, depth: int | None = None) -> np.ndarray:
    """One image (height, width, 3): the mean radiance of independent paths through random points of every pixel.

    At most `depth` segments lead to the first diffuse surface, and at most as many from there on; None is no limit.
    """
    world, camera = read(name)
    lamps = far_lamps(world, camera)
    total = np.zeros((height * width, 3))
    random = np.random.default_rng(seed)
    for pixels, origins, directions in camera_rays(camera, width, height, samples, random):
        np.add.at(total, pixels, trace(world, origins, directions, random, depth, lamps))
    return total.reshape(height, width, 3) / samples


def camera_rays(
    camera: Camera, width: int, height: int, samples: int, random: np.random.Generator
) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Rays through random points of all pixels, some at a time: the pixels they belong to, origins and directions."""
    count = width * height * samples
    for first in range(0, count, TOGETHER):
        pixels = np.arange(first, min(first + TOGETHER, count)) % (width * height)
        y, x = np.divmod(pixels, width)
        yield pixels, *camera.rays(x + random.random(len(x)), y + random.random(len(y)), width, height, random)


def far_lamps(world: World, camera: Camera) -> list[int]:
    """The opaque lamps that are small and far, as seen from the eye."""
    distances = np.linalg.norm(world.centers - camera.eye, axis=1)
    is_around, is_lamp = distances < world.radii, (world.emissions.max(axis=1) > 0) & (world.kinds != DIELECTRIC)
    is_small = is_lamp & ~is_around & (world.radii < SMALL * distances)
    nearest = np.min(distances[~is_small & ~is_around] - world.radii[~is_small & ~is_around], initial=np.inf)
    return [int(lamp) for lamp in np.flatnonzero(is_small & (distances > FAR * nearest))]


def asked(
    world: World, points: np.ndarray, normals: np.ndarray, spheres: np.ndarray, lamp: int, random: np.random.Generator
) -> np.ndarray:
    """An estimate of the irradiance (n, 3) at points on spheres, straight from a lamp: one direction in its cone for each."""
    to_lamp = world.centers[lamp] - points
    distance = np.sqrt(_dot(to_lamp, to_lamp))
    # At most 1, on the lamp itself, which it does not light.
    squared_sine = np.minimum((world.radii[lamp] / distance) ** 2, 1)
    # 1 - cos of the cone, without cancellation.
    height = squared_sine / (1 + np.sqrt(1 - squared_sine))
    axis = to_lamp / distance[:, None]
    side = _unit(np.cross(axis, np.where(np.abs(axis[:, :1]) > 0.5, [[0.0, 1.0, 0.0]], [[1.0, 0.0, 0.0]])))
    along, angle = 1 - height * random.random(len(points)), 2 * np.pi * random.random(len(points))
    across = np.sqrt(np.maximum(1 - along**2, 0))
    directions = along[:, None] * axis + (across * np.cos(angle))[:, None] * side
    directions = _unit(directions + (across * np.sin(angle))[:, None] * np.cross(axis, side))
    cosine = _dot(directions, normals)
    arrives = (cosine > 0) & (intersect(world, points, directions, spheres).spheres == lamp)
    return np.where(arrives, cosine * 2 * np.pi * height, 0)[:, None] * world.emissions[lamp]


def trace(
    world: World,
    origins: np.ndarray,
    directions: np.ndarray,
    random: np.random.Generator,
    depth: int | None = None,
    lamps: Sequence[int] = (),
) -> np.ndarray:
    """The radiance (n, 3) that one random path each finds along rays from points in free space.

    Diffuse surfaces ask `lamps` straight.
    """
    radiance = np.zeros((len(directions), 3))
    paths = Paths.begin(origins, directions, np.arange(len(directions)))
    for _ in range(SEGMENTS_AT_MOST):
        if depth is not None:
            paths = paths.only(paths.length < depth)
        if not len(paths.pixels):
            return radiance
        paths.length += 1
        hits = intersect(world, paths.origins, paths.directions, paths.leaves)
        met = hits.spheres != NONE
        weight = paths.throughput * paths.scale[:, None]
        emitted = np.where(met[:, None], world.emissions[hits.spheres], world.background)
        emitted[paths.has_asked & np.isin(hits.spheres, lamps)] = 0
        # A path adds to its own pixel only, so no index occurs twice.
        radiance[paths.pixels] += weight * emitted
        paths, hits = paths.only(met), hits.only(met)
        if len(lamps):
            ask(world, paths, hits, lamps, depth, random, radiance)
        paths = after(world, paths, hits, random)
    raise sppm.OracleError(f"a path of {SEGMENTS_AT_MOST} segments has not ended: light is caught in lossless glass")


def ask(
    world: World,
    paths: Paths,
    hits: Hits,
    lamps: Sequence[int],
    depth: int | None,
    random: np.random.Generator,
    radiance: np.ndarray,
) -> None:
    """Adds to `radiance` what `lamps` send straight to the diffuse surfaces that paths have met."""
    is_diffuse = world.kinds[hits.spheres] == DIFFUSE
    paths.has_asked = is_diffuse
    # The first diffuse surface may be `depth` segments from the light, however far from the eye it is.
    may_ask = is_diffuse & (~paths.has_met_diffuse | (depth is None or paths.length < depth))
    paths, hits = paths.only(may_ask), hits.only(may_ask)
    weight = paths.throughput * paths.scale[:, None] * world.albedos[hits.spheres] / np.pi
    for lamp in lamps:
        radiance[paths.pixels] += weight * asked(world, hits.points, hits.normals, hits.spheres, lamp, random)


def intersect(world: World, origins: np.ndarray, directions: np.ndarray, leaves: np.ndarray) -> Hits:
    """The nearest sphere of each ray. A ray that leaves a sphere starts on it: its only other hit is across."""
    rays, tried = _candidates(world, origins, directions)
    to_origin, along_ray = origins[rays] - world.centers[tried], directions[rays]
    along = -_dot(to_origin, along_ray)
    beside = to_origin + along[:, None] * along_ray
    squared = world.radii[tried] ** 2 - _dot(beside, beside)
    half = np.sqrt(np.maximum(squared, 0))
    t = np.where(along > half, along - half, along + half)
    # From the sphere itself the far end is at twice the nearest approach, behind the ray if it goes outwards.
    t = np.where(leaves[rays] == tried, 2 * along, t)
    t = np.where((squared > 0) & (t > 0), t, np.inf)
    nearest, spheres = np.full(len(origins), np.inf), np.full(len(origins), NONE)
    # The pairs are in the order of the rays.
    firsts = np.flatnonzero(np.diff(rays, prepend=-1))
    nearest[rays[firsts]] = np.minimum.reduceat(t, firsts)
    is_nearest = np.isfinite(t) & (t == nearest[rays])
    spheres[rays[is_nearest]] = tried[is_nearest]
    points = origins + np.where(np.isfinite(nearest), nearest, 0)[:, None] * directions
    outwards = (points - world.centers[spheres]) / world.radii[spheres, None]
    # A ray across a sphere meets it from within, whatever the rounding of a grazing one says.
    is_inside = (_dot(outwards, directions) > 0) | (leaves == spheres)
    return Hits(points, _unit(np.where(is_inside[:, None], -outwards, outwards)), spheres, is_inside)


def _candidates(world: World, origins: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of a ray and a sphere, without those whose lines pass the sphere by more than any rounding."""
    squared, center_squared = _dot(origins, origins), _dot(world.centers, world.centers)
    ones, each = np.ones(len(origins)), np.ones(len(world.radii))
    along = np.column_stack([directions, -_dot(origins, directions)]) @ np.vstack([world.centers.T, each])
    np.square(along, out=along)
    # The squared distance of a centre from the line is |origin - centre|^2 - along^2: at most the radius squared, but for
    # rounding. The exact formula decides later. All terms but along^2 are one product of matrices.
    others = np.vstack([2 * world.centers.T, -each, world.radii**2 - (1 - ROUNDING) * center_squared])
    along += np.column_stack([origins, (1 - ROUNDING) * squared, ones]) @ others
    return np.nonzero(along >= 0)


def after(world: World, paths: Paths, hits: Hits, random: np.random.Generator) -> Paths:
    """The paths as they leave the surfaces that they have met, without those that roulette ends."""
    kinds = world.kinds[hits.spheres]
    is_diffuse = kinds == DIFFUSE
    paths.length[is_diffuse & ~paths.has_met_diffuse] = 0
    paths.has_met_diffuse |= is_diffuse
    paths.throughput *= world.albedos[hits.spheres]
    leaving = reflected(paths.directions, hits.normals)
    leaving[is_diffuse] = cosine_weighted(hits.normals[is_diffuse], random)
    glass = np.flatnonzero(kinds == DIELECTRIC)
    inside, ior = hits.is_inside[glass], world.iors[hits.spheres[glass]]
    eta = np.where(inside, ior, 1 / ior)
    refracted, reflectance = refraction(paths.directions[glass], hits.normals[glass], eta)
    passes = random.random(len(glass)) >= reflectance
    leaving[glass[passes]] = refracted[passes]
    paths.scale[glass[passes]] *= eta[passes] ** 2
    paths.origins, paths.directions, paths.leaves = hits.points, _unit(leaving), hits.spheres
    survival = np.where(paths.has_met_diffuse, np.minimum(paths.throughput.max(axis=1), 1), 1)
    # A black surface ends every path, also one on its way to the first diffuse surface.
    survives = (random.random(len(survival)) < survival) & (paths.throughput.max(axis=1) > 0)
    paths.throughput[survives] /= survival[survives, None]
    return paths.only(survives)


def reflected(directions: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Mirror images of directions about normals."""
    return directions - 2 * _dot(directions, normals)[:, None] * normals


def refraction(directions: np.ndarray, normals: np.ndarray, eta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The refracted directions, and the shares of unpolarised light that are reflected instead.

    `eta` is the index on the side of the ray over that on the other; normals face the ray. A share is 1 for total
    internal reflection, where the refracted direction means nothing.
    """
    cos_i = np.clip(-_dot(directions, normals), 0, 1)
    sin2_t = eta**2 * (1 - cos_i**2)
    cos_t = np.sqrt(np.maximum(1 - sin2_t, 0))
    with np.errstate(invalid="ignore"):
        perpendicular = (eta * cos_i - cos_t) / (eta * cos_i + cos_t)
        parallel = (cos_i - eta * cos_t) / (cos_i + eta * cos_t)
    reflectance = np.where(sin2_t >= 1, 1.0, (perpendicular**2 + parallel**2) / 2)
    return eta[:, None] * directions + (eta * cos_i - cos_t)[:, None] * normals, reflectance


def cosine_weighted(normals: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Directions about normals with a density of cos / pi: a normal plus a uniform unit vector, scaled to 1."""
    uniform = _unit(random.normal(size=normals.shape))
    return _unit(normals + uniform)


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", a, b)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.sqrt(_dot(vectors, vectors))[:, None]
