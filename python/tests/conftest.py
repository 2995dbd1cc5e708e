"""What tests share: small scenes, and the command to compare with."""

from __future__ import annotations

import os
import signal
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import sppm

# A shell starts what runs in the background with SIGINT ignored, and programs that are started from here would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)

SMALL = {"width": 40, "height": 30, "iterations": 2, "photons_per_iteration": 4000}
"""Settings of a render that takes some milliseconds."""
ENDLESS = {**SMALL, "iterations": 1 << 30, "threads": 1}
"""Settings of a render that no test waits for."""


@pytest.fixture
def cornell() -> sppm.Scene:
    """The scene cornell with small settings."""
    scene = sppm.Scene.load("cornell")
    scene.settings = scene.settings.replace(**SMALL)
    return scene


@pytest.fixture(scope="session")
def command() -> Callable[..., str]:
    """Runs the command sppm and returns what it prints."""
    program = os.environ.get("SPPM", str(Path(__file__).parents[2] / "target/debug/sppm"))

    def run(*arguments: object) -> str:
        done = subprocess.run([program, *map(str, arguments)], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        return done.stdout

    return run
