"""Photon mapping from Python: scenes from arrays, images as arrays, and the same bits as the command ``sppm``.

    scene = sppm.Scene.load("cornell")
    film = sppm.render(scene, iterations=16)
    film.save("cornell.exr")

Build a scene by :class:`Scene`, or of molecules and particles by :func:`load_particles`. Render it by :func:`render`, or
watched by :class:`Render`; the image is a :class:`Film`. :func:`compare` judges images, :func:`trace` tells what rays hit,
and :func:`verify` checks that all engines agree. Errors are subclasses of :class:`Error`.
"""

from __future__ import annotations

from . import _sppm
from ._camera import Camera
from ._cell import Cell
from ._compare import Channels, LargestDifference, Metrics, compare, difference_image
from ._errors import Error, FileError, InputError, ParticleWarning, RenderError, RenderWarning, SceneError, SceneWarning
from ._film import Film, info
from ._interrupted import Interrupted
from ._materials import Dielectric, Diffuse, Material, Specular
from ._parts import Merged, merge, render_part
from ._particles import Particles, frame_count
from ._progress import Progress
from ._render import Render, render
from ._scene import Exported, Scene, builtin_scenes
from ._settings import Settings
from ._stage import load_particles
from ._trace import Hits, trace
from ._verify import Verification, verify

__all__ = [
    "Camera",
    "Cell",
    "Channels",
    "Dielectric",
    "Diffuse",
    "Error",
    "Exported",
    "FileError",
    "Film",
    "Hits",
    "InputError",
    "Interrupted",
    "LargestDifference",
    "Material",
    "Merged",
    "Metrics",
    "ParticleWarning",
    "Particles",
    "Progress",
    "Render",
    "RenderError",
    "RenderWarning",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Settings",
    "Specular",
    "Verification",
    "available_lanes",
    "builtin_scenes",
    "compare",
    "cores",
    "difference_image",
    "frame_count",
    "info",
    "load_particles",
    "merge",
    "render",
    "render_part",
    "trace",
    "verify",
]

__version__: str = _sppm.VERSION
"""The version of the package."""


def available_lanes() -> list[str]:
    """The names of the lanes that this processor has, for the argument ``lanes`` of :func:`render`."""
    return _sppm.lanes()


def cores() -> int:
    """The number of cores available to this process."""
    return _sppm.cores()
