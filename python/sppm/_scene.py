"""Scenes: loaded or built, edited and saved."""

from __future__ import annotations

import builtins
import os
import threading
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, NamedTuple, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from . import _arrays, _sppm
from ._camera import Camera
from ._camera import to_tuple as camera_tuple
from ._errors import InputError, ParticleWarning, SceneError, SceneWarning
from ._materials import Material, from_tuple, is_material
from ._materials import to_tuple as material_tuple
from ._numbers import Vector, VectorLike, single, vector, whole
from ._particles import Frame, Unit, memory
from ._settings import Settings, of_tuple
from ._settings import to_tuple as settings_tuple
from ._style import Bonds, Ends, Number, ParticleSource, Rule, source_of, style_fields

Source: TypeAlias = str | os.PathLike[str]
"""The name of a built-in scene, or the path of a file."""
MaterialLike: TypeAlias = Material | int | Sequence[Material] | npt.NDArray[Any]
"""A material, the index of one of the scene, or for each sphere one of either."""
Floats: TypeAlias = npt.NDArray[np.float32]
"""An array of 32-bit floats."""

_MAX_INDEX = 2**32 - 1


class Scene:
    """A scene: a camera, spheres with materials, a background, and settings that suit it.

    Lengths are in any one unit, the scene's own. Colours are linear RGB. Spheres and materials are counted from 0.

    A scene can be changed at any time, and copied and pickled. A render works on a copy that it takes when it starts.
    Any thread may use a scene.
    """

    __slots__ = ("__weakref__", "_lock", "_native")

    def __init__(
        self,
        camera: Camera | None = None,
        *,
        name: str = "scene",
        background: VectorLike = (0.0, 0.0, 0.0),
        transparent_background: bool = False,
        settings: Settings | None = None,
    ) -> None:
        """An empty scene. ``background`` is the radiance that comes from where there is no sphere; with
        ``transparent_background``, images have alpha in its place.

        Raises SceneError if a channel of ``background`` is negative or not finite.
        """
        self._adopt(_sppm.Scene(_name(name), False))
        self.background = background
        self.transparent_background = transparent_background
        if camera is not None:
            self.camera = camera
        if settings is not None:
            self.settings = settings

    def _adopt(self, native: _sppm.Scene) -> None:
        self._native = native
        # Held while several steps change the scene.
        self._lock = threading.RLock()

    @classmethod
    def _of(cls, native: _sppm.Scene) -> Scene:
        scene = cls.__new__(cls)
        scene._adopt(native)
        return scene

    @classmethod
    def load(cls, source: Source) -> Scene:
        """Loads a built-in scene by its name (:func:`sppm.builtin_scenes` lists them), a ``.toml`` scene file, or a file of
        molecules or particles as :func:`sppm.load_particles` shows it by default.

        Gives a :class:`sppm.SceneWarning` for what one should know of a scene file, such as a lamp that lights nothing. Raises
        SceneError if there is no such scene, or if the file is not valid, with line and column.
        """
        path = os.fspath(source)
        native, notes = _sppm.Scene.load(path)
        tell(notes, SceneWarning if Path(path).suffix.lower() == ".toml" else ParticleWarning)
        return cls._of(native)

    @classmethod
    def parse(cls, text: str, name: str = "scene") -> Scene:
        """Reads the text of a scene file. Messages call it ``name``.

        Raises SceneError if the text is not valid, with line and column.
        """
        if not isinstance(text, str):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"text must be a str, not {type(text).__name__}")
        return cls._of(_sppm.Scene.parse(text, _name(name)))

    # What the scene has.

    @property
    def method(self) -> Literal["sppm", "path"]:
        """The method by which the scene is rendered if none is given: ``"path"``, path tracing, for scenes of
        :func:`sppm.load_particles` as long as all materials are diffuse; else ``"sppm"``, photon mapping."""
        return "path" if self._native.is_stage and self._native.is_matte() else "sppm"

    @property
    def name(self) -> str:
        """The name of the scene."""
        return self._native.name

    @name.setter
    def name(self, name: str) -> None:
        self._native.name = _name(name)

    @property
    def camera(self) -> Camera:
        """The camera. To change it, assign another: ``scene.camera = scene.camera.replace(eye=[0, 1, 9])``."""
        return Camera(*self._native.camera)

    @camera.setter
    def camera(self, camera: Camera) -> None:
        if not isinstance(camera, Camera):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"camera must be a sppm.Camera, not {type(camera).__name__}")
        self._native.camera = camera_tuple(camera)

    @property
    def settings(self) -> Settings:
        """Settings that suit the scene. To change them, assign others: ``scene.settings.replace(width=640)``."""
        return of_tuple(self._native.settings)

    @settings.setter
    def settings(self, settings: Settings) -> None:
        if not isinstance(settings, Settings):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"settings must be sppm.Settings, not {type(settings).__name__}")
        self._native.settings = settings_tuple(settings)

    @property
    def background(self) -> Vector:
        """Radiance that arrives from every direction in which there is no sphere; (0, 0, 0) is black."""
        x, y, z = self._native.background
        return vector((x, y, z), "background", SceneError)

    @background.setter
    def background(self, background: VectorLike) -> None:
        self._native.background = vector(background, "background", SceneError)

    @property
    def transparent_background(self) -> bool:
        """Whether images have :attr:`sppm.Film.alpha` where the camera sees the background. It lights the scene as before."""
        return self._native.transparent_background

    @transparent_background.setter
    def transparent_background(self, is_transparent: bool) -> None:
        if not isinstance(is_transparent, bool):  # pyright: ignore[reportUnnecessaryIsInstance]
            raise TypeError(f"transparent_background must be True or False, not {type(is_transparent).__name__}")
        self._native.transparent_background = is_transparent

    @property
    def materials(self) -> tuple[Material, ...]:
        """The materials, in the order of their indices."""
        return tuple(from_tuple(values) for values in self._native.materials)

    def __len__(self) -> int:
        """The number of spheres."""
        return len(self._native)

    def __repr__(self) -> str:
        """Name and size of the scene."""
        return f"<sppm.Scene {self.name!r}: {len(self)} spheres, {self._native.material_count} materials>"

    # Spheres as arrays.

    @property
    def centers(self) -> Floats:
        """Centres of all spheres at shutter time 0: shape (n, 3), in scene units.

        The array is a read-only copy, as those of the other properties are. To change spheres, assign a whole array.
        """
        return self._native.vectors("center")

    @centers.setter
    def centers(self, centers: npt.ArrayLike) -> None:
        self._native.set_vectors("center", self._each(centers, "centers"))

    @property
    def radii(self) -> Floats:
        """Radii of all spheres: shape (n,), in scene units, above 0."""
        return self._native.radii()

    @radii.setter
    def radii(self, radii: npt.ArrayLike) -> None:
        self._native.set_radii(_arrays.singles(_arrays.spread(radii, len(self), "radii", SceneError)))

    @property
    def emissions(self) -> Floats:
        """Radiance that each sphere emits to both of its sides: shape (n, 3), at least 0; black for most."""
        return self._native.vectors("emission")

    @emissions.setter
    def emissions(self, emissions: npt.ArrayLike) -> None:
        self._native.set_vectors("emission", self._each(emissions, "emissions"))

    @property
    def velocities(self) -> Floats:
        """Displacement of each centre per unit of shutter time: shape (n, 3)."""
        return self._native.vectors("velocity")

    @velocities.setter
    def velocities(self, velocities: npt.ArrayLike) -> None:
        self._native.set_vectors("velocity", self._each(velocities, "velocities"))

    @property
    def material_indices(self) -> npt.NDArray[np.uint32]:
        """The index in ``materials`` of each sphere's material: shape (n,)."""
        return self._native.material_indices()

    @material_indices.setter
    def material_indices(self, indices: npt.ArrayLike) -> None:
        with self._lock:
            known = self._native.material_count
            spread = np.broadcast_to(_indices(indices, len(self), known), (len(self),))
            self._native.set_material_indices(np.require(spread, np.uint32, ["C", "A"]))

    def _each(self, values: npt.ArrayLike, name: str) -> Floats:
        return _arrays.singles(_arrays.spread_rows(values, len(self), name, SceneError))

    # Changes.

    def add_material(self, material: Material) -> int:
        """Adds a material; returns its index, for the argument ``material`` of :meth:`add_spheres`."""
        return self._native.add_material(material_tuple(_material(material)))

    def set_material(self, index: int, material: Material) -> None:
        """Replaces the material at ``index``, for all spheres that have it.

        Raises SceneError if there is none at ``index``.
        """
        index = whole(index, "index", 0, _MAX_INDEX, SceneError)
        self._native.set_material(index, material_tuple(_material(material)))

    def add_spheres(
        self,
        centers: npt.ArrayLike | Any,
        radii: npt.ArrayLike,
        material: MaterialLike,
        *,
        emission: npt.ArrayLike = 0.0,
        velocity: npt.ArrayLike = 0.0,
    ) -> builtins.range:
        """Adds spheres; returns their indices.

        ``centers`` has shape (n, 3), or (3,) for one sphere; or it is anything with ``positions``, such as ``Atoms`` of
        ASE or a group of MDAnalysis. ``radii`` are n positive numbers, or one for all. ``material`` is one for all, or
        a sequence of n materials, or indices of materials of this scene. ``emission`` is radiance, of shape (3,) or
        (n, 3); a sphere that emits is a lamp. ``velocity`` has the same shapes.

        Arrays may be of any layout, byte order and real type. They are rounded to 32 bits while they are copied into
        the scene; nothing else is copied.

        Raises SceneError for wrong shapes and for numbers out of range, and TypeError for anything but real numbers.
        No sphere is added then. Indices in messages are those of the arrays.
        """
        rows = _arrays.rows(_arrays.positions(centers), "centers", SceneError)
        n = len(rows)
        sizes = _arrays.spread(radii, n, "radii", SceneError)
        emissions = _arrays.spread_rows(emission, n, "emission", SceneError)
        velocities = _arrays.spread_rows(velocity, n, "velocity", SceneError)
        with self._lock:
            before, known = len(self), self._native.material_count
            try:
                materials = np.broadcast_to(self._material_indices_of(material, n), (n,))
                self._native.reserve(n)
                for start in range(0, n, _arrays.ROWS_AT_ONCE):
                    part = slice(start, start + _arrays.ROWS_AT_ONCE)
                    columns = (
                        _arrays.singles(rows[part]),
                        _arrays.singles(sizes[part]),
                        np.require(materials[part], np.uint32, ["C", "A"]),
                        _arrays.singles(emissions[part]),
                        _arrays.singles(velocities[part]),
                    )
                    self._native.append(columns, start)
            except BaseException:
                self._native.truncate(before, known)
                raise
            return range(before, before + n)

    def add_particles(
        self,
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
        origin: VectorLike = (0.0, 0.0, 0.0),
        memory_limit: int | None = None,
    ) -> builtins.range:
        """Adds the spheres that :func:`sppm.load_particles` makes of the same arguments; returns their indices.

        ``origin`` is the point of the file that becomes the origin of the scene. Spheres are sorted by their places, and
        bonds and edges of the cell are spheres too, so they are not in the order of the particles.

        Raises what :func:`sppm.load_particles` raises. No sphere is added then.
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
            origin=origin,
        )
        with self._lock:
            start, end, notes = _sppm.add_particles(self._native, source_of(source), fields, memory(memory_limit))
        tell(notes)
        return builtins.range(start, end)

    def _material_indices_of(self, material: MaterialLike, n: int) -> npt.NDArray[np.int64]:
        """The index of each sphere's material, or of all; adds materials that are given as such."""
        if is_material(material):
            return np.array(self.add_material(cast(Material, material)))
        if isinstance(material, (list, tuple)) and any(is_material(one) for one in material):
            if len(material) != n:
                raise SceneError(f"material has {len(material)} materials for {n} spheres")
            index: dict[Material, int] = {}
            for one in cast("Sequence[Material]", material):
                if one not in index:
                    index[one] = self.add_material(one)
            return np.array([index[one] for one in cast("Sequence[Material]", material)], np.int64)
        return _indices(material, n, self._native.material_count)

    def remove_spheres(self, which: npt.ArrayLike | slice) -> None:
        """Removes spheres: those at these indices, or where a mask of shape (n,) is true. Materials stay.

        Raises SceneError if an index is out of range, or if a mask is of another length.
        """
        with self._lock:
            kept = np.ones(len(self), bool)
            chosen = which if isinstance(which, slice) else np.asarray(which)
            if isinstance(chosen, np.ndarray):
                if chosen.dtype.kind == "b" and chosen.shape != kept.shape:
                    raise SceneError(f"the mask has shape {chosen.shape}; it must be {kept.shape}")
                if chosen.dtype.kind != "b":
                    chosen = chosen.astype(np.int64) if chosen.size == 0 else _arrays.indices(chosen, "which", SceneError)
                    _in_range(chosen, len(self), "sphere")
            kept[chosen] = False
            self._native.retain(kept)

    # Checks and files.

    def check(self) -> None:
        """Checks that the scene can be rendered: every number in its range, the lens clear of opaque surfaces, and
        light where the eye is. A render checks that too.

        Raises SceneError with the first flaw.
        """
        self._native.check()

    def to_toml(self) -> str:
        """The scene as the text of a scene file, with its settings. Every number reads back as the same."""
        return self._native.to_text()

    @property
    def digest(self) -> str:
        """The SHA-256 of the scene without its settings, in hexadecimal. Equal scenes have equal digests."""
        return self._native.digest()

    def save(self, path: Source) -> None:
        """Writes a scene file, whole or not at all.

        Raises FileError if it cannot be written, and InputError if its name does not end in ``.toml``.
        """
        path = os.fspath(path)
        if not path.lower().endswith(".toml"):
            raise InputError(f"path {path!r}: a scene file ends in .toml")
        self._native.save(path)

    def export(
        self, format: Literal["mitsuba", "pbrt"], *, time: float | None = None, samples: int = 256
    ) -> Exported:
        """The scene as a file for Mitsuba 3 (XML) or pbrt-v4, at one instant.

        ``time`` is needed if spheres move. ``samples`` are those per pixel that the file asks for.

        Raises SceneError if the format cannot hold the scene.
        """
        open, close = self.camera.shutter
        if time is None:
            if open < close and bool(self.velocities.any()):
                raise InputError(f"time: spheres move; choose an instant from {open} to {close}")
            time = open
        time = single(time, "time")
        if not open <= time <= close:
            raise InputError(f"time: {time} is not while the shutter is open, {open} to {close}")
        text, notes = self._native.export(format, time, whole(samples, "samples", 1, _sppm.MAX_ITERATIONS, InputError))
        return Exported(text, tuple(notes))

    # Copies.

    def copy(self) -> Scene:
        """A copy, which can be changed independently."""
        with self._lock:
            return self._of(self._native.copy())

    def __copy__(self) -> Scene:
        """For the module ``copy``."""
        return self.copy()

    def __deepcopy__(self, memo: dict[int, Any]) -> Scene:
        """For the module ``copy``."""
        return self.copy()

    def __reduce__(self) -> tuple[Any, ...]:
        """For ``pickle``."""
        with self._lock:
            columns = (self.centers, self.radii, self.material_indices, self.emissions, self.velocities)
            background = (self.background, self.transparent_background)
            kept = (self.camera, self.name, background, self.settings, self.materials, columns)
            return _restored, (*kept, self._native.is_stage)

    def __eq__(self, other: object) -> bool:
        """Whether everything is the same but the settings."""
        if not isinstance(other, Scene):
            return NotImplemented
        return self is other or (len(self) == len(other) and self.digest == other.digest)

    __hash__ = None  # type: ignore[assignment]


class Exported(NamedTuple):
    """A scene as a file for another renderer."""

    text: str
    """The text of the file."""
    notes: tuple[str, ...]
    """What its image differs in, a sentence each."""


def _restored(
    camera: Camera,
    name: str,
    background: tuple[Vector, bool],
    settings: Settings,
    materials: tuple[Material, ...],
    columns: tuple[Any, ...],
    is_stage: bool,
) -> Scene:
    """The scene that was pickled."""
    scene = new_scene(_sppm.Scene(name, is_stage))
    scene.camera, scene.settings = camera, settings
    scene.background, scene.transparent_background = background
    for material in materials:
        scene.add_material(material)
    centers, radii, indices, emissions, velocities = columns
    scene.add_spheres(centers, radii, indices, emission=emissions, velocity=velocities)
    return scene


def new_scene(native: _sppm.Scene) -> Scene:
    """The scene that the extension module has made."""
    return Scene._of(native)  # pyright: ignore[reportPrivateUsage]


def tell(notes: list[str], category: type[Warning] = ParticleWarning) -> None:
    """Gives notes as warnings of the caller's caller."""
    for note in notes:
        warnings.warn(note, category, stacklevel=3)


def native(scene: Scene) -> _sppm.Scene:
    """The scene of the extension module."""
    if not isinstance(scene, Scene):  # pyright: ignore[reportUnnecessaryIsInstance]
        raise TypeError(f"scene must be a sppm.Scene, not {type(scene).__name__}; sppm.Scene.load reads one")
    return scene._native  # pyright: ignore[reportPrivateUsage]


def builtin_scenes() -> dict[str, str]:
    """The names of the built-in scenes, with a line about each."""
    return dict(_sppm.builtin_scenes())


def _name(name: object) -> str:
    if not isinstance(name, str):
        raise TypeError(f"name must be a str, not {type(name).__name__}")
    return name


def _material(material: object) -> Material:
    if not is_material(material):
        kind = type(material).__name__
        raise TypeError(f"material must be a sppm.Diffuse, Specular or Dielectric, not {kind}")
    return cast(Material, material)


def _indices(value: object, n: int, known: int) -> npt.NDArray[np.int64]:
    """Indices of materials: one, or one for each of ``n`` spheres."""
    array = np.asarray(value)
    if array.dtype.kind not in "iu" and array.size > 0:
        kind = type(value).__name__ if array.dtype.kind == "O" else f"an array of {array.dtype}"
        raise TypeError(f"material must be a material, or indices of materials of the scene, not {kind}")
    if array.size == 0:
        array = array.astype(np.int64)
    if array.shape not in ((), (n,)):
        raise SceneError(f"material has shape {array.shape}; it must be one for all or ({n},) for each")
    array = _arrays.indices(array, "material", SceneError)
    _in_range(array, known, "material")
    return array


def _in_range(indices: npt.NDArray[np.int64], n: int, what: str) -> None:
    wrong = np.atleast_1d(indices)
    wrong = wrong[(wrong < 0) | (wrong >= n)]
    if wrong.size > 0:
        raise SceneError(f"there is no {what} [{int(wrong[0])}]; the scene has {n}")
