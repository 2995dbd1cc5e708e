"""The settings of a render, by their names in scene files."""

from __future__ import annotations

from dataclasses import dataclass, fields
from typing import Any, Literal, TypeAlias, cast

from . import _sppm
from ._errors import InputError
from ._numbers import single, whole
from ._tuples import SettingsTuple

Filter: TypeAlias = Literal["box"] | Literal["gaussian"] | Literal["mitchell"]
"""How a pixel averages the light around it."""

RadiusSchedule: TypeAlias = Literal["per-pixel"] | Literal["global"]
"""How the search radius shrinks."""

_MAX_U32 = 2**32 - 1
_MAX_SEED = 2**64 - 1


@dataclass(frozen=True)
class Settings:
    """The settings of a render. Together with the scene they determine every bit of the image.

    Raises InputError if a value is out of its range, and TypeError if it is of a wrong type.
    """

    width: int = 512
    """Width of the image in pixels."""
    height: int = 384
    """Height of the image in pixels."""
    iterations: int = 6
    """Iterations of photon mapping; for the path tracer, samples per pixel."""
    photons_per_iteration: int = 200_000
    """Photons that leave the lights in each iteration."""
    max_depth: int = 5
    """Most segments of a path from the eye to a diffuse surface, and again from there to a light."""
    initial_radius: float = 2.0
    """Radius of the density estimate in the first iteration, in scene units."""
    seed: int = 1
    """Seed of all random numbers, from 0 to 2**64 - 1."""
    filter: Filter = "box"
    """How a pixel averages the light around it."""
    radius_schedule: RadiusSchedule = "per-pixel"
    """How the search radius shrinks: in each pixel by the photons counted, or in all alike by the number of the
    iteration."""
    radius_pilots: int = 0
    """Iterations of each of the eight small renders by which the first radius of every pixel is chosen, from
    ``initial_radius`` down to an eighth of it. If 0, all pixels begin with ``initial_radius``."""
    radius_clearance: float = 0.0
    """While a pixel has gathered no photon, its radius is at most so many times as far as the nearest other sphere is from
    what it sees, but no less than an eighth of ``initial_radius``, and a third where that sphere is a wall around it. If 0,
    radii have no such limit."""
    light_samples: int = 1
    """Shadow rays from the first diffuse surface of each path from the eye, from 1 to 16."""
    glint_samples: int = 1
    """Rays by which a pixel sees lamps if it shows the rim of one, or if its path first meets a mirror or glass, from 1 to 64. If 1,
    the path alone sees them."""

    def __post_init__(self) -> None:
        """Checks all values."""
        counts = ("width", "height", "iterations", "photons_per_iteration", "max_depth")
        for name in (*counts, "light_samples", "glint_samples"):
            object.__setattr__(self, name, whole(getattr(self, name), name, 1, _MAX_U32, InputError))
        pilots = whole(self.radius_pilots, "radius_pilots", 0, _MAX_U32, InputError)
        object.__setattr__(self, "radius_pilots", pilots)
        object.__setattr__(self, "seed", whole(self.seed, "seed", 0, _MAX_SEED, InputError))
        for name in ("initial_radius", "radius_clearance"):
            object.__setattr__(self, name, single(getattr(self, name), name))
        for name in ("filter", "radius_schedule"):
            if not isinstance(getattr(self, name), str):
                raise TypeError(f"{name} must be a name, not {type(getattr(self, name)).__name__}")
        _sppm.check_settings(to_tuple(self))

    def replace(self, **changes: Any) -> Settings:
        """The same settings but for the values given, by name. ``None`` leaves a value as it is."""
        names = [field.name for field in fields(self)]
        for name in changes:
            if name not in names:
                raise TypeError(f"there is no setting {name!r}; settings are {', '.join(names)}")
        given = {name: value for name, value in changes.items() if value is not None}
        return Settings(**{**{name: getattr(self, name) for name in names}, **given})


def to_tuple(settings: Settings) -> SettingsTuple:
    """The settings as the extension module takes them."""
    return (
        settings.width,
        settings.height,
        settings.iterations,
        settings.photons_per_iteration,
        settings.max_depth,
        settings.initial_radius,
        settings.seed,
        settings.filter,
        settings.radius_schedule,
        settings.radius_pilots,
        settings.radius_clearance,
        (settings.light_samples, settings.glint_samples),
    )


def of_tuple(values: SettingsTuple) -> Settings:
    """Settings as the extension module gives them."""
    *others, (light_samples, glint_samples) = values
    return Settings(*cast("Any", (*others, light_samples, glint_samples)))
