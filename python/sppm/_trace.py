"""What rays hit."""

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from . import _arrays, _numbers, _sppm
from ._errors import InputError
from ._options import Engine, Lanes
from ._scene import Scene, native


class Hits(NamedTuple):
    """The nearest hits of n rays. The arrays are read-only."""

    t: npt.NDArray[np.float32]
    """Distances in scene units: shape (n,); infinite for a miss."""
    sphere: npt.NDArray[np.int32]
    """Indices of the spheres: shape (n,); -1 for a miss. A background counts as one more sphere, the last."""
    normal: npt.NDArray[np.float32]
    """Unit normals on the side that the ray comes from: shape (n, 3); zero for a miss."""


def trace(
    scene: Scene,
    origins: npt.ArrayLike,
    directions: npt.ArrayLike,
    *,
    time: float | None = None,
    engine: Engine = "fast",
    lanes: Lanes | None = None,
    threads: int | None = None,
) -> Hits:
    """Intersects rays with a scene. All engines and lanes give the same bits.

    ``origins`` and ``directions`` have shape (n, 3), or (3,) for the same in all rays. Directions may have any length
    but zero. ``time`` is that of the shutter; by default, when it opens.

    Raises InputError for wrong shapes, numbers that are not finite, directions of length 0, and a time at which the
    shutter is closed; TypeError for anything but real numbers.
    """
    starts = _arrays.rows(origins, "origins", InputError)
    ways = _arrays.rows(directions, "directions", InputError)
    n = max(len(starts), len(ways)) if min(len(starts), len(ways)) > 0 else 0
    for name, rows in (("origins", starts), ("directions", ways)):
        if len(rows) not in (1, n):
            raise InputError(f"{name} has {len(rows)} rows; there are {n} rays")
    rays = tuple(_arrays.singles(np.broadcast_to(rows, (n, 3)) if len(rows) else rows) for rows in (starts, ways))
    when = None if time is None else _numbers.single(time, "time")
    return Hits(*_sppm.trace(native(scene), (rays[0], rays[1]), when, engine, lanes, _numbers.threads(threads)))
