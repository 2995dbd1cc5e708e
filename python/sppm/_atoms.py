"""What other packages hold of atoms, as arguments of ``Particles``: ASE's ``Atoms``, and universes and groups of MDAnalysis.

Neither package is imported: their objects are known by what they have.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from ._cell import Cell


def columns_of(atoms: Any) -> dict[str, Any]:
    """The arguments of ``Particles`` for ``atoms``.

    Raises TypeError if they are not known.
    """
    if hasattr(atoms, "get_atomic_numbers") and hasattr(atoms, "arrays"):
        return _of_ase(atoms)
    group = getattr(atoms, "atoms", None)
    if group is not None and hasattr(group, "positions") and hasattr(group, "ix"):
        return _of_mdanalysis(group)
    raise TypeError(
        f"{type(atoms).__name__} holds no atoms; give Atoms of ASE, or a universe or a group of MDAnalysis, or make "
        "sppm.Particles of arrays"
    )


_ASE_TEXTS = {"atomtypes": "names", "residuenames": "residues"}
"""Columns of texts that ASE has of PDB files."""


def _of_ase(atoms: Any) -> dict[str, Any]:
    columns: dict[str, Any] = {"unit": "angstrom", "title": str(atoms.get_chemical_formula())}
    columns["positions"], columns["elements"] = atoms.positions, atoms.numbers
    properties: dict[str, Any] = {}
    for name, array in atoms.arrays.items():
        if name in _ASE_TEXTS:
            columns[_ASE_TEXTS[name]] = [str(text).strip() for text in array]
        elif name == "residuenumbers":
            columns["residue_numbers"] = np.asarray(array, np.int32)
        elif name not in ("numbers", "positions") and array.dtype.kind in "fiub" and array.ndim <= 2:
            properties.update(_components(name, array))
    columns["properties"] = properties
    if atoms.cell.rank == 3:
        columns["cell"] = _cell(np.asarray(atoms.cell), atoms.pbc)
    return columns


def _components(name: str, array: npt.NDArray[Any]) -> dict[str, npt.NDArray[Any]]:
    """A column of numbers, or those of the components of vectors, named as readers name them."""
    numbers = array.astype(np.float64)
    if array.ndim == 1:
        return {name: numbers}
    ends = "xyz" if array.shape[1] == 3 else range(array.shape[1])
    return {f"{name}_{end}": numbers[:, i] for i, end in enumerate(ends)}


_MDANALYSIS = {
    "names": "names",
    "types": "types",
    "resnames": "residues",
    "resids": "residue_numbers",
    "chainIDs": "chains",
    "molnums": "molecules",
    "ids": "ids",
    "radii": "radii",
}
"""Attributes of groups of MDAnalysis, and the columns that they are."""
_PROPERTIES = ("charges", "masses", "tempfactors", "occupancies")
"""Attributes of groups that are columns of numbers."""


def _of_mdanalysis(group: Any) -> dict[str, Any]:
    columns: dict[str, Any] = {"unit": "angstrom", "positions": group.positions}
    for attribute, column in _MDANALYSIS.items():
        found = _attribute(group, attribute)
        if found is not None:
            columns[column] = np.asarray(found)
    if "chains" not in columns and _attribute(group, "segids") is not None:
        columns["chains"] = np.asarray(group.segids)
    elements = _attribute(group, "elements")
    if elements is not None and any(elements):
        columns["elements"] = np.array([str(symbol).strip().capitalize() for symbol in elements], np.str_)
    found = {name: _attribute(group, name) for name in _PROPERTIES}
    columns["properties"] = {name: np.asarray(values) for name, values in found.items() if values is not None}
    columns["bonds"] = _bonds(group)
    if group.dimensions is not None and all(group.dimensions[:3] > 0):
        columns["cell"] = _cell(_vectors(*(float(number) for number in group.dimensions)), (True, True, True))
    return columns


def _attribute(group: Any, name: str) -> Any:
    """An attribute that a topology may lack."""
    try:
        return getattr(group, name)
    except (AttributeError, ValueError):  # NoDataError is one of both
        return None


def _bonds(group: Any) -> npt.NDArray[np.int64]:
    """The bonds between atoms of the group, by their places in it."""
    bonds = _attribute(group, "bonds")
    if bonds is None or len(bonds) == 0:
        return np.empty((0, 2), np.int64)
    place = np.full(int(group.universe.atoms.n_atoms), -1, np.int64)
    place[group.ix] = np.arange(len(group))
    pairs = place[np.asarray(bonds.indices)]
    return pairs[(pairs >= 0).all(axis=1)]


def _vectors(a: float, b: float, c: float, *degrees: float) -> npt.NDArray[np.float64]:
    """The vectors of a cell by lengths and angles: the first along x, the second in the plane of x and y."""
    # Right angles are exact.
    alpha, beta, gamma = (0.0 if angle == 90.0 else float(np.cos(np.radians(angle))) for angle in degrees)
    height = (1.0 - gamma * gamma) ** 0.5
    x, y = beta, (alpha - beta * gamma) / height
    z = max(0.0, 1.0 - x * x - y * y) ** 0.5
    return np.array([[a, 0.0, 0.0], [b * gamma, b * height, 0.0], [c * x, c * y, c * z]])


def _cell(vectors: npt.NDArray[Any], periodic: Any) -> Cell:
    rows: Any = tuple(tuple(float(x) for x in row) for row in vectors)
    repeats: Any = tuple(bool(along) for along in periodic)
    return Cell(rows, periodic=repeats)
