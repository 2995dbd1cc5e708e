"""Styles of particles: arguments as the texts that scene files have."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias, cast

import numpy as np

from ._errors import InputError
from ._numbers import VectorLike, vector
from ._particles import Frame, Particles, Path, Unit, columns, frame_text
from ._tuples import Entries, ParticleColumns, StyleFields

ParticleSource: TypeAlias = Path | Particles | Any
"""Where particles come from: a file, :class:`sppm.Particles`, ``Atoms`` of ASE, or a group of MDAnalysis."""
Number: TypeAlias = str | float
"""A number, or the name of a column."""
Ends: TypeAlias = str | tuple[Number, Number]
"""The values at both ends of a map: two numbers, or percentiles such as ``"5%"``."""
Rule: TypeAlias = str | Mapping[str, Any]
"""A rule of a style, as on the command line or as in a scene file."""
Bonds: TypeAlias = Literal["file"] | Literal["distance"]
"""Where bonds come from."""

_KEYS = ("where", "radius", "scale", "color", "map", "range", "material", "hide")


def source_of(source: ParticleSource) -> str | ParticleColumns:
    """A path, or columns."""
    if isinstance(source, (str, os.PathLike)):
        return os.fspath(cast(Path, source))
    return columns(Particles.of(source))


def style_fields(
    *,
    frame: Frame,
    unit: Unit | None,
    wrap: bool,
    cut: str | Sequence[str],
    bonds: Bonds | None,
    cell: bool,
    color: str | None,
    map: str | None,
    range: Ends | None,
    radius: Number | None,
    scale: float | None,
    material: str | None,
    style: Rule | Sequence[Rule],
    origin: VectorLike,
) -> StyleFields:
    """The style as the extension module takes it."""
    keys: Entries = [("frame", frame_text(frame))]
    keys += [("unit", _word("unit", unit))] if unit is not None else []
    keys += [("bonds", _word("bonds", bonds))] if bonds is not None else []
    keys += [(name, _text(name, value)) for name, value in (("wrap", wrap), ("cell", cell))]
    base = {"radius": radius, "scale": scale, "color": color, "map": map, "range": range, "material": material}
    rules = [style] if isinstance(style, (str, Mapping)) else list(style)
    cuts = [cut] if isinstance(cut, str) else list(cut)
    return {
        "keys": keys,
        "origin": vector(origin, "origin", InputError),
        "cut": [_word("cut", one) for one in cuts],
        "base": [(name, _text(name, value)) for name, value in base.items() if value is not None],
        "rules": [_rule(rule) for rule in rules],
    }


def _rule(rule: object) -> str | Entries:
    if isinstance(rule, str):
        return rule
    if not isinstance(rule, Mapping):
        raise TypeError(f"a rule of style must be a str or a mapping, not {type(rule).__name__}")
    entries: Entries = []
    for key, value in cast("Mapping[object, object]", rule).items():
        if key not in _KEYS:
            raise InputError(f"style: there is no key {key!r}; the keys are {', '.join(_KEYS)}")
        entries.append((cast(str, key), _text(cast(str, key), value)))
    return entries


def _text(key: str, value: object) -> str:
    """The text that sets ``key`` to ``value``."""
    if key in ("wrap", "cell", "hide"):
        if not isinstance(value, (bool, np.bool_)):
            raise TypeError(f"{key} must be True or False, not {type(value).__name__}")
        return "true" if value else "false"
    if key in ("radius", "scale") and _is_number(value):
        return repr(float(cast(float, value)))
    if key == "range" and isinstance(value, (tuple, list)):
        ends = cast("Sequence[object]", value)
        if len(ends) != 2 or not all(isinstance(end, str) or _is_number(end) for end in ends):
            raise TypeError('range must be two numbers, or percentiles such as ("5%", "95%")')
        low, high = (end if isinstance(end, str) else repr(float(cast(float, end))) for end in ends)
        return f"{low}..{high}"
    return _word(key, value)


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float, np.integer, np.floating)) and not isinstance(value, bool)


def _word(name: str, value: object) -> str:
    if not isinstance(value, str):
        wanted = "a number or a str" if name in ("radius", "scale") else "a str"
        raise TypeError(f"{name} must be {wanted}, not {type(value).__name__}")
    return value
