"""Tests `sppm tune` with the real optimiser: it must write a profile that renders can load."""

from __future__ import annotations

import os
import subprocess
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SPPM = (ROOT / os.environ.get("SPPM", "target/debug/sppm")).resolve()
TINY = ["--width", "32", "--height", "24", "--photons", "1000", "--iterations", "1"]


def sppm(folder: Path, *arguments: str) -> str:
    ended = subprocess.run([SPPM, *arguments], cwd=folder, capture_output=True, text=True)
    assert ended.returncode == 0, ended.stderr
    return ended.stdout


@pytest.mark.parametrize("threads", ["1", "2"])
def test_a_search_makes_a_profile(tmp_path, threads):
    budget = ["--evaluations", "9", "--pairs", "1", "--final-pairs", "6"]
    said = sppm(tmp_path, "tune", "random", *TINY, *budget, "--threads", threads, "-o", "p.toml", "--plot", "p.svg")
    assert "9 points tried" in said and "noise" in said and "wrote p.toml" in said
    profile = tomllib.loads((tmp_path / "p.toml").read_text())
    tuned, search = profile["tuned"], profile["search"]
    assert search["optimiser"].startswith("scikit-optimize ")
    assert len(search["ratios"]) == 9 and search["best"] == sorted(search["best"], reverse=True)
    # With 172 balls, how they are searched is a dimension. Job sizes are dimensions only with more than one thread.
    assert "search" in search["length_scales"]
    assert ("photons_per_job" in search["length_scales"]) == (threads == "2")
    assert tuned["is_confirmed"] and tuned["best_interval"][0] <= tuned["best_ratio"] <= tuned["best_interval"][1]
    assert tuned["is_gain"] == (tuned["best_interval"][1] < 1)
    sppm(tmp_path, "verify", "random", *TINY, "--profile", "p.toml")
