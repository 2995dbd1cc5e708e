"""The camera."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from . import _sppm
from ._errors import SceneError
from ._numbers import Vector, VectorLike, single, singles, vector
from ._tuples import CameraTuple

_UP = (0.0, 1.0, 0.0)


@dataclass(frozen=True, init=False)
class Camera:
    """A perspective camera: a pinhole or a thin lens, with a shutter. Lengths are in scene units."""

    eye: Vector
    """Centre of the lens."""
    direction: Vector
    """Viewing direction, of any length but zero."""
    up: Vector
    """The direction that points up in the image; not parallel to ``direction``."""
    vertical_fov_degrees: float
    """Field of view from the lower to the upper edge of the image, between 0 and 180."""
    aperture_radius: float
    """Radius of the lens; 0 is a pinhole, which has everything in focus."""
    focus_distance: float
    """Distance of the plane in focus, along ``direction``."""
    shutter: tuple[float, float]
    """Times at which the shutter opens and closes."""

    def __init__(
        self,
        eye: VectorLike = (0.0, 0.0, 0.0),
        direction: VectorLike = (0.0, 0.0, -1.0),
        up: VectorLike = _UP,
        vertical_fov_degrees: float = 40.0,
        aperture_radius: float = 0.0,
        focus_distance: float = 1.0,
        shutter: Sequence[float] = (0.0, 0.0),
    ) -> None:
        """A camera. By default it is a pinhole at the origin that looks along -z.

        Raises SceneError if a value is out of its range, or ``up`` is parallel to ``direction``.
        """
        values = {
            "eye": vector(eye, "eye", SceneError),
            "direction": vector(direction, "direction", SceneError),
            "up": vector(up, "up", SceneError),
            "vertical_fov_degrees": single(vertical_fov_degrees, "vertical_fov_degrees"),
            "aperture_radius": single(aperture_radius, "aperture_radius"),
            "focus_distance": single(focus_distance, "focus_distance"),
            "shutter": singles(shutter, 2, "shutter", SceneError),
        }
        for name, value in values.items():
            object.__setattr__(self, name, value)
        _sppm.check_camera(to_tuple(self))

    @classmethod
    def look_at(
        cls,
        eye: VectorLike,
        target: VectorLike,
        *,
        up: VectorLike = _UP,
        vertical_fov_degrees: float = 40.0,
        aperture_radius: float = 0.0,
        focus_distance: float | None = None,
        shutter: Sequence[float] = (0.0, 0.0),
    ) -> Camera:
        """A camera at ``eye`` that looks at the point ``target``, on which it is focused unless told otherwise.

        Raises SceneError as the constructor, and if ``target`` is where ``eye`` is.
        """
        # In 32 bits, as scene files do it, so that the same numbers give the same image.
        start, end = (np.array(vector(v, n, SceneError), np.float32) for v, n in ((eye, "eye"), (target, "target")))
        with np.errstate(over="ignore", invalid="ignore"):
            direction = end - start
        if not direction.any():
            raise SceneError("target of the camera is where eye is; it must be elsewhere")
        x, y, z = (float(d) for d in direction)
        focus = (x * x + y * y + z * z) ** 0.5 if focus_distance is None else focus_distance
        return cls(start, direction, up, vertical_fov_degrees, aperture_radius, focus, shutter)

    def replace(self, **changes: Any) -> Camera:
        """The same camera but for the values given, by the names of the constructor's arguments."""
        values = {field.name: getattr(self, field.name) for field in fields(self)}
        return Camera(**{**values, **changes})


def to_tuple(camera: Camera) -> CameraTuple:
    """The camera as the extension module takes it."""
    return (
        camera.eye,
        camera.direction,
        camera.up,
        camera.vertical_fov_degrees,
        camera.aperture_radius,
        camera.focus_distance,
        camera.shutter,
    )
