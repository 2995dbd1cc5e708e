"""Runs the command `sppm`, as a user would."""

from __future__ import annotations

import os
import subprocess
import tempfile
import tomllib
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from oracle import images

ROOT = Path(__file__).resolve().parent.parent
PAPER_SCENES = ("cornell", "large", "mirror", "random", "surgery")
SCENES = (*PAPER_SCENES, "focus", "motion")
# Those with truth by Mitsuba, which renders no scene right whose sun is 10^6 away (docs/oracle.md).
SCENES_WITH_TRUTH = (*SCENES, "dusk")
# Path depth at which the rest of the light is negligible; the ground truth has unlimited depth.
DEEP = 64


class OracleError(Exception):
    """Why the oracle cannot continue, in one line."""


def binary() -> Path:
    """The program to test: $SPPM, or the newest that cargo has built."""
    if named := os.environ.get("SPPM"):
        return Path(named)
    built = [path for kind in ("release", "debug") if (path := ROOT / "target" / kind / "sppm").exists()]
    if not built:
        raise OracleError("there is no target/release/sppm or target/debug/sppm; run cargo build, or set SPPM")
    return max(built, key=lambda path: path.stat().st_mtime)


def run(*args: str | Path) -> str:
    """Standard output of `sppm ARGS`. If it fails, its error message becomes an OracleError."""
    ended = subprocess.run([binary(), *map(str, args)], capture_output=True, text=True, check=False)
    if ended.returncode != 0:
        raise OracleError(f"sppm {args[0]}: {ended.stderr.strip()}")
    return ended.stdout


@dataclass(frozen=True)
class Render:
    """Arguments of `sppm render`."""

    scene: str
    width: int = 128
    height: int = 96
    iterations: int = 32
    photons: int = 20_000
    radius: float = 1.0
    depth: int = DEEP
    seed: int = 1
    engine: str = "fast"
    # None: as many as there are cores. The image is the same by any number.
    threads: int | None = None

    def settings(self) -> list[str]:
        """The options for the settings."""
        values = {
            "width": self.width,
            "height": self.height,
            "iterations": self.iterations,
            "photons": self.photons,
            "radius": self.radius,
            "depth": self.depth,
            "seed": self.seed,
        }
        return [f"--{name}={value}" for name, value in values.items()]

    def options(self) -> list[str]:
        """All options of the command line."""
        engine = "--method=path" if self.engine == "path" else f"--engine={self.engine}"
        return [*self.settings(), engine, *([f"--threads={self.threads}"] if self.threads else [])]

    def image(self) -> np.ndarray:
        """Linear radiance, (height, width, 3) of float32."""
        return self.image_and_count()[0]

    def image_and_count(self) -> tuple[np.ndarray, np.ndarray]:
        """The image, and the photon count of each pixel (height, width, 1), which is 0 for the path tracer."""
        with tempfile.TemporaryDirectory() as folder:
            path, count = Path(folder) / "image.pfm", Path(folder) / "count.pfm"
            has_photons = self.engine != "path"
            options = [*self.options(), *(["--count-image", str(count)] if has_photons else [])]
            run("render", self.scene, "--quiet", "--output", path, *options)
            image = images.read(path)
            counted = images.read(count)[..., :1] if has_photons else np.zeros_like(image[..., :1])
            return image, counted


@cache
def scene(name: str) -> dict[str, Any]:
    """The parsed scene file of a built-in scene, or a .toml file."""
    text = Path(name).read_text() if name.endswith(".toml") else run("scenes", name)
    return tomllib.loads(text)


def export(name: str, width: int, height: int, time: float | None = None) -> str:
    """The scene exported as XML for Mitsuba."""
    instant = [] if time is None else ["--time", repr(time)]
    return run("export", name, "--format", "mitsuba", f"--width={width}", f"--height={height}", *instant)


def trace(name: str, rays: np.ndarray, *options: str) -> np.ndarray:
    """The nearest hits of rays (n, 6): records of t, sphere and normal."""
    with tempfile.TemporaryDirectory() as folder:
        there, back = Path(folder) / "rays.npy", Path(folder) / "hits.npy"
        np.save(there, np.asarray(rays, dtype=np.float32))
        run("trace", name, "--rays", there, "--hits", back, *options)
        return np.load(back)
