"""Numbers as the renderer holds them: 32-bit floats and whole numbers in a range."""

from __future__ import annotations

import operator
from collections.abc import Sequence
from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from ._errors import Error, InputError

Vector: TypeAlias = tuple[float, float, float]
"""Three floats."""
VectorLike: TypeAlias = Sequence[float] | npt.NDArray[Any]
"""Three numbers: a sequence or an array."""


def single(value: object, name: str) -> float:
    """``value`` rounded to a 32-bit float, as the shortest decimal number that rounds to it.

    So 0.8 stays 0.8, and numbers compare equal after a round trip through a scene.
    """
    _check_number(value, name)
    with np.errstate(over="ignore", under="ignore"):
        rounded = np.float32(cast(float, value))
    short = float(str(rounded))
    with np.errstate(over="ignore", under="ignore"):
        return short if np.float32(short) == rounded else float(rounded)


def singles(value: object, count: int, name: str, error: type[Error]) -> tuple[float, ...]:
    """``count`` numbers, each as by :func:`single`."""
    try:
        array = np.asarray(value)
    except ValueError:
        raise error(f"{name} must be {count} numbers; it is a ragged sequence") from None
    if array.dtype.kind not in "fiu":
        raise TypeError(f"{name} must be {count} numbers, not {_kind(value)}")
    if array.shape != (count,):
        raise error(f"{name} must be {count} numbers; it has shape {array.shape}")
    return tuple(single(number, name) for number in array)


def vector(value: object, name: str, error: type[Error]) -> Vector:
    """Three numbers."""
    x, y, z = singles(value, 3, name, error)
    return x, y, z


def whole(value: object, name: str, least: int, most: int, error: type[Error]) -> int:
    """A whole number from ``least`` to ``most``."""
    if isinstance(value, (bool, np.bool_)):
        raise TypeError(f"{name} must be a whole number, not a bool")
    try:
        number = operator.index(cast(int, value))
    except TypeError:
        raise TypeError(f"{name} must be a whole number, not {_kind(value)}") from None
    if number < least:
        raise error(f"{name} is {number}; it must be at least {least}")
    if number > most:
        raise error(f"{name} is {number}; it must be at most {most}")
    return number


def threads(value: int | None) -> int | None:
    """A number of threads, or ``None``. A larger number than that is taken for a mistake."""
    return None if value is None else whole(value, "threads", 1, 1024, InputError)


def real(value: object, name: str) -> float:
    """A number, as a 64-bit float."""
    _check_number(value, name)
    return float(cast(float, value))


def _check_number(value: object, name: str) -> None:
    if isinstance(value, (str, bytes, bool)) or not (hasattr(value, "__float__") or hasattr(value, "__index__")):
        raise TypeError(f"{name} must be a number, not {_kind(value)}")


def positive(value: object, name: str, error: type[Error]) -> float:
    """A finite number above 0, as a 64-bit float."""
    number = real(value, name)
    if not (number > 0.0 and np.isfinite(number)):
        raise error(f"{name} is {number}; it must be a finite number above 0")
    return number


def _kind(value: object) -> str:
    return "an array of " + str(cast(Any, value).dtype) if isinstance(value, np.ndarray) else type(value).__name__
