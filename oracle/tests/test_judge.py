"""Tests of the verdict on real renders: correct images pass, and images with errors fail."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from oracle import judge, sppm, truth
from oracle.judge import Effort, Renders
from oracle.sppm import Render

# Render at half the size of the truth, in a quarter of the time.
FACTOR = 2
QUICK = Effort(seeds=16, iterations=24, photons=40_000)
# Enough to find large errors.
COARSE = Effort(seeds=16, iterations=8, photons=20_000)
SEEDS = (1, 1001, 2001)


@cache
def expected(scene: str) -> truth.Truth:
    return truth.reduced(truth.load(scene), FACTOR)


@cache
def renders(scene: str, first_seed: int = 1, engine: str = "fast", effort: Effort = QUICK) -> Renders:
    height, width = expected(Path(scene).stem).mean.shape[:2]
    effort = replace(effort, first_seed=first_seed)
    return judge.renders(Render(scene, width=width, height=height, engine=engine), effort)


def other(ours: Renders, change: Callable[[np.ndarray], np.ndarray]) -> Renders:
    """The same renders with changed images."""
    return Renders(change(ours.images), change(ours.pixels), ours.is_known)


def changed(folder: Path, scene: str, pattern: str, replacement: str) -> str:
    """A scene file of the same name in which matches of `pattern` are replaced."""
    text, count = re.subn(pattern, replacement, sppm.run("scenes", scene), flags=re.MULTILINE)
    assert count > 0, pattern
    path = folder / f"{scene}.toml"
    path.write_text(text)
    return str(path)


@pytest.mark.parametrize("first_seed", SEEDS)
def test_an_unmodified_render_passes(first_seed: int) -> None:
    verdict = judge.verdict(renders("cornell", first_seed), expected("cornell"))
    assert verdict.same, verdict


@pytest.mark.parametrize("scene", ["mirror", "surgery", "motion", "focus", "dusk"])
def test_other_scenes_pass(scene: str) -> None:
    verdict = judge.verdict(renders(scene), expected(scene))
    assert verdict.same, verdict


def test_the_path_tracer_passes() -> None:
    verdict = judge.verdict(renders("cornell", engine="path"), expected("cornell"))
    assert verdict.same, verdict


@pytest.mark.parametrize("factor", [0.99, 1.01])
@pytest.mark.parametrize("first_seed", SEEDS)
def test_one_percent_of_brightness_fails(factor: float, first_seed: int) -> None:
    ours = renders("cornell", first_seed)
    verdict = judge.verdict(other(ours, lambda images: images * factor), expected("cornell"))
    assert verdict.different, verdict


def test_lamps_one_percent_brighter_fail(tmp_path: Path) -> None:
    brighter = changed(tmp_path, "cornell", r"^emission = \[(\d+), (\d+), (\d+)\]", r"emission = [\1.\1, \2.\2, \3.\3]")
    # 20 became 20.20 and 10 became 10.10.
    assert "emission = [20.20, 10.10, 10.10]" in Path(brighter).read_text()
    verdict = judge.verdict(renders(brighter), expected("cornell"))
    assert verdict.different, verdict


@pytest.mark.parametrize("first_seed", SEEDS)
@pytest.mark.parametrize(("axis", "step"), [(1, 1), (1, -1), (2, 1), (2, -1)])
def test_a_shift_by_one_pixel_fails(axis: int, step: int, first_seed: int) -> None:
    ours = renders("cornell", first_seed)
    verdict = judge.verdict(other(ours, lambda images: np.roll(images, step, axis=axis)), expected("cornell"))
    assert verdict.different, verdict


def test_a_missing_caustic_fails(tmp_path: Path) -> None:
    """Removes only the caustic; the glass ball and everything else stay."""
    glass = r'type = "dielectric", albedo = \[0.999, 0.999, 0.999\], ior = 1.5'
    black = changed(tmp_path, "cornell", glass, 'type = "diffuse", albedo = [0, 0, 0]')
    ours = renders("cornell")
    whole, without = ours.images, renders(black).images
    # The caustic is where the floor is brighter than with a black ball; the rows of the ball itself are left out.
    ball_and_above = np.zeros(whole.shape[1:], dtype=bool)
    ball_and_above[:36] = True
    brighter = (whole.mean(axis=0) > 1.2 * without.mean(axis=0)) & ~ball_and_above
    assert 10 < brighter[..., 0].sum() < 400
    unlit = Renders(
        np.where(brighter, without, whole), np.where(brighter, renders(black).pixels, ours.pixels), ours.is_known
    )
    verdict = judge.verdict(unlit, expected("cornell"))
    assert verdict.different, verdict


def test_glass_that_does_not_refract_fails(tmp_path: Path) -> None:
    straight = changed(tmp_path, "cornell", "ior = 1.5", "ior = 1")
    verdict = judge.verdict(renders(straight, effort=COARSE), expected("cornell"))
    assert verdict.different, verdict


def test_the_papers_depth_fails() -> None:
    """Depth 5 loses 6 to 13 % of this scene's light."""
    height, width = expected("cornell").mean.shape[:2]
    shallow = judge.renders(Render("cornell", width=width, height=height, depth=5), COARSE)
    assert judge.verdict(shallow, expected("cornell")).different


def test_radii_suit_the_unit_of_a_scene(tmp_path: Path) -> None:
    def scene(unit: float) -> str:
        path = tmp_path / f"{unit}.toml"
        path.write_text(
            f"background = [1, 1, 1]\ncamera = {{ eye = [0, 0, {10 * unit}], direction = [0, 0, -1], "
            f"vertical_fov_degrees = 10 }}\n[[sphere]]\ncenter = [0, 0, {-100 * unit}]\nradius = {100 * unit}\n"
            'material = { type = "diffuse", albedo = [1, 1, 1] }\n'
        )
        return str(path)

    side = 10 * 2 * np.tan(np.radians(5)) / 96
    for unit in (1e-3, 1.0, 1e3):
        assert judge.pixel(scene(unit)) == pytest.approx(side * unit, rel=0.01)
    assert judge.pixel("cornell") == 1.0
