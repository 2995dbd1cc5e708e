"""The cell of particles."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Cell:
    """A cell: a parallelepiped, which may repeat along its vectors. Lengths are those of the particles."""

    vectors: tuple[tuple[float, float, float], tuple[float, float, float], tuple[float, float, float]]
    """The edges that start at ``origin``."""
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """A corner."""
    periodic: tuple[bool, bool, bool] = (True, True, True)
    """Along which vectors it repeats."""
