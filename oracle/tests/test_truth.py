"""Tests of the stored ground truth: it is complete, and Mitsuba still renders the same."""

from __future__ import annotations

import json

import numpy as np
import pytest

from oracle import judge, sppm, truth, ztest
from oracle.__main__ import main
from oracle.truth import Plan, Truth


@pytest.mark.parametrize("scene", sppm.SCENES_WITH_TRUTH)
def test_every_scene_has_truth_and_provenance(scene: str) -> None:
    found = truth.load(scene)
    assert found.mean.shape == found.stderr.shape == (truth.HEIGHT, truth.WIDTH, 3)
    assert np.isfinite(found.mean).all() and (found.mean >= 0).all() and np.isfinite(found.stderr).all()
    told = json.loads(truth.path(scene).with_suffix(".json").read_text())
    assert told["scene"] == scene and told["batches"] == found.batches
    np.testing.assert_allclose(told["channel_means"], found.mean.mean(axis=(0, 1)), rtol=1e-6)


def test_truth_is_small() -> None:
    assert sum(path.stat().st_size for path in truth.FOLDER.iterdir()) < 3_000_000


def test_mitsuba_still_renders_the_stored_truth() -> None:
    """Compares a few samples of the scene, as it is exported now, with the stored truth."""
    fresh = truth.make("cornell", Plan(batches=8, samples_per_batch=8, seed=77), 64, 48)
    stored = truth.reduced(truth.load("cornell"), 2)
    pairs = {}
    for block in (8, ztest.WHOLE):
        everything = np.ones_like(stored.mean)
        a, b = (ztest.of_pixels(t.mean, t.stderr, t.batches - 1, block, everything) for t in (fresh, stored))
        pairs[block] = (a, b)
    verdict = ztest.compare(pairs)
    assert verdict.same, verdict


def test_reducing_keeps_mean_and_error() -> None:
    random = np.random.default_rng(8)
    batches = random.normal(1, 0.1, size=(64, 8, 12, 3))
    whole = truth.from_batches(batches)
    half = truth.reduced(whole, 2)
    assert half.mean.shape == (4, 6, 3)
    np.testing.assert_allclose(half.mean.mean(), whole.mean.mean())
    np.testing.assert_allclose(np.median(half.stderr), 0.1 / 8 / 2, rtol=0.1)


def test_extrapolation_removes_what_is_linear_and_quadratic_in_the_radius() -> None:
    random = np.random.default_rng(9)
    exact, slope, curvature = (random.normal(size=(3, 4, 5, 3)) for _ in range(3))
    line = [exact + slope * radius for radius in judge.RADII]
    parabola = [exact + slope * radius + curvature * radius**2 for radius in judge.RADII]
    np.testing.assert_allclose(judge.linear(*line[:2]), exact, atol=1e-12)
    np.testing.assert_allclose(judge.quadratic(*line), exact, atol=1e-12)
    np.testing.assert_allclose(judge.quadratic(*parabola), exact, atol=1e-12)
    # The linear one leaves half of the quadratic error of the larger radius, with opposite sign.
    left = judge.linear(*parabola[:2]) - exact
    np.testing.assert_allclose(left, -0.5 * curvature * judge.RADII[0] ** 2, atol=1e-12)


def test_saving_and_loading_is_lossless_enough(tmp_path: object, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(truth, "FOLDER", tmp_path)
    made = Truth(np.full((2, 2, 3), 1 / 3), np.full((2, 2, 3), 0.001), 7)
    truth.save("cornell", made, {})
    read = truth.load("cornell")
    np.testing.assert_allclose(read.mean, made.mean, rtol=1e-7)
    np.testing.assert_allclose(read.stderr, made.stderr, rtol=1e-3)
    assert read.batches == 7


def test_the_command_says_what_is_wrong(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["truth", "check", "cornel"]) == 2
    assert "cornel" in capsys.readouterr().err
    assert main(["images", "missing.exr", "missing.png"]) == 2
    assert "missing.exr is no file" in capsys.readouterr().err
    with pytest.raises(SystemExit) as ended:
        main(["intersections", "--rays", "0"])
    assert ended.value.code == 2
