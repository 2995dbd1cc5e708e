"""Tests that our intersections agree with Embree's, and that the comparison finds errors in them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from oracle import embree, geometry, sppm
from oracle.embree import AnalyticSpheres, Answer, Outcome

RAYS = 60_000


@pytest.mark.parametrize("engine", ["fast", "reference"])
@pytest.mark.parametrize("scene", ["cornell", "random", "surgery"])
def test_spheres_agree(scene: str, engine: str) -> None:
    outcome = embree.compare(scene, RAYS, "spheres", 1, "--engine", engine)
    assert outcome.agrees, outcome
    assert outcome.rays > 0.9 * RAYS


def test_triangles_agree() -> None:
    outcome = embree.compare("cornell", RAYS, "triangles")
    assert outcome.agrees, outcome
    # The bounds must not hide large errors: typical differences are small.
    assert outcome.median_difference < 0.01
    assert outcome.other_sphere < 0.01 * RAYS


@pytest.fixture(scope="module")
def asked() -> tuple[geometry.Spheres, AnalyticSpheres, np.ndarray, Answer]:
    world = geometry.spheres("cornell")
    rays = geometry.rays("cornell", world, RAYS, np.full(len(world), 0.1), 1)
    hits = sppm.trace("cornell", rays)
    ours = Answer(*(hits[field].astype(kind) for field, kind in (("t", "f8"), ("sphere", "i8"), ("normal", "f8"))))
    return world, AnalyticSpheres(world), rays.astype(np.float64), ours


def judged(asked: tuple[geometry.Spheres, AnalyticSpheres, np.ndarray, Answer], **changes: np.ndarray) -> Outcome:
    world, spheres, rays, ours = asked
    return embree.judge("cornell", world, spheres, rays, replace(ours, **changes))


def test_faults_are_found(asked: tuple[geometry.Spheres, AnalyticSpheres, np.ndarray, Answer]) -> None:
    ours = asked[3]
    assert judged(asked).agrees
    one = np.arange(len(ours.t)) == 1234
    # Errors in one ray: a distance off in the third digit, another sphere, a miss, a flipped or too long normal.
    assert judged(asked, t=np.where(one, 1.005 * ours.t, ours.t)).unexplained == 1
    assert judged(asked, sphere=np.where(one, (ours.sphere + 1) % 9, ours.sphere)).unexplained == 1
    assert judged(asked, sphere=np.where(one, -1, ours.sphere), t=np.where(one, np.inf, ours.t)).unexplained == 1
    for factor in (-1.0, 1.001):
        assert judged(asked, normal=np.where(one[:, None], factor * ours.normal, ours.normal)).unexplained == 1
    # An error in many rays: a wall moved by 0.1.
    moved = ours.sphere == 3
    found = judged(asked, t=np.where(moved, ours.t + 0.1, ours.t)).unexplained
    assert found > 0.9 * moved.sum()


@pytest.mark.parametrize("levels", [3, 5])
def test_meshes_lie_in_their_shells(levels: int) -> None:
    center, radius = np.array([30.0, -20.0, 55.0]), 16.5
    whole = np.array([0.0, 0.0, 1.0, np.pi])
    mesh = embree.tessellate(center, radius, whole, 20 * 4**levels)
    assert len(mesh.faces) == 20 * 4**levels
    # The sagitta of an icosphere of k subdivisions is 0.292 r / 4^k.
    assert radius - mesh.inner == pytest.approx(0.292 * radius / 4**levels, rel=0.1)
    assert mesh.outer == pytest.approx(radius, rel=1e-6)
    random = np.random.default_rng(1)
    corners = mesh.vertices[mesh.faces[random.integers(len(mesh.faces), size=5000)]].astype(np.float64)
    points = np.einsum("ij,ijk->ik", random.dirichlet([1, 1, 1], size=5000), corners)
    radii = np.linalg.norm(points - center, axis=1)
    assert mesh.inner * (1 - 1e-7) <= radii.min() and radii.max() <= mesh.outer * (1 + 1e-7)


def test_crossings_bound_every_surface_in_the_shell() -> None:
    """Hits on spheres of any radius within the shell lie between the bounds, from outside and from inside."""
    random = np.random.default_rng(2)
    origins = random.normal(size=(20_000, 3)) * 3
    directions = geometry.uniform_directions(len(origins), random)
    centers = np.zeros_like(origins)
    inner, outer = np.full(len(origins), 0.95), np.full(len(origins), 1.0)
    outside_shell = np.abs(np.linalg.norm(origins, axis=1) - 0.975) > 0.03
    crossed = geometry.crossing(origins, directions, centers, inner, outer)
    for radius in (0.951, 0.97, 0.999):
        along = -np.einsum("ij,ij->i", origins, directions)
        squared = np.einsum("ij,ij->i", origins, origins) - along**2
        half = np.sqrt(np.maximum(radius**2 - squared, 0))
        t = np.where(np.linalg.norm(origins, axis=1) > radius, along - half, along + half)
        met = outside_shell & (squared < radius**2) & (t > 0)
        assert met.sum() > 500
        assert (crossed.first[met] <= t[met] + 1e-9).all() and (t[met] <= crossed.last[met] + 1e-9).all()
