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


def balls(**settings: object) -> sppm.Scene:
    """A matte ball, one of glass, and a mirror, before a background that is transparent."""
    scene = sppm.Scene(
        sppm.Camera.look_at([0, 0, 10], [0, 0, 0], vertical_fov_degrees=30),
        background=[0.4, 0.5, 0.6],
        transparent_background=True,
        settings=sppm.Settings(**{"width": 48, "height": 32, "iterations": 3, "initial_radius": 0.3, **settings}),
    )
    scene.add_spheres([[-2, 0, 0], [0, 0, 0], [2, 0, 0]], 0.9, [sppm.Diffuse(0.7), sppm.Dielectric(), sppm.Specular(0.9)])
    return scene


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
