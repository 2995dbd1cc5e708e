"""Tests of what the report shows."""

from __future__ import annotations

import base64

import cv2
import numpy as np
import pytest

from oracle import judge, report, truth
from oracle.ztest import Answer, Level, Verdict


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_a_difference_image_shows_something_whatever_its_size(size: float) -> None:
    values = size * np.random.default_rng(1).normal(size=(40, 50))
    values[0, 0] = 1e9 * size
    colours, scale = report.two_colours(values)
    # 98 % of a normal distribution are within 2.33.
    assert scale == pytest.approx(2.33 * size, rel=0.1)
    assert np.mean(colours.max(axis=-1) > 0.2) > 0.5
    assert (colours[..., 0] > 0)[values > 0].all() and (colours[..., 2] > 0)[values < 0].all()
    assert colours[..., 1].max() == 0 and colours.max() == 1


def test_the_difference_is_shown_where_there_are_too_few_photons_for_a_verdict() -> None:
    random = np.random.default_rng(2)
    expected = truth.load("cornell")
    noisy = expected.mean * (1 + 0.1 * random.normal(size=(8, *expected.mean.shape)))
    unknown = np.zeros((*expected.mean.shape[:2], 1))
    url, scale = report._difference(judge.Renders(noisy, noisy, unknown), expected)
    png = np.frombuffer(base64.b64decode(url.split(",")[1]), np.uint8)
    assert scale > 0.5 and np.mean(cv2.imdecode(png, cv2.IMREAD_COLOR).max(axis=-1) > 40) > 0.5


def test_equal_images_are_black() -> None:
    colours, scale = report.two_colours(np.zeros((3, 4)))
    assert scale == 1 and not colours.any()


def test_undecided_is_neither_red_nor_green() -> None:
    level = Level("pixels", 9, 12.0, 3e-9, "(1, 2) red", 1.5, is_judged=False)
    verdicts = {answer: Verdict(answer, 0.5, [level]) for answer in Answer}
    metrics = report.Metrics(0.9, 30.0, 0.1)
    scenes = [
        report.SceneReport(answer.name, [], metrics, verdicts[answer], verdicts[Answer.SAME], True)
        for answer in Answer
    ]
    nothing = {"intersections": [], "figure": "", "suites": None, "mutants": []}
    text = report._template().render(
        date="", version="", quick=True, significance=1e-3, scenes=scenes, most=16, **nothing
    )
    for answer, colour in ((Answer.SAME, "good"), (Answer.DIFFERENT, "bad"), (Answer.UNDECIDED, "unsure")):
        assert f'<td class="{colour}">{answer}</td>' in text
    assert "no: too few samples" in text
