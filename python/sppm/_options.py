"""The options of renders, checked, as the extension module takes them."""

from __future__ import annotations

import os
from collections.abc import Callable
from datetime import timedelta
from typing import Any, Literal, TypeAlias, cast

from . import _numbers, _sppm
from ._errors import InputError
from ._settings import to_tuple

Method: TypeAlias = Literal["sppm"] | Literal["path"] | Literal["hybrid"]
"""A method: photon mapping, path tracing, or path tracing with photons for caustics."""
Engine: TypeAlias = Literal["fast"] | Literal["reference"]
"""An engine. Both give the same image, bit for bit."""
Lanes: TypeAlias = Literal["auto"] | Literal["avx2"] | Literal["avx512"] | Literal["emulated"]
"""The vectors that the fast engine works on; the image does not depend on them."""
Quality: TypeAlias = Literal["paper"] | Literal["draft"] | Literal["good"] | Literal["final"]
"""How good a picture is to be; ``"paper"`` stands for the settings of the paper."""


def options(*, every: int | timedelta | None = None, paused: bool = False, **given: Any) -> dict[str, Any]:
    """All options of the extension module, from arguments of :func:`sppm.render`; those not given are ``None``.

    Raises InputError and TypeError for wrong values.
    """
    checked = {name: None if value is None else _CHECKS[name](value, name) for name, value in given.items()}
    return {**dict.fromkeys((*_CHECKS, "every_seconds", "every_iterations")), **checked, **_every(every), "paused": bool(paused)}


def _word(value: object, name: str) -> str:
    if isinstance(value, str):
        return value
    raise TypeError(f"{name} must be a name, not {type(value).__name__}")


def _path(value: object, _: str) -> str:
    return os.fspath(cast("str | os.PathLike[str]", value))


def _positive(value: object, name: str) -> float:
    return _numbers.positive(value, name, InputError)


def _seconds(time: object, name: str) -> float:
    """A time above 0 and below a century, in seconds."""
    seconds = time.total_seconds() if isinstance(time, timedelta) else time
    value = _positive(seconds, name)
    if value > 3.2e9:
        raise InputError(f"{name} is {value} seconds; it must be below a century")
    return value


def _every(every: int | timedelta | None) -> dict[str, Any]:
    """How often a checkpoint is written."""
    if every is None:
        return {}
    if isinstance(every, timedelta):
        return {"every_seconds": _seconds(every, "every")}
    return {"every_iterations": _numbers.whole(every, "every", 1, _sppm.MAX_ITERATIONS, InputError)}


def _known(value: object, _: str) -> object:
    """What the package has made itself."""
    return value


_CHECKS: dict[str, Callable[[Any, str], object]] = {
    "settings": lambda value, _: to_tuple(value),
    "quality": _word,
    "given": _known,
    "method": _word,
    "engine": _word,
    "lanes": _word,
    "profile": _path,
    "threads": lambda value, _: _numbers.threads(value),
    "memory_limit": lambda value, name: _numbers.whole(value, name, 1, 2**60, InputError),
    "time": _seconds,
    "until_error": _positive,
    "checkpoint": _path,
    "range": _known,
}
"""How each argument is checked and converted, by its name."""
