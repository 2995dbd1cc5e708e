"""Materials: how surfaces reflect and transmit light."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

from . import _sppm
from ._errors import SceneError
from ._numbers import Vector, VectorLike, single, vector
from ._tuples import MaterialTuple


def _color(value: VectorLike | float, name: str) -> Vector:
    """A colour; one number is a grey."""
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        value = (value, value, value)
    return vector(value, name, SceneError)


@dataclass(frozen=True, init=False)
class Diffuse:
    """A Lambertian reflector: it reflects light equally in all directions, and is opaque."""

    albedo: Vector
    """The reflected share of the light, per channel of linear RGB, in [0, 1]."""

    def __init__(self, albedo: VectorLike | float) -> None:
        """A reflector with this ``albedo``: three numbers, or one for a grey.

        Raises SceneError if a channel is outside of [0, 1].
        """
        object.__setattr__(self, "albedo", _color(albedo, "albedo of Diffuse"))
        _sppm.check_material(to_tuple(self), "Diffuse")


@dataclass(frozen=True, init=False)
class Specular:
    """A perfect mirror, opaque."""

    albedo: Vector
    """The reflected share of the light, per channel of linear RGB, in [0, 1]."""

    def __init__(self, albedo: VectorLike | float) -> None:
        """A mirror with this ``albedo``: three numbers, or one for a grey.

        Raises SceneError if a channel is outside of [0, 1].
        """
        object.__setattr__(self, "albedo", _color(albedo, "albedo of Specular"))
        _sppm.check_material(to_tuple(self), "Specular")


@dataclass(frozen=True, init=False)
class Dielectric:
    """A smooth boundary between vacuum, outside, and glass or a liquid, inside. It reflects and refracts."""

    albedo: Vector
    """The tint: multiplies both reflected and transmitted light, once per interface; in [0, 1]."""
    ior: float
    """The index of refraction of the inside over that of the outside, from 1 to 100; glass has 1.5."""

    def __init__(self, albedo: VectorLike | float = 1.0, ior: float = 1.5) -> None:
        """Glass with this tint and index of refraction.

        Raises SceneError if a value is out of its range.
        """
        object.__setattr__(self, "albedo", _color(albedo, "albedo of Dielectric"))
        object.__setattr__(self, "ior", single(ior, "ior of Dielectric"))
        _sppm.check_material(to_tuple(self), "Dielectric")


Material: TypeAlias = Diffuse | Specular | Dielectric
"""A material."""


def to_tuple(material: Material) -> MaterialTuple:
    """The material as the extension module takes it."""
    match material:
        case Diffuse():
            return "diffuse", material.albedo, None
        case Specular():
            return "specular", material.albedo, None
        case Dielectric():
            return "dielectric", material.albedo, material.ior


def from_tuple(values: MaterialTuple) -> Material:
    """The material that the extension module gives."""
    kind, albedo, ior = values
    if kind == "dielectric":
        return Dielectric(albedo, 1.5 if ior is None else ior)
    return Diffuse(albedo) if kind == "diffuse" else Specular(albedo)


def is_material(value: object) -> bool:
    """Whether ``value`` is a material."""
    return isinstance(value, (Diffuse, Specular, Dielectric))
