"""Tests of the oracle's path tracer against closed forms, and of sppm against the tracer and the same forms."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy import integrate, stats

from oracle import sppm, tracer, witness, ztest
from oracle.tracer import DIELECTRIC, DIFFUSE, World
from oracle.witness import Effort

CONCENTRIC, ASIDE = witness.SCENES
# The false alarm rate of each test that compares a mean with its closed form.
SIGNIFICANCE = ztest.SIGNIFICANCE


# At the origin.
EYE = tracer.Camera(np.zeros(3), np.eye(3), 45.0, 0.0, 1.0)


def world(*spheres: tuple, background: float = 0.0) -> World:
    """Grey spheres: (centre, radius, kind, albedo, index, emission)."""
    centers, radii, kinds, albedos, iors, emissions = zip(*spheres, strict=True)
    grey = lambda values: np.repeat(np.array(values, dtype=float)[:, None], 3, axis=1)  # noqa: E731
    return World(
        np.array(centers, dtype=float),
        np.array(radii, dtype=float),
        np.array(kinds),
        grey(albedos),
        np.array(iors, dtype=float),
        grey(emissions),
        np.full(3, background),
    )


def uniform(count: int, random: np.random.Generator) -> np.ndarray:
    vectors = random.normal(size=(count, 3))
    return vectors / np.linalg.norm(vectors, axis=1, keepdims=True)


def arrive(within: World, point: tuple, directions: np.ndarray, depth: int | None = None) -> np.ndarray:
    """Radiances (n,) of paths from a point in free space."""
    random = np.random.default_rng(2)
    return tracer.trace(within, np.tile(point, (len(directions), 1)), directions, random, depth)[:, 0]


def assert_mean(samples: np.ndarray, expected: float, precision: float) -> None:
    """Student's t-test of a mean, whose relative standard error must be at most `precision`."""
    assert stats.sem(samples) < precision * expected
    found = stats.ttest_1samp(samples, expected)
    assert found.pvalue > SIGNIFICANCE, (samples.mean(), expected, found)


def exitance(ior: float, share: float) -> float:
    """The part of a Lambertian lamp's power that passes the surface of a concentric glass ball at the first attempt.

    `share` is the lamp's radius over the ball's: a ray that leaves the lamp at an angle of sine s meets the surface at
    the sine s * share.
    """

    def passed(sine: float) -> float:
        cos_i, sin_t = np.sqrt(1 - (sine * share) ** 2), min(ior * sine * share, 1)
        cos_t = np.sqrt(1 - sin_t**2)
        # Born and Wolf, "Principles of Optics", 7th edition, section 1.5.2, equation 21: not the form in the tracer.
        across = 2 * ior * cos_i / (ior * cos_i + cos_t)
        along = 2 * ior * cos_i / (cos_i + ior * cos_t)
        return cos_t / (ior * cos_i) * (across**2 + along**2) / 2

    return integrate.quad(lambda sine: 2 * sine * passed(sine), 0, 1)[0]


def test_exitance_in_limits() -> None:
    # A tiny lamp's light meets the glass head-on, where 4 % is reflected; with index 1 all of it passes.
    assert exitance(1.5, 1e-6) == pytest.approx(0.96, abs=1e-9)
    assert exitance(1.0, 0.7) == pytest.approx(1.0, abs=1e-9)


def test_a_furnace_has_the_radiance_of_its_walls() -> None:
    """In a closed room of albedo a whose surfaces glow with E, the radiance is E / (1 - a)."""
    room = world(
        ((0, 0, 0), 10, DIFFUSE, 0.5, 1, 2.0),
        ((3, 0, 0), 4, DIFFUSE, 0.5, 1, 2.0),
        ((-5, 1, 0), 3, DIFFUSE, 0.5, 1, 2.0),
    )
    directions = uniform(40_000, np.random.default_rng(1))
    assert_mean(arrive(room, (0, 8, 0), directions), 4.0, 0.01)
    # Segments 1 to 3 from the first surface on give 2 (1 + 1/2 + 1/4 + 1/8).
    assert_mean(arrive(room, (0, 8, 0), directions, depth=3), 3.75, 0.01)


def test_light_in_equilibrium_is_that_of_a_black_body() -> None:
    """With lossless walls and glass, every path ends at the lamp: radiance in air is exactly the lamp's over n^2.

    It holds for every path and wherever the lamp is, by Kirchhoff's law. It fails if a ray gets lost or is caught.
    """
    room = world(
        ((0, 0, 0), 20, DIFFUSE, 1.0, 1, 0.0),
        ((2, 3, 0), 14, DIELECTRIC, 1.0, 1.5, 0.0),
        ((5, 6, 2), 6, DIFFUSE, 0.0, 1, 10.0),
        ((2, -13, 0), 2, tracer.SPECULAR, 1.0, 1, 0.0),
    )
    found = arrive(room, (-15, -5, 0), uniform(5000, np.random.default_rng(3)))
    np.testing.assert_allclose(found, 10 / 1.5**2, rtol=1e-12)


def test_a_lamp_above_a_plane() -> None:
    """The irradiance of a sphere in full view is pi L (r / d)^2 cos: Howell's configuration factor B-14 of spheres."""
    for sine in (0.0, 0.6):
        lamp = world(((10 * sine, 10 * np.sqrt(1 - sine**2), 0), 3, DIFFUSE, 0.0, 1, 10.0))
        up = np.tile([0.0, 1.0, 0.0], (400_000, 1))
        found = np.pi * arrive(lamp, (0, 0, 0), tracer.cosine_weighted(up, np.random.default_rng(4)))
        assert_mean(found, np.pi * 10 * 0.09 * np.sqrt(1 - sine**2), 0.01)


def test_a_far_lamp_is_asked_and_not_met() -> None:
    """The irradiance is that of a lamp that paths meet, with less noise, and half of it where half of the lamp is hidden."""
    sine, cosine = 0.6, 0.8
    sun = ((1e6 * sine, 1e6 * cosine, 0), 2e4, DIFFUSE, 0.0, 1, 1e4)
    ground = ((0, -1e4, 0), 1e4, DIFFUSE, 0.5, 1, 0.0)
    # A wall of which the face goes through the origin and the middle of the sun; paths come along it, just outside.
    towards, normal = np.array([sine, cosine, 0]), np.array([cosine, -sine, 0])
    wall = (tuple(-5e3 * normal), 5e3, DIFFUSE, 0.0, 1, 0.0)
    expected = 0.5 * 1e4 * 0.02**2 * cosine
    for scene, share in ((world(sun, ground), 1.0), (world(sun, ground, wall), 0.5)):
        lamps = tracer.far_lamps(scene, EYE)
        assert lamps == [0]
        origins, directions = (np.tile(v, (20_000, 1)) for v in (towards + 1e-8 * normal, -towards))
        found = tracer.trace(scene, origins, directions, np.random.default_rng(9), 1, lamps)[:, 0]
        # At a depth of 1 the ground does not light itself.
        assert_mean(found, share * expected, 0.01)


def test_near_or_wide_lamps_are_met() -> None:
    near = world(((0, 5, 0), 0.1, DIFFUSE, 0.0, 1, 1.0), ((0, -101, 0), 100, DIFFUSE, 0.5, 1, 0.0))
    wide = world(((0, 1e5, 0), 5e4, DIFFUSE, 0.0, 1, 1.0), ((0, -101, 0), 100, DIFFUSE, 0.5, 1, 0.0))
    glass = world(((0, 1e5, 0), 1e3, DIELECTRIC, 0.0, 1.5, 1.0), ((0, -101, 0), 100, DIFFUSE, 0.5, 1, 0.0))
    around = world(((0, 0, 0), 1e5, DIFFUSE, 0.0, 1, 1.0), ((0, -101, 0), 100, DIFFUSE, 0.5, 1, 0.0))
    assert [tracer.far_lamps(scene, EYE) for scene in (near, wide, glass, around)] == [[]] * 4


@pytest.mark.parametrize(("albedo", "tint", "radius"), [(0.0, 1.0, 6), (0.5, 1.0, 6), (0.5, 0.8, 6), (0.8, 0.9, 12)])
def test_the_power_that_leaves_a_lamp_within_glass(albedo: float, tint: float, radius: float) -> None:
    """What the glass reflects returns to the concentric lamp, at the same angle; the series of returns is geometric.

    With radius 12 of 14, some of the light is reflected totally.
    """
    lamp = world(
        ((0, 0, 0), 14, DIELECTRIC, tint, 1.5, 0.0),
        ((0, 0, 0), radius, DIFFUSE, albedo, 1, 10.0),
    )
    passes = exitance(1.5, radius / 14)
    expected = np.pi * 10 * (radius / 20) ** 2 * tint * passes / (1 - albedo * tint * (1 - passes))
    # The irradiance at distance 20, facing the centre, is the power over 4 pi 20^2.
    up = np.tile([0.0, 1.0, 0.0], (400_000, 1))
    found = np.pi * arrive(lamp, (0, -20, 0), tracer.cosine_weighted(up, np.random.default_rng(5)))
    assert_mean(found, expected, 0.005)


def test_rays_meet_spheres_where_geometry_says() -> None:
    """A ray from a sphere meets it across or not at all, and what is hit lies on the sphere."""
    random = np.random.default_rng(6)
    ball = world(((1, 2, 3), 5, DIELECTRIC, 1.0, 1.5, 0.0))
    normals = uniform(2000, random)
    points, directions = np.array([1, 2, 3]) + 5 * normals, uniform(2000, random)
    inwards = np.einsum("ij,ij->i", normals, directions) < 0
    hits = tracer.intersect(ball, points, directions, np.zeros(2000, dtype=int))
    np.testing.assert_array_equal(hits.spheres == 0, inwards)
    np.testing.assert_allclose(np.linalg.norm(hits.points[inwards] - [1, 2, 3], axis=1), 5, rtol=1e-12)
    assert hits.is_inside[inwards].all()


def test_endless_paths_are_refused() -> None:
    """A mirror all around the eye lets no path end."""
    mirror = world(((0, 0, 0), 5, tracer.SPECULAR, 1.0, 1, 0.0))
    with pytest.raises(sppm.OracleError, match="has not ended"):
        arrive(mirror, (1, 0, 0), np.array([[0.0, 0.6, 0.8]]))


def test_moving_scenes_are_refused() -> None:
    with pytest.raises(sppm.OracleError, match="motion moves"):
        tracer.read("motion")


@cache
def lit_directly() -> tuple[np.ndarray, np.ndarray]:
    """The floor of the concentric scene in closed form (height, width, 3), and where it holds: in pixels of floor only.

    At a depth of 2 the floor sees the lamp through the glass and nothing else. The irradiance is the power that leaves
    over 4 pi d^2, times the cosine, where all of the ball is above the horizon.
    """
    scene, camera = tracer.read(CONCENTRIC)
    power_over_pi = 10 * 4 * np.pi * 6**2 * exitance(1.5, 6 / 14)
    total = np.zeros((witness.HEIGHT * witness.WIDTH, 3))
    holds = np.ones(len(total), dtype=bool)
    random = np.random.default_rng(7)
    for pixels, origins, directions in tracer.camera_rays(camera, witness.WIDTH, witness.HEIGHT, 256, random):
        hits = tracer.intersect(scene, origins, directions, np.full(len(pixels), tracer.NONE))
        distance = np.linalg.norm(hits.points, axis=1)
        height = -np.einsum("ij,ij->i", hits.normals, hits.points)
        in_view = (hits.spheres == 0) & (height > 14)
        np.logical_and.at(holds, pixels, in_view)
        radiance = power_over_pi / (4 * np.pi) * height / distance**3
        np.add.at(total, pixels, np.where(in_view, radiance, 0)[:, None] * scene.albedos[0])
    shape = (witness.HEIGHT, witness.WIDTH)
    return total.reshape(*shape, 3) / 256, holds.reshape(shape)


@pytest.mark.parametrize(
    ("renderer", "effort", "precision"),
    [
        ("tracer", Effort(renders=16, samples=64), 0.01),
        ("path", Effort(renders=16, samples=256), 0.005),
        ("fast", Effort(renders=16, iterations=16, photons=50_000), 0.01),
        ("reference", Effort(renders=8, iterations=4, photons=20_000), 0.04),
    ],
)
def test_the_floor_under_a_lamp_within_glass_is_known(renderer: str, effort: Effort, precision: float) -> None:
    expected, holds = lit_directly()
    assert holds.sum() > 200
    if renderer == "tracer":
        renders = witness.traced(CONCENTRIC, effort, depth=2)
    else:
        renders = witness.rendered(CONCENTRIC, renderer, effort, depth=2)
    assert_mean(renders[:, holds, 0].mean(axis=1), expected[holds, 0].mean(), precision)


SUNNY = Effort(renders=16, samples=256, iterations=32, photons=60_000)
QUICK = Effort(renders=16, samples=64, iterations=16, photons=30_000)


@pytest.fixture(scope="module")
def traced() -> np.ndarray:
    return witness.traced(ASIDE, Effort(renders=16, samples=64))


@pytest.mark.parametrize("engine", ["path", "fast"])
def test_sppm_agrees_with_the_tracer(traced: np.ndarray, engine: str) -> None:
    """Where there is no closed form; at the false alarm rate of `ztest.SIGNIFICANCE`."""
    ours = witness.rendered(ASIDE, engine, QUICK)
    verdict = witness.verdict(ours, traced)
    assert verdict.same, verdict
    # The test can fail: 3 % of brightness is found.
    assert witness.verdict(1.03 * ours, traced).different


@pytest.fixture(scope="module")
def under_the_sun() -> np.ndarray:
    return witness.traced("terrace", Effort(renders=16, samples=192))


@pytest.mark.parametrize("engine", ["path", "fast"])
def test_sppm_agrees_with_the_tracer_under_a_sun(under_the_sun: np.ndarray, engine: str) -> None:
    """Shadows and caustics of a sun 10^6 away, where Mitsuba's are elsewhere."""
    ours = witness.rendered("terrace", engine, SUNNY)
    verdict = witness.verdict(ours, under_the_sun)
    assert verdict.same, verdict
    assert witness.verdict(1.03 * ours, under_the_sun).different


def test_glass_of_another_index_is_found(traced: np.ndarray, tmp_path: Path) -> None:
    other = tmp_path / "other.toml"
    other.write_text(Path(ASIDE).read_text().replace("ior = 1.5", "ior = 1.45"))
    assert witness.verdict(witness.rendered(str(other), "path", QUICK), traced).different


def test_the_ratio_has_the_error_of_both() -> None:
    random = np.random.default_rng(8)
    ours, theirs = (random.normal(mean, 0.1, size=(400, 4, 4, 3)) for mean in (3, 2))
    found = witness.ratio(ours, theirs)
    np.testing.assert_allclose(found.value, 1.5, rtol=0.005)
    # Means of 16 pixels: 0.1 / 4 / sqrt(400) each.
    np.testing.assert_allclose(found.stderr, 1.5 * np.hypot(1 / 3, 1 / 2) * 0.1 / 4 / 20, rtol=0.2)
