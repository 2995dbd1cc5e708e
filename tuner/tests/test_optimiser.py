"""Tests of the optimiser process on its own, with the protocol of `sppm tune`."""

from __future__ import annotations

import json
import math
import os
import random
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
DIMENSIONS = [
    {"name": "size", "kind": "real", "least": 0.5, "most": 4.0},
    {"name": "count", "kind": "whole", "least": 0, "most": 8},
    {"name": "way", "kind": "choice", "choices": ["a", "b"]},
]
START = [1.5, 3, "a"]


class Optimiser:
    """The optimiser process, which exits at the end of its input."""

    def __init__(self, seed: int, initial: int = 8) -> None:
        self.process = subprocess.Popen(
            [ROOT / "scripts/python", ROOT / "tuner/optimiser.py"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env={**os.environ, "SPPM_REQUIREMENTS": "tuner/requirements.lock"},
        )
        setup = {"dimensions": DIMENSIONS, "start": START, "initial": initial, "seed": seed}
        self.name = self.request(**setup)["optimiser"]

    def request(self, **fields):
        self.process.stdin.write(json.dumps(fields) + "\n")
        self.process.stdin.flush()
        return json.loads(self.process.stdout.readline())

    def close(self) -> int:
        self.process.stdin.close()
        return self.process.wait(timeout=60)


def search(seed: int, evaluations: int, value) -> tuple[list, dict]:
    """Runs a search; returns the points tried and the conclusion."""
    optimiser = Optimiser(seed)
    points = []
    for told in range(1, evaluations + 1):
        points.append(optimiser.request(ask=True)["point"])
        assert optimiser.request(tell=points[-1], value=value(points[-1])) == {"told": told}
    conclusion = optimiser.request(conclude=True)
    assert optimiser.close() == 0
    return points, conclusion


def valley(noise: float):
    """A noisy function with its minimum at size 1 and way b, for any count; `noise` is the standard deviation."""
    numbers = random.Random(7)

    def value(point) -> float:
        size, _, way = point
        return math.log(size) ** 2 + (0.0 if way == "b" else 0.3) + numbers.gauss(0.0, noise)

    return value


@pytest.fixture(scope="module")
def concluded():
    return search(1, 24, valley(0.01))


def test_it_begins_at_the_start_and_stays_in_the_space(concluded):
    points, _ = concluded
    assert points[0] == START
    for size, count, way in points:
        assert 0.5 <= size <= 4.0 and count in range(9) and way in ("a", "b")


def test_it_finds_the_valley_through_noise(concluded):
    points, conclusion = concluded
    assert sorted(conclusion["order"]) == list(range(len(points)))
    size, _, way = points[conclusion["order"][0]]
    # Within a tenth of the logarithmic range, where the function is within a few standard deviations of its minimum.
    assert way == "b" and abs(math.log(size)) < 0.21


def test_the_kernel_is_matern_with_white_noise(concluded):
    _, conclusion = concluded
    assert "Matern" in conclusion["kernel"] and "WhiteKernel" in conclusion["kernel"]
    # The dimension that matters has the shorter length scale.
    assert conclusion["length_scales"]["size"] < conclusion["length_scales"]["count"]
    assert 0.0 <= conclusion["noise"] < 0.1


def test_a_seed_gives_the_same_proposals():
    (first, _), (second, _), (other, _) = (search(seed, 10, valley(0.0)) for seed in (3, 3, 4))
    assert first == second
    assert first != other


def test_few_points_are_ordered_by_value():
    optimiser = Optimiser(1)
    for value in (0.2, 0.1, 0.3):
        optimiser.request(tell=optimiser.request(ask=True)["point"], value=value)
    assert optimiser.request(conclude=True)["order"] == [1, 0, 2]
    assert optimiser.close() == 0
