"""Arrays of any layout, as the extension module takes them: 32-bit, C-contiguous, aligned, in native byte order.

Large arrays are converted piece by piece, so that a conversion never takes more memory than a piece does.
"""

from __future__ import annotations

from typing import Any, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from ._errors import Error

Real: TypeAlias = npt.NDArray[Any]
"""An array of real numbers."""

ROWS_AT_ONCE = 1 << 16
"""Rows that are converted at a time."""


def real(value: object, name: str, error: type[Error]) -> Real:
    """``value`` as an array of real numbers, without a copy if it is one already."""
    if isinstance(value, np.ma.MaskedArray) and np.ma.is_masked(cast(Any, value)):
        raise error(f"{name} has masked elements; fill or remove them")
    try:
        array = np.asarray(value)
    except ValueError:
        raise error(f"{name} is a ragged sequence; all rows must be of the same length") from None
    if array.dtype.kind not in "fiu" and array.size > 0:
        raise TypeError(f"{name} is an array of {array.dtype}; give real numbers")
    return array if array.size > 0 else array.astype(np.float32)


def rows(value: object, name: str, error: type[Error]) -> Real:
    """``value`` as an array of shape (n, 3). Three numbers are one row."""
    array = real(value, name, error)
    if array.shape == (3,):
        array = array.reshape(1, 3)
    if array.size == 0 and array.ndim <= 2:
        array = array.reshape(0, 3)
    if array.ndim != 2 or array.shape[1] != 3:
        raise error(f"{name} has shape {array.shape}; it must be (n, 3), or (3,) for one")
    return array


def spread_rows(value: object, n: int, name: str, error: type[Error]) -> Real:
    """``value`` for each of ``n`` rows: an array of shape (n, 3), (3,) for the same in all, or () for a grey in all."""
    array = real(value, name, error)
    if array.shape not in ((n, 3), (3,), ()):
        raise error(f"{name} has shape {array.shape}; it must be (3,) for all or ({n}, 3) for each")
    return np.broadcast_to(array, (n, 3))


def spread(value: object, n: int, name: str, error: type[Error]) -> Real:
    """``value`` for each of ``n`` rows: an array of shape (n,), or () for the same in all."""
    array = real(value, name, error)
    if array.shape not in ((n,), ()):
        raise error(f"{name} has shape {array.shape}; it must be one number for all or ({n},) for each")
    return np.broadcast_to(array, (n,))


def singles(array: Real) -> npt.NDArray[np.float32]:
    """``array`` as the extension module takes it. Numbers beyond the range become infinite, which is refused later."""
    with np.errstate(over="ignore", under="ignore"):
        return np.require(array, np.float32, ["C", "A"])


def indices(value: object, name: str, error: type[Error]) -> npt.NDArray[np.int64]:
    """``value`` as an array of whole numbers."""
    array = np.asarray(value)
    if array.dtype.kind not in "iu":
        raise TypeError(f"{name} is an array of {array.dtype}; give whole numbers")
    if array.dtype.kind == "u" and array.size > 0 and int(array.max()) > np.iinfo(np.int64).max:
        raise error(f"{name} has the index {int(array.max())}, which is out of range")
    return array.astype(np.int64, copy=False)


def picture(value: object, name: str, error: type[Error]) -> npt.NDArray[np.float32]:
    """``value`` as an image of shape (height, width, 3), C-contiguous."""
    array = real(value, name, error)
    if array.ndim != 3 or array.shape[2] != 3 or array.size == 0:
        raise error(f"{name} has shape {array.shape}; an image is (height, width, 3)")
    return singles(array)


def plane(value: object, shape: tuple[int, ...], name: str, error: type[Error]) -> npt.NDArray[np.float32]:
    """``value`` as an image of one value per pixel, C-contiguous."""
    array = real(value, name, error)
    if array.shape != shape:
        raise error(f"{name} has shape {array.shape}; it must be that of the image, {shape}")
    return singles(array)


def frozen(array: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    """A read-only view of ``array``."""
    view = array.view()
    view.flags.writeable = False
    return view


def positions(value: object) -> object:
    """The positions of atoms (ASE's ``Atoms``, MDAnalysis' groups); anything else as it is."""
    if isinstance(value, np.ndarray):
        return cast(object, value)
    found = getattr(value, "positions", None)
    return value if found is None else found
