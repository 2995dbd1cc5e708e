"""Cameras, settings and materials as the extension module takes and gives them: their fields, in order."""

from __future__ import annotations

from typing import TypeAlias

from ._numbers import Vector

CameraTuple: TypeAlias = tuple[Vector, Vector, Vector, float, float, float, tuple[float, float]]
"""The fields of a camera."""
SettingsTuple: TypeAlias = tuple[int, int, int, int, int, float, int, str, str, int]
"""The fields of settings."""
MaterialTuple: TypeAlias = tuple[str, Vector, float | None]
"""The type of a material as in scene files, its albedo, and the index of refraction of a dielectric."""
