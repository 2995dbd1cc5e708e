"""Molecules and particles as arrays: from files, from arrays, from ASE and MDAnalysis."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from typing import Any, Literal, TypeAlias, cast

import numpy as np
import numpy.typing as npt

from . import _arrays, _sppm
from ._atoms import columns_of
from ._cell import Cell
from ._errors import InputError
from ._numbers import whole
from ._tuples import CellTuple, LabelsTuple, ParticleColumns

Path: TypeAlias = str | os.PathLike[str]
"""The path of a file."""
Frame: TypeAlias = int | Literal["last"]
"""A frame of a file: its number, from 0, or the last one."""
Unit: TypeAlias = Literal["angstrom"] | Literal["nanometre"] | Literal["metre"]
"""A unit of length."""
Texts: TypeAlias = Sequence[str] | npt.NDArray[Any]
"""A text per particle."""

_MOST_TEXTS = 1 << 16
_NO_LIMIT = 2**64 - 1
_NUMBERS: dict[str, tuple[type[np.generic], int]] = {
    "radii": (np.float32, 1),
    "colors": (np.float32, 2),
    "residue_numbers": (np.int32, 1),
    "molecules": (np.uint32, 1),
    "ids": (np.uint64, 1),
}
"""The types of columns of numbers, and how many sides they have."""
_TEXTS = ("types", "names", "residues", "chains")
"""The columns of texts."""


class Particles:
    """The particles of one frame, as columns: what files of molecules and particles hold, or arrays of your own.

    They do not change: arrays are read-only, and :meth:`replace` makes others. What is not known is ``None``. Styles
    name columns ``x``, ``y``, ``z``, ``radius``, ``element``, ``type``, ``name``, ``residue``, ``resid``, ``chain``,
    ``molecule``, ``id``, and properties by their names.
    """

    __slots__ = ("__weakref__", "_columns")

    def __init__(
        self,
        positions: npt.ArrayLike,
        *,
        elements: npt.ArrayLike | None = None,
        types: Texts | None = None,
        radii: npt.ArrayLike | None = None,
        colors: npt.ArrayLike | None = None,
        names: Texts | None = None,
        residues: Texts | None = None,
        residue_numbers: npt.ArrayLike | None = None,
        chains: Texts | None = None,
        molecules: npt.ArrayLike | None = None,
        ids: npt.ArrayLike | None = None,
        properties: Mapping[str, npt.ArrayLike] | None = None,
        bonds: npt.ArrayLike | None = None,
        cell: Cell | npt.ArrayLike | None = None,
        unit: Unit | None = None,
        title: str = "",
    ) -> None:
        """Particles of your own: ``positions`` has shape (n, 3); the other columns have n rows.

        ``elements`` are atomic numbers or symbols, ``colors`` of shape (n, 3) in [0, 1] as screens show them (sRGB),
        ``properties`` columns of numbers by name, ``bonds`` pairs of indices. ``cell`` is a :class:`sppm.Cell`, or its
        vectors, of shape (3, 3), or the lengths of its edges, of shape (3,).

        Raises InputError for wrong shapes and values out of range, and TypeError for wrong types.
        """
        rows = _arrays.rows(positions, "positions", InputError)
        places = _frozen(np.array(rows, np.float64, order="C"))
        given = dict(
            elements=elements,
            types=types,
            radii=radii,
            colors=colors,
            names=names,
            residues=residues,
            residue_numbers=residue_numbers,
            chains=chains,
            molecules=molecules,
            ids=ids,
            properties=properties,
            bonds=bonds,
            cell=cell,
            unit=unit,
            title=title,
        )
        converted = {name: _converted(name, value) for name, value in given.items()}
        self._adopt(cast(ParticleColumns, {"positions": places, **converted}))

    def _adopt(self, columns: ParticleColumns) -> None:
        _sppm.check_particles(columns)
        self._columns = columns

    @classmethod
    def _of(cls, columns: ParticleColumns) -> Particles:
        particles = cls.__new__(cls)
        particles._adopt(columns)
        return particles

    @classmethod
    def load(
        cls,
        path: Path,
        *,
        frame: Frame = 0,
        properties: Sequence[str] | None = None,
        memory_limit: int | None = None,
    ) -> Particles:
        """Reads a frame of a file: XYZ, PDB, mmCIF, GRO, LAMMPS dump, GSD, PLY, CSV, NPY or NPZ, by its name; text may be
        compressed by gzip.

        ``properties`` names the columns of numbers that have no field of their own; by default all are read.
        ``memory_limit`` is in bytes. Raises FileError if the file cannot be read, or does not fit the limit.
        """
        names = None if properties is None else _strings(properties, "properties")
        return cls._of(_sppm.read_particles(os.fspath(path), frame_text(frame), names, memory(memory_limit)))

    @classmethod
    def of(cls, atoms: Any) -> Particles:
        """The particles of ``Atoms`` of ASE, or of a universe or a group of MDAnalysis: positions, elements, names,
        residues, bonds, cell, and arrays of numbers as properties. Lengths are in angstrom.

        Raises TypeError for anything else.
        """
        if isinstance(atoms, Particles):
            return atoms
        return cls(**columns_of(atoms))

    # Columns.

    @property
    def positions(self) -> npt.NDArray[np.float64]:
        """Positions: shape (n, 3)."""
        return self._columns["positions"]

    @property
    def elements(self) -> npt.NDArray[np.uint8] | None:
        """Atomic numbers, 1 to 118, or 0 if not known: shape (n,)."""
        return self._columns["elements"]

    @property
    def radii(self) -> npt.NDArray[np.float32] | None:
        """Radii: shape (n,), in the unit of the positions."""
        return self._columns["radii"]

    @property
    def colors(self) -> npt.NDArray[np.float32] | None:
        """Red, green and blue as screens show them (sRGB), 0 to 1: shape (n, 3)."""
        return self._columns["colors"]

    @property
    def types(self) -> npt.NDArray[np.str_] | None:
        """Types, as texts: shape (n,)."""
        return _spread(self._columns["types"])

    @property
    def names(self) -> npt.NDArray[np.str_] | None:
        """Names of atoms, such as ``CA``: shape (n,)."""
        return _spread(self._columns["names"])

    @property
    def residues(self) -> npt.NDArray[np.str_] | None:
        """Names of residues, such as ``ALA``: shape (n,)."""
        return _spread(self._columns["residues"])

    @property
    def residue_numbers(self) -> npt.NDArray[np.int32] | None:
        """Numbers of residues: shape (n,)."""
        return self._columns["residue_numbers"]

    @property
    def chains(self) -> npt.NDArray[np.str_] | None:
        """Names of chains: shape (n,)."""
        return _spread(self._columns["chains"])

    @property
    def molecules(self) -> npt.NDArray[np.uint32] | None:
        """Numbers of molecules: shape (n,)."""
        return self._columns["molecules"]

    @property
    def ids(self) -> npt.NDArray[np.uint64] | None:
        """Ids or serial numbers: shape (n,)."""
        return self._columns["ids"]

    @property
    def properties(self) -> dict[str, npt.NDArray[np.float32]]:
        """The other columns of numbers by name, each of shape (n,). Vectors are ``forces_x`` and so on."""
        return dict(self._columns["properties"])

    @property
    def bonds(self) -> npt.NDArray[np.uint32]:
        """Bonds: pairs of indices, of shape (m, 2), the lower first, sorted."""
        return self._columns["bonds"]

    @property
    def cell(self) -> Cell | None:
        """The cell, if there is one."""
        given = self._columns["cell"]
        if given is None:
            return None
        origin, vectors, periodic = given
        a, b, c = (cast("tuple[float, float, float]", tuple(vector)) for vector in vectors)
        x, y, z = origin
        repeats = cast("tuple[bool, bool, bool]", tuple(periodic))
        return Cell((a, b, c), (x, y, z), repeats)

    @property
    def unit(self) -> Unit | None:
        """The unit of lengths; ``None`` if it is not known."""
        return cast("Unit | None", self._columns["unit"])

    @property
    def title(self) -> str:
        """The title or comment of the frame; empty if there is none."""
        return self._columns["title"]

    def replace(self, **changes: Any) -> Particles:
        """The same particles but for the columns given, by the names of the constructor's arguments; ``None`` removes one.

        ``particles.replace(properties={**particles.properties, "charge": charges})`` adds a property.
        """
        columns = dict(self._columns)
        for name, value in changes.items():
            if name not in columns:
                raise TypeError(f"there is no column {name!r}; columns are {', '.join(columns)}")
            if name == "positions":
                columns[name] = _frozen(np.array(_arrays.rows(value, name, InputError), np.float64, order="C"))
            else:
                columns[name] = _converted(name, value)
        return self._of(cast(ParticleColumns, columns))

    def __len__(self) -> int:
        """The number of particles."""
        return len(self.positions)

    def __repr__(self) -> str:
        """How many there are, and what is known of them."""
        known = [name for name in ("elements", *_TEXTS, *_NUMBERS) if cast(Any, self._columns)[name] is not None]
        known += [name for name, _ in self._columns["properties"]]
        having = f" with {', '.join(known)}" if known else ""
        return f"<sppm.Particles: {len(self)}{having}>"

    def __copy__(self) -> Particles:
        """The particles themselves, as they do not change."""
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Particles:
        """The particles themselves, as they do not change."""
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """For ``pickle``."""
        return _restored, (self._columns,)


def _restored(columns: ParticleColumns) -> Particles:
    """The particles that were pickled."""
    for name in ("positions", "bonds", "elements", *_NUMBERS):
        column = cast(Any, columns)[name]
        if column is not None:
            column.flags.writeable = False
    for _, values in columns["properties"]:
        values.flags.writeable = False
    return Particles._of(columns)  # pyright: ignore[reportPrivateUsage]


def columns(particles: Particles) -> ParticleColumns:
    """The columns as the extension module takes them."""
    return particles._columns  # pyright: ignore[reportPrivateUsage]


def frame_count(path: Path) -> int:
    """The number of frames of a file of molecules or particles.

    Raises FileError if it cannot be read.
    """
    return _sppm.count_frames(os.fspath(path))


def frame_text(frame: object) -> str:
    """A frame as scene files state it."""
    if frame == "last":
        return "last"
    if isinstance(frame, str):
        raise InputError(f'frame {frame!r}: it must be the number of a frame, from 0, or "last"')
    return str(whole(frame, "frame", 0, 2**63 - 1, InputError))


def memory(limit: int | None) -> int:
    """A limit in bytes; a number larger than any if there is none."""
    return _NO_LIMIT if limit is None else whole(limit, "memory_limit", 1, 2**60, InputError)


def _frozen(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    array.flags.writeable = False
    return array


def _converted(name: str, value: Any) -> Any:
    """The column ``name`` as the extension module takes it."""
    special: dict[str, Callable[[Any], Any]] = {
        "elements": _elements,
        "properties": _properties,
        "bonds": _bonds,
        "cell": _cell,
        "unit": _unit,
        "title": _title,
    }
    if name in special:
        return special[name](value)
    if value is None:
        return None
    return _labels(value, name) if name in _TEXTS else _numbers(value, name, *_NUMBERS[name])


def _numbers(value: object, name: str, kind: type[np.generic], sides: int) -> npt.NDArray[Any]:
    array = _arrays.real(value, name, InputError)
    is_right = array.ndim == 1 if sides == 1 else array.ndim == 2 and array.shape[1] == 3
    if not is_right:
        raise InputError(f"{name} has shape {array.shape}; it must be {'(n,)' if sides == 1 else '(n, 3)'}")
    if np.issubdtype(kind, np.integer):
        if array.dtype.kind not in "iu" and array.size > 0:
            raise TypeError(f"{name} is an array of {array.dtype}; give whole numbers")
        limits = np.iinfo(cast(Any, kind))
        if array.size > 0 and not limits.min <= int(array.min()) <= int(array.max()) <= limits.max:
            raise InputError(f"{name} has numbers from {array.min()} to {array.max()}; they must fit {limits.dtype}")
    with np.errstate(over="ignore", under="ignore"):
        return _frozen(np.array(array, kind, order="C"))


def _elements(value: object) -> npt.NDArray[np.uint8] | None:
    if value is None:
        return None
    array = np.asarray(value)
    if array.dtype.kind in "UO" and array.ndim == 1:
        symbols, index = _index(array, "elements")
        numbers = np.array(_sppm.atomic_numbers(symbols), np.uint8)
        return _frozen(numbers[index])
    return _numbers(array, "elements", np.uint8, 1)


def _index(value: object, name: str) -> tuple[list[str], npt.NDArray[np.int64]]:
    """The different texts, and the index of its text for each particle."""
    array = np.asarray(value)
    if array.ndim != 1:
        raise InputError(f"{name} has shape {array.shape}; it must be (n,)")
    if array.dtype.kind in "iu":
        array = array.astype(np.str_)
    if array.dtype.kind == "O" and all(isinstance(text, str) for text in array):
        array = array.astype(np.str_)
    if array.dtype.kind != "U" and array.size > 0:
        raise TypeError(f"{name} is an array of {array.dtype}; give texts")
    texts, index = np.unique(array, return_inverse=True)
    return [str(text) for text in texts], index.reshape(-1).astype(np.int64)


def _labels(value: object, name: str) -> LabelsTuple:
    texts, index = _index(value, name)
    if len(texts) > _MOST_TEXTS:
        raise InputError(f"{name} has {len(texts)} different texts; at most {_MOST_TEXTS} can be told apart")
    return texts, _frozen(index.astype(np.uint16))


def _spread(labels: LabelsTuple | None) -> npt.NDArray[np.str_] | None:
    if labels is None:
        return None
    texts, index = labels
    return _frozen(np.array(texts, np.str_)[index]) if texts else _frozen(np.empty(len(index), np.str_))


def _properties(value: object) -> list[tuple[str, npt.NDArray[np.float32]]]:
    if value is None:
        return []
    if not isinstance(value, Mapping):
        raise TypeError(f"properties must be a mapping from names to columns, not {type(value).__name__}")
    given = cast("Mapping[object, object]", value)
    return [(name, _numbers(given[name], f"properties[{name!r}]", np.float32, 1)) for name in _strings(given, "properties")]


def _bonds(value: object) -> npt.NDArray[np.uint32]:
    if value is None:
        return _frozen(np.empty((0, 2), np.uint32))
    array = np.asarray(value)
    if array.size == 0:
        array = np.empty((0, 2), np.int64)
    if array.ndim != 2 or array.shape[1] != 2:
        raise InputError(f"bonds has shape {array.shape}; it must be (m, 2)")
    array = _arrays.indices(array, "bonds", InputError)
    if array.size > 0 and not 0 <= int(array.min()) <= int(array.max()) < 2**32:
        raise InputError(f"bonds has indices from {array.min()} to {array.max()}; they count from 0")
    return _frozen(np.unique(np.sort(array, axis=1), axis=0).astype(np.uint32))


def _cell(value: object) -> CellTuple | None:
    if value is None:
        return None
    given = value if isinstance(value, Cell) else Cell(cast(Any, value))
    array = _arrays.real(given.vectors, "cell", InputError)
    if array.shape == (3,):
        array = np.diag(array)
    corner = _arrays.real(given.origin, "origin of cell", InputError)
    if array.shape != (3, 3) or corner.shape != (3,) or len(given.periodic) != 3:
        raise InputError(f"cell has vectors of shape {array.shape}; it must be (3, 3), or (3,) for the lengths of its edges")
    repeats = tuple(bool(along) for along in given.periodic)
    return cast("CellTuple", (corner.tolist(), array.tolist(), repeats))


def _unit(value: object) -> str | None:
    if not (value is None or isinstance(value, str)):
        raise TypeError(f"unit must be a name, not {type(value).__name__}")
    return value


def _title(value: object) -> str:
    if not isinstance(value, str):
        raise TypeError(f"title must be a str, not {type(value).__name__}")
    return value


def _strings(value: object, name: str) -> list[str]:
    if isinstance(value, str):
        raise TypeError(f"{name} must be several names, not one str")
    all = list(cast("Sequence[object]", value))
    for one in all:
        if not isinstance(one, str):
            raise TypeError(f"{name} must be names, not {type(one).__name__}")
    return cast("list[str]", all)
