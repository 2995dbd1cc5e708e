"""What the extension module takes and gives: the fields of cameras, settings and materials in order, those of particles and
of their styles by name."""

from __future__ import annotations

from typing import Any, TypeAlias, TypedDict

import numpy as np
import numpy.typing as npt

from ._numbers import Vector

CameraTuple: TypeAlias = tuple[Vector, Vector, Vector, float, float, float, tuple[float, float]]
"""The fields of a camera."""
SettingsTuple: TypeAlias = tuple[int, int, int, int, int, float, int, str, str, int, float, tuple[int, int]]
"""The fields of settings."""
MaterialTuple: TypeAlias = tuple[str, Vector, float | None]
"""The type of a material as in scene files, its albedo, and the index of refraction of a dielectric."""
LabelsTuple: TypeAlias = tuple[list[str], npt.NDArray[np.uint16]]
"""Texts, and the index of its text for each particle."""
CellTuple: TypeAlias = tuple[list[float], list[list[float]], tuple[bool, bool, bool]]
"""The origin of a cell, its vectors, and along which it repeats."""
Entries: TypeAlias = list[tuple[str, str]]
"""Keys of scene files, with texts that they are set to."""


class ParticleColumns(TypedDict):
    """The columns of particles."""

    title: str
    """One line."""
    unit: str | None
    """Its name; ``None`` if it is not known."""
    positions: npt.NDArray[np.float64]
    """Shape (n, 3)."""
    elements: npt.NDArray[np.uint8] | None
    """Atomic numbers."""
    types: LabelsTuple | None
    """Texts."""
    radii: npt.NDArray[np.float32] | None
    """Shape (n,)."""
    colors: npt.NDArray[np.float32] | None
    """Shape (n, 3)."""
    names: LabelsTuple | None
    """Texts."""
    residues: LabelsTuple | None
    """Texts."""
    residue_numbers: npt.NDArray[np.int32] | None
    """Shape (n,)."""
    chains: LabelsTuple | None
    """Texts."""
    molecules: npt.NDArray[np.uint32] | None
    """Shape (n,)."""
    ids: npt.NDArray[np.uint64] | None
    """Shape (n,)."""
    properties: list[tuple[str, npt.NDArray[np.float32]]]
    """Names and columns."""
    bonds: npt.NDArray[np.uint32]
    """Shape (m, 2), the lower first, sorted."""
    cell: CellTuple | None
    """The cell."""


class StyleFields(TypedDict):
    """What makes spheres of particles."""

    keys: Entries
    """Those of a file of particles that are texts."""
    origin: Any
    """The point that becomes the origin."""
    cut: list[str]
    """Selections."""
    base: Entries
    """The rule for all particles."""
    rules: list[str | Entries]
    """The rules for some."""


class StageFields(TypedDict):
    """Camera, lamps and background around particles."""

    view: str | None
    """Its name."""
    zoom: float
    """From 0.1 to 1000."""
    light: str
    """Its name."""
    ground: bool
    """Whether there is one."""
    background: str | None
    """A colour."""
    size: tuple[int, int]
    """Width and height."""
