"""Compares ray-sphere intersections with Embree: with tessellated spheres, and with Embree's own analytic spheres.

Tessellated spheres do not depend on any sphere formula, but differ from the true sphere. Each mesh lies in a shell
between two radii, which are computed from its vertices and the planes of its triangles. The interval in which a ray
crosses that shell bounds how far the two answers may differ. Embree's analytic spheres agree to the rounding of f32.
The Python binding lacks them, so they are called through ctypes.
"""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import embreex
import numpy as np
from embreex import rtcore_scene
from embreex.mesh_construction import TriangleMesh

from oracle import geometry, sppm
from oracle.geometry import Crossing, Spheres

# Most triangles of all meshes of a scene together. Embree builds these in seconds.
TRIANGLES = 2_000_000
# Most triangles of one sphere, so that a single wall does not use up all of them.
TRIANGLES_OF_A_SPHERE = 400_000
# The sagitta of the faces is then 2e-8 of the radius; finer faces would be lost in the rounding of their vertices.
MOST_SUBDIVISIONS = 12
# A sphere whose radius is more than this multiple of the distance to it is a wall: only its visible part is tessellated
# finely.
WALL = 2.0
# Half a unit in the last place of a float32 of value 1: the relative error of one rounding.
EPSILON = 2.0**-24
# Error bound of a term in roundings, for both programs together. An error in the third digit is far larger.
ROUNDINGS = 8
# The same for the edge of a triangle, at the edge's distance from the ray's origin. Embree decides on which side of an
# edge a ray passes by dot(cross(a - b, a + b), direction), with a and b relative to the origin. The differences have an
# error of one rounding, the sum one more, the edge one, the cross product three and the dot product three. That is nine
# in each of three components, plus one for ours: 10 sqrt(3).
EDGE_ROUNDINGS = 17.4
BATCH = 200_000


@dataclass(frozen=True)
class Mesh:
    """A tessellated sphere in float32, as passed to Embree, and the radii between which its surface lies."""

    vertices: np.ndarray
    faces: np.ndarray
    inner: float
    outer: float


@dataclass(frozen=True)
class Answer:
    """Distance, sphere (-1 for a miss) and normal of each hit. Embree's normals may have any length and sign."""

    t: np.ndarray
    sphere: np.ndarray
    normal: np.ndarray


@dataclass(frozen=True)
class Outcome:
    """The result of a comparison."""

    scene: str
    against: str
    rays: int
    # Rays whose sphere, distance or normal differs by more than the bound allows.
    unexplained: int
    # Rays that hit different spheres; the bound allows that at rims and where surfaces meet.
    other_sphere: int
    # The largest difference as a share of its bound, among rays that hit the same sphere.
    largest_share: float
    median_difference: float
    largest_difference: float

    @property
    def agrees(self) -> bool:
        """True if no difference is larger than its bound."""
        return self.unexplained == 0

    def __str__(self) -> str:
        verdict = "agrees" if self.agrees else f"DIFFERS in {self.unexplained} rays"
        return (
            f"{self.scene:8} {self.against:9} {verdict}: {self.rays} rays, {self.other_sphere} to another sphere as "
            f"the bound allows, |dt| median {self.median_difference:.1e}, largest {self.largest_difference:.1e} "
            f"({self.largest_share:.0%} of its bound)"
        )


def icosahedron() -> tuple[np.ndarray, np.ndarray]:
    """Vertices (12, 3) on the unit sphere, and faces (20, 3) with outward orientation."""
    g = (1 + 5**0.5) / 2
    vertices = np.array(
        [(0, a, b) for a in (-1, 1) for b in (-g, g)]
        + [(a, b, 0) for a in (-1, 1) for b in (-g, g)]
        + [(b, 0, a) for a in (-1, 1) for b in (-g, g)]
    )
    edge = 2.0 + 1e-9
    near = np.linalg.norm(vertices[:, None] - vertices[None], axis=2) <= edge
    faces = [
        (i, j, k)
        for i in range(12)
        for j in range(i + 1, 12)
        for k in range(j + 1, 12)
        if near[i, j] and near[j, k] and near[i, k]
    ]
    oriented = [f if np.linalg.det(vertices[list(f)]) > 0 else (f[0], f[2], f[1]) for f in faces]
    return vertices / np.linalg.norm(vertices[0]), np.array(oriented)


def subdivide(vertices: np.ndarray, faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Splits every face into four and moves the new vertices onto the unit sphere."""
    edges = np.sort(faces[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    unique, index = np.unique(edges, axis=0, return_inverse=True)
    middle = vertices[unique].sum(axis=1)
    middle /= np.linalg.norm(middle, axis=1, keepdims=True)
    a, b, c = faces.T
    ab, bc, ca = (index.reshape(-1, 3) + len(vertices)).T
    parts = [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
    return np.concatenate([vertices, middle]), np.concatenate([np.stack(part, axis=1) for part in parts])


def tessellate(center: np.ndarray, radius: float, cap: np.ndarray, budget: int) -> Mesh:
    """An icosphere around `center`: within a cap as fine as `budget` triangles allow, coarse elsewhere.

    `cap` is (4,): a unit direction and the angle around it in which rays hit the sphere. Faces outside the cap are not
    subdivided. This leaves cracks in the mesh, but only outside the cap.
    """
    vertices, faces = icosahedron()
    kept = [faces[:0]]
    for _ in range(MOST_SUBDIVISIONS):
        if 4 * len(faces) > budget:
            break
        vertices, faces = subdivide(vertices, faces)
        corners = vertices[faces]
        middle = corners.mean(axis=1)
        middle /= np.linalg.norm(middle, axis=1, keepdims=True)
        reach = np.arccos(np.clip((corners * middle[:, None]).sum(axis=2).min(axis=1), -1, 1))
        angle = np.arccos(np.clip(middle @ cap[:3], -1, 1))
        within = angle <= cap[3] + 2 * reach
        kept.append(faces[~within])
        faces = faces[within]
    # The shell of the faces within the cap: its outer radius by the rounded vertices, its inner radius by the planes.
    rounded = (center + radius * vertices).astype(np.float32)
    used = np.unique(faces)
    exact = rounded.astype(np.float64) - center
    a, b, c = (exact[faces[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    planes = np.abs(np.einsum("ij,ij->i", normal, a)) / np.linalg.norm(normal, axis=1)
    outer = float(np.linalg.norm(exact[used], axis=1).max())
    everything = np.concatenate([*kept, faces]).astype(np.int32)
    return Mesh(rounded, everything, float(planes.min()), outer)


def caps(world: Spheres, probes: np.ndarray, hits: np.ndarray) -> np.ndarray:
    """For each sphere, the cap that rays can hit: unit direction and angle; (n, 4).

    For walls it is the cap that probe rays from the eye hit, with twice the angle to be safe. For other spheres it is
    the whole sphere.
    """
    found = np.tile([0.0, 0.0, 1.0, np.pi], (len(world), 1))
    points = probes[:, :3] + hits["t"][:, None] * probes[:, 3:]
    for index in np.unique(hits["sphere"][hits["sphere"] >= 0]):
        here = hits["sphere"] == index
        if world.radii[index] < WALL * hits["t"][here].max():
            continue
        outward = (points[here] - world.centers[index]) / world.radii[index]
        axis = outward.mean(axis=0)
        axis /= np.linalg.norm(axis)
        angle = 2 * np.arccos(np.clip(outward @ axis, -1, 1)).max() + 1e-3
        found[index] = [*axis, min(angle, np.pi)]
    return found


class Triangles:
    """A scene of tessellated spheres in Embree."""

    name = "triangles"
    roundings = EDGE_ROUNDINGS

    def __init__(self, scene: str, world: Spheres) -> None:
        random = np.random.default_rng(7)
        directions = geometry.uniform_directions(20_000, random)
        probes = np.concatenate([np.broadcast_to(world.eye, directions.shape), directions], axis=1)
        seen = caps(world, probes, sppm.trace(scene, probes))
        budget = min(TRIANGLES_OF_A_SPHERE, TRIANGLES // len(world))
        self.meshes = [tessellate(world.centers[k], world.radii[k], seen[k], budget) for k in range(len(world))]
        self.scene = rtcore_scene.EmbreeScene(robust=True)
        for mesh in self.meshes:
            TriangleMesh(self.scene, mesh.vertices, mesh.faces)

    def shells(self) -> tuple[np.ndarray, np.ndarray]:
        """The inner and outer radius of each sphere's shell."""
        return np.array([m.inner for m in self.meshes]), np.array([m.outer for m in self.meshes])

    def intersect(self, rays: np.ndarray) -> Answer:
        """The nearest hit of each ray."""
        parts = []
        for at in range(0, len(rays), BATCH):
            some = np.ascontiguousarray(rays[at : at + BATCH], dtype=np.float32)
            origins, directions = np.ascontiguousarray(some[:, :3]), np.ascontiguousarray(some[:, 3:])
            parts.append(self.scene.run(origins, directions, output=True))
        joined = {key: np.concatenate([part[key] for part in parts]) for key in ("tfar", "geomID", "Ng")}
        missed = joined["geomID"] < 0
        t = np.where(missed, np.inf, joined["tfar"].astype(np.float64))
        return Answer(t, joined["geomID"].astype(np.int64), joined["Ng"].astype(np.float64))


@cache
def _library() -> ctypes.CDLL:
    """The libembree4 in the wheel of embreex."""
    folder = Path(embreex.__file__).resolve().parent
    found = sorted([*folder.glob("**/libembree4*"), *folder.parent.glob("embreex.libs/libembree4*")])
    if not found:
        raise sppm.OracleError(f"there is no libembree4 beside {folder}")
    library = ctypes.CDLL(str(found[0]))
    pointer, unsigned, size = ctypes.c_void_p, ctypes.c_uint, ctypes.c_size_t
    for name, result, arguments in (
        ("rtcNewDevice", pointer, [ctypes.c_char_p]),
        ("rtcNewScene", pointer, [pointer]),
        ("rtcSetSceneFlags", None, [pointer, ctypes.c_int]),
        ("rtcNewGeometry", pointer, [pointer, ctypes.c_int]),
        ("rtcSetNewGeometryBuffer", pointer, [pointer, ctypes.c_int, unsigned, ctypes.c_int, size, size]),
        ("rtcCommitGeometry", None, [pointer]),
        ("rtcAttachGeometry", unsigned, [pointer, pointer]),
        ("rtcCommitScene", None, [pointer]),
        ("rtcIntersect1", None, [pointer, pointer, pointer]),
    ):
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


class AnalyticSpheres:
    """A scene of Embree's own spheres (RTC_GEOMETRY_TYPE_SPHERE_POINT)."""

    name = "spheres"
    roundings = float(ROUNDINGS)

    _SPHERE_POINT, _VERTEX, _FLOAT4, _ROBUST = 50, 1, 0x9004, 1 << 2
    # RTCRayHit in 4-byte words: origin 0..3, direction 4..7, tfar 8, Ng 12..15, geomID 18; the rest is padding.
    _WORDS = 32

    def __init__(self, world: Spheres) -> None:
        library = _library()
        device = library.rtcNewDevice(None)
        self.scene = library.rtcNewScene(device)
        library.rtcSetSceneFlags(self.scene, self._ROBUST)
        # One geometry per sphere, so that geometry ids are sphere indices.
        for center, radius in zip(world.centers, world.radii, strict=True):
            sphere = library.rtcNewGeometry(device, self._SPHERE_POINT)
            buffer = library.rtcSetNewGeometryBuffer(sphere, self._VERTEX, 0, self._FLOAT4, 16, 1)
            (ctypes.c_float * 4).from_address(buffer)[:] = [*center, radius]
            library.rtcCommitGeometry(sphere)
            library.rtcAttachGeometry(self.scene, sphere)
        library.rtcCommitScene(self.scene)
        self.radii = world.radii

    def shells(self) -> tuple[np.ndarray, np.ndarray]:
        """The radii of the spheres, as both bounds."""
        return self.radii, self.radii

    def intersect(self, rays: np.ndarray) -> Answer:
        """The nearest hit of each ray."""
        words = np.zeros(len(rays) * self._WORDS + self._WORDS, dtype=np.float32)
        start = -words.ctypes.data % (4 * self._WORDS) // 4
        table = words[start : start + len(rays) * self._WORDS].reshape(-1, self._WORDS)
        table[:, 0:3], table[:, 4:7], table[:, 8] = rays[:, :3], rays[:, 3:], np.inf
        ids = table.view(np.uint32)
        ids[:, 9], ids[:, 18] = 0xFFFFFFFF, 0xFFFFFFFF
        intersect, scene = _library().rtcIntersect1, self.scene
        base, step = table.ctypes.data, 4 * self._WORDS
        for address in range(base, base + len(rays) * step, step):
            intersect(scene, address, None)
        missed = ids[:, 18] == 0xFFFFFFFF
        t = np.where(missed, np.inf, table[:, 8].astype(np.float64))
        return Answer(t, np.where(missed, -1, ids[:, 18].astype(np.int64)), table[:, 12:15].astype(np.float64))


KINDS = (AnalyticSpheres.name, Triangles.name)


def rounding(rays: np.ndarray, world: Spheres, sphere: np.ndarray) -> np.ndarray:
    """For each ray, a bound on the rounding error of the distance to a sphere.

    Embree computes the half chord h from r^2 - d^2. Each term has a rounding error in proportion to the squared
    distance to the centre, so h has that error divided by 2 h. The distance also has the rounding errors of its two
    parts.
    """
    to_center = world.centers[sphere] - rays[:, :3]
    squared = np.einsum("ij,ij->i", to_center, to_center)
    along = np.einsum("ij,ij->i", to_center, rays[:, 3:])
    half = np.sqrt(np.maximum(world.radii[sphere] ** 2 - (squared - along**2), 0.0))
    scale = np.maximum(squared, world.radii[sphere] ** 2)
    noise = ROUNDINGS * EPSILON
    # At a rim h is as small as its error, and error / (2 h) has no bound; the error of h is then at most sqrt(error).
    of_half = np.minimum(noise * scale / np.maximum(2 * half, 1e-30), np.sqrt(noise * scale))
    return of_half + noise * (np.abs(along) + half)


def compare(scene: str, count: int, kind: str = "spheres", seed: int = 1, *options: str) -> Outcome:
    """Compares `sppm trace` with Embree on random rays."""
    world = geometry.spheres(scene)
    other = AnalyticSpheres(world) if kind == "spheres" else Triangles(scene, world)
    inner, outer = other.shells()
    # A ray that starts closer to a surface than its mesh may be on the wrong side of the mesh.
    margin = np.maximum(2 * (world.radii - inner), ROUNDINGS * EPSILON * world.radii)
    rays = geometry.rays(scene, world, count, margin, seed)
    ours = sppm.trace(scene, rays, *options)
    answer = Answer(*(ours[field].astype(kind) for field, kind in (("t", "f8"), ("sphere", "i8"), ("normal", "f8"))))
    return judge(scene, world, other, rays.astype(np.float64), answer)


def judge(scene: str, world: Spheres, other: Triangles | AnalyticSpheres, rays: np.ndarray, ours: Answer) -> Outcome:
    """Counts the rays on which the two programs differ by more than the bounds allow."""
    theirs = other.intersect(rays)
    inner, outer = other.shells()

    def crossing(sphere: np.ndarray) -> Crossing:
        # Where either program may hit `sphere`, rounding errors included; nowhere for a miss.
        index = np.maximum(sphere, 0)
        low, high = np.minimum(inner, world.radii)[index], np.maximum(outer, world.radii)[index]
        noise = other.roundings * EPSILON * np.linalg.norm(world.centers[index] - rays[:, :3], axis=1)
        found = geometry.crossing(rays[:, :3], rays[:, 3:], world.centers[index], low - noise, high + noise)
        extra = rounding(rays, world, index)
        is_hit = sphere >= 0
        return Crossing(found.first - extra, found.last + extra, found.touches & is_hit, found.may_miss & is_hit)

    same = ours.sphere == theirs.sphere
    hit = same & (ours.sphere >= 0)
    mine, their = crossing(ours.sphere), crossing(theirs.sphere)
    width = mine.last - mine.first
    difference = np.abs(np.where(hit, ours.t, 0.0) - np.where(hit, theirs.t, 0.0))
    normals = _normals_agree(rays, world, ours, theirs, width) | (other.name == "triangles")
    fits = (difference <= width) & normals
    # If the spheres differ, our hit must be on our sphere. Then either both surfaces may be hit at the same distance,
    # or the nearer one may be missed: ours by Embree, or Embree's by us.
    on_ours = (ours.sphere < 0) | (mine.touches & (mine.first <= ours.t) & (ours.t <= mine.last))
    overlap = mine.touches & their.touches & (their.first <= mine.last) & (mine.first <= their.last)
    missed_by_them = mine.may_miss & (mine.first <= theirs.t)
    missed_by_us = their.may_miss & (their.first <= ours.t)
    explained = np.where(same, fits | ~hit, on_ours & (overlap | missed_by_them | missed_by_us))
    return Outcome(
        scene=scene,
        against=other.name,
        rays=len(rays),
        unexplained=int((~explained).sum()),
        other_sphere=int((~same).sum()),
        largest_share=float((difference[hit] / width[hit]).max()),
        median_difference=float(np.median(difference[hit])),
        largest_difference=float(difference[hit].max()),
    )


def _normals_agree(rays: np.ndarray, world: Spheres, ours: Answer, theirs: Answer, width: np.ndarray) -> np.ndarray:
    """Our normals must face the ray, have unit length, and match Embree's up to the effect of a difference in place."""
    length = np.linalg.norm(theirs.normal, axis=1)
    unit = theirs.normal / np.where(length > 0, length, 1.0)[:, None]
    faces = np.einsum("ij,ij->i", ours.normal, rays[:, 3:])
    apart = np.minimum(np.linalg.norm(ours.normal - unit, axis=1), np.linalg.norm(ours.normal + unit, axis=1))
    bound = width / world.radii[np.maximum(ours.sphere, 0)] + ROUNDINGS * EPSILON
    unit_length = np.abs(np.linalg.norm(ours.normal, axis=1) - 1) < ROUNDINGS * EPSILON
    return (apart <= bound) & unit_length & (faces <= bound)
