"""Tests of the pixels that are masked because Mitsuba leaks light there."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oracle import contacts, judge, sppm, tracer, truth
from oracle.judge import Renders

# A glass ball, through which one sees where it touches the floor.
GLASS_BALL = """
[camera]
eye = [0, 200, 40]
target = [0, 2, 0]
vertical_fov_degrees = 3

[[sphere]]
center = [0, -1000, 0]
radius = 1000
material = { type = "diffuse", albedo = [0.5, 0.5, 0.5] }

[[sphere]]
center = [0, HEIGHT, 0]
radius = 3
material = { type = "dielectric", albedo = [1, 1, 1], ior = 1.5 }

[[sphere]]
center = [0, 40, 0]
radius = 2
material = { type = "diffuse", albedo = [0, 0, 0] }
emission = [10, 10, 10]
"""


def ball_at(height: float, folder: Path) -> str:
    path = folder / f"ball_{height}.toml"
    path.write_text(GLASS_BALL.replace("HEIGHT", str(height)))
    return str(path)


def on_floor(x: np.ndarray) -> tracer.Hits:
    """Hits on the floor, at a distance x from its top."""
    points = np.stack([x, np.sqrt(1000**2 - x**2) - 1000, np.zeros_like(x)], axis=1)
    floor, outside = np.zeros(len(x), dtype=int), np.zeros(len(x), dtype=bool)
    return tracer.Hits(points, (points + [0, 1000, 0]) / 1000, floor, outside)


def test_a_contact_reaches_as_far_as_the_gap_is_small(tmp_path: Path) -> None:
    """At a distance x from the contact the gap between ball and floor is x^2 (1/3 + 1/1000) / 2."""
    world, _ = tracer.read(ball_at(3, tmp_path))
    moved = np.array([0.0, 0.0, 100.0])
    offset = 9e-5 * 101
    edge = np.sqrt(2 * contacts.MARGIN * offset / (1 / 3 + 1 / 1000))
    assert 0.3 < edge < 0.4
    x = edge * np.array([-1.1, -0.9, 0, 0.9, 1.1])
    assert contacts.near_contact(world, on_floor(x), moved).tolist() == [False, True, True, True, False]
    # Near the origin, where Mitsuba's offset is small, the same place is safe.
    assert not contacts.near_contact(world, on_floor(x[3:4]), 0 * moved).any()


def test_walls_that_cross_do_not_leak() -> None:
    """Near an edge of the Cornell Box, at half of the offset of 0.02 and its margin."""
    world, _ = tracer.read("cornell")
    floor, left = 3, 0
    height = world.centers[floor, 1] - world.radii[floor]
    inside = np.sqrt(world.radii[left] ** 2 - (height - world.centers[left, 1]) ** 2) - 0.02
    point = np.array([[world.centers[left, 0] - inside, height, world.centers[left, 2]]])
    hit = tracer.Hits(point, np.array([[0.0, 1.0, 0.0]]), np.array([floor]), np.array([False]))
    assert np.abs(np.linalg.norm(point - world.centers[left]) - world.radii[left]) == pytest.approx(0.02, rel=1e-4)
    assert not contacts.near_contact(world, hit, np.array([0, 0, 109.0])).any()


def test_pixels_that_see_a_contact_are_masked(tmp_path: Path) -> None:
    touching, hovering = (contacts.mask(ball_at(height, tmp_path), 40, 30) for height in (3, 3.5))
    assert touching.shape == (30, 40, 1)
    # With the neighbours that is at least 3x3, and far from all of the ball, which covers some 230 pixels.
    assert 9 <= (touching == 0).sum() < 60
    # Only pixels of the ball see it: those in the middle of the image.
    y, x, _ = np.nonzero(touching == 0)
    assert (np.abs(x - 19.5) < 8).all() and (np.abs(y - 14.5) < 10).all()
    assert hovering.all()


def test_the_two_known_pixels_of_random_are_masked() -> None:
    """Where the truth differs from sppm and from the tracer: see docs/oracle.md."""
    mask = contacts.mask("random", truth.WIDTH, truth.HEIGHT)
    assert mask[84, 43] == 0 and mask[88, 90] == 0
    assert 1 - mask.mean() < 0.1


@pytest.mark.parametrize("scene", ["mirror", "motion"])
def test_few_pixels_are_masked(scene: str) -> None:
    share = 1 - contacts.mask(scene, 64, 48).mean()
    assert share < 0.03


def test_masked_pixels_are_not_judged() -> None:
    expected = truth.load("cornell")
    random = np.random.default_rng(3)
    same = expected.mean + expected.stderr * random.normal(size=(16, *expected.mean.shape))
    wrong = same.copy()
    wrong[:, 40:42, 50:53] *= 2
    known = np.ones((*expected.mean.shape[:2], 1))
    mask = known.copy()
    mask[40:42, 50:53] = 0
    assert judge.verdict(Renders(same, same, known), expected).same
    assert judge.verdict(Renders(wrong, wrong, known), expected).different
    assert judge.verdict(Renders(wrong, wrong, known), expected, mask).same


def test_the_shift_is_that_of_the_export() -> None:
    exported = sppm.export("random", 64, 48)
    eye = sppm.scene("random")["camera"]["eye"]
    moved = contacts._shift("random", 64, 48, None)
    assert moved[2] > 50
    assert f'origin="{eye[0]}, {eye[1]}, {round(eye[2] + moved[2], 3):g}"' in exported
