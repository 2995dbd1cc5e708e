"""Scenes that show particles by themselves: camera, lamps and settings follow from the data."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, TypeAlias

from . import _sppm
from ._errors import InputError
from ._numbers import single, whole
from ._particles import Frame, Unit, memory
from ._scene import Scene, new_scene, tell
from ._style import Bonds, Ends, Number, ParticleSource, Rule, source_of, style_fields

View: TypeAlias = (
    Literal["front"]
    | Literal["back"]
    | Literal["left"]
    | Literal["right"]
    | Literal["top"]
    | Literal["bottom"]
    | Literal["iso"]
    | Literal["principal"]
)
"""A direction of the view."""
Light: TypeAlias = Literal["studio"] | Literal["overcast"] | Literal["dark"]
"""The lamps."""

_MAX_SIDE = 2**32 - 1


def load_particles(
    source: ParticleSource,
    *,
    frame: Frame = 0,
    color: str | None = None,
    map: str | None = None,
    range: Ends | None = None,
    radius: Number | None = None,
    scale: float | None = None,
    material: str | None = None,
    style: Rule | Sequence[Rule] = (),
    cut: str | Sequence[str] = (),
    bonds: Bonds | None = None,
    cell: bool = False,
    wrap: bool = False,
    unit: Unit | None = None,
    view: View | None = None,
    zoom: float = 1.0,
    light: Light = "studio",
    ground: bool = False,
    background: str | None = None,
    width: int = 800,
    height: int = 600,
    name: str | None = None,
    memory_limit: int | None = None,
) -> Scene:
    """A scene that shows molecules or particles: camera, lamps, radii, colours and settings follow from the data.

    ``source`` is a file (XYZ, PDB, mmCIF, GRO, LAMMPS dump, GSD, PLY, CSV, NPY or NPZ, by its name), or
    :class:`sppm.Particles`, or ``Atoms`` of ASE, or a universe or a group of MDAnalysis. The scene is the one that the
    command makes of such a file with options of these names; its origin is the centre of the particles. It is rendered
    by path tracing if there are neither mirrors nor glass, unless ``method`` of :func:`sppm.render` says otherwise.

    - ``frame``: the frame of a file: its number, from 0, or ``"last"``.
    - ``color``: ``"jmol"`` or ``"cpk"`` (of elements), ``"file"``, a column such as ``"type"``, ``"chain"``,
      ``"molecule"`` or any property, a name such as ``"red"``, or ``"#rrggbb"``. By default the file's own, or those of
      elements, or of types.
    - ``map``: of a column of numbers: ``"viridis"`` (if not given), ``"cividis"``, ``"inferno"``, ``"magma"``,
      ``"plasma"``, ``"coolwarm"`` or ``"grey"``; ``range``: the values at its ends, such as ``(-1, 2.5)`` or
      ``("5%", "95%")``.
    - ``radius``: ``"vdw"`` or ``"covalent"`` (of elements), ``"touch"`` (half the distance of neighbours), a column, or a
      length in the unit of the positions. By default the file's own, or van der Waals radii, or such that neighbours
      touch. ``scale`` multiplies all radii.
    - ``material``: ``"matte"``, ``"mirror"``, ``"glass"``, ``"glass 1.33"``, ``"light"`` or ``"light 10"``.
    - ``style``: rules for some particles, of which later ones win: ``'type == 2: color=red, material=glass'``, or
      ``{"where": "type == 2", "color": "red", "hide": False}``; one or a sequence.
    - ``cut``: shows only the particles that this selects, such as ``"x < 3"``; one or a sequence.
    - ``bonds``: draws those that the file states (``"file"``), or that distances suggest (``"distance"``); ``cell``
      draws the edges of the cell; ``wrap`` moves particles into it.
    - ``unit``: of lengths, by which radii of elements are scaled, if the file's own is not to be believed.
    - ``view``: ``"front"``, ``"back"``, ``"left"``, ``"right"``, ``"top"``, ``"bottom"``, ``"iso"`` or ``"principal"``;
      ``zoom`` magnifies the image about its centre, from 0.1 to 1000.
    - ``light``: ``"studio"``, ``"overcast"`` or ``"dark"``; ``ground`` puts a ground below; ``background``: ``"white"``,
      ``"grey"``, ``"black"``, ``"#rrggbb"``; or ``"transparent"``, for images with :attr:`sppm.Film.alpha`.
    - ``width``, ``height``: the size of the image in pixels, to which the camera is fitted.
    - ``memory_limit``: in bytes, for reading the file.

    Gives a :class:`sppm.ParticleWarning` for what one should know, such as overlapping balls of glass. Raises FileError if
    the file cannot be read, InputError if an argument does not suit the particles, and TypeError for wrong types.
    """
    fields = style_fields(
        frame=frame,
        unit=unit,
        wrap=wrap,
        cut=cut,
        bonds=bonds,
        cell=cell,
        color=color,
        map=map,
        range=range,
        radius=radius,
        scale=scale,
        material=material,
        style=style,
        origin=(0.0, 0.0, 0.0),
    )
    magnified = single(zoom, "zoom")
    if not 0.1 <= magnified <= 1000.0:
        raise InputError(f"zoom is {magnified}; it must be from 0.1 to 1000")
    for argument, value in (("view", view), ("light", light), ("background", background), ("name", name)):
        if not (isinstance(value, str) or (value is None and argument != "light")):
            raise TypeError(f"{argument} must be a str, not {type(value).__name__}")
    if not isinstance(ground, bool):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"ground must be True or False, not {type(ground).__name__}")
    size = whole(width, "width", 1, _MAX_SIDE, InputError), whole(height, "height", 1, _MAX_SIDE, InputError)
    native, notes = _sppm.stage_particles(
        source_of(source),
        fields,
        {
            "view": view,
            "zoom": magnified,
            "light": light,
            "ground": ground,
            "background": background,
            "size": size,
        },
        name,
        memory(memory_limit),
    )
    tell(notes)
    return new_scene(native)
