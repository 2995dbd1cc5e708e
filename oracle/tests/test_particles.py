"""Compares the readers of particle files with ASE, and with the `gsd` package, on files that these write.

The readers are run through `importers/examples/dump.rs`, which prints what they find.
"""

from __future__ import annotations

import gzip
import json
import subprocess
from pathlib import Path
from types import SimpleNamespace

import ase.io
import gsd.hoomd
import numpy as np
import pytest
from ase import Atoms
from ase.build import bulk, fcc111, molecule
from ase.calculators.singlepoint import SinglePointCalculator
from ase.data import chemical_symbols
from ase.spacegroup import Spacegroup, crystal

from oracle import sppm

# Formats write so many decimals; half a unit of the last, with a little more for the number in between.
DECIMALS = {"xyz": 0.51e-10, "extxyz": 0.51e-8, "proteindatabank": 0.51e-3, "gromacs": 0.51e-2, "cif": 1e-3}
# Of a calculation in double precision on numbers of size 100.
ROUNDING = 1e-10
SUFFIX = {"xyz": "xyz", "extxyz": "xyz", "proteindatabank": "pdb", "gromacs": "gro", "cif": "cif"}


def dump(path: Path, frame: int | str = 0) -> SimpleNamespace:
    """What our readers find in a file: columns by name, cell, bonds, labels."""
    program = sppm.binary().parent / "examples" / "dump"
    if not program.exists():
        raise sppm.OracleError(f"there is no {program}; run cargo build --package importers --example dump")
    done = subprocess.run([program, path, str(frame)], capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    line, _, rest = done.stdout.partition(b"\n")
    header = json.loads(line)
    columns, at, count = {}, 0, header["count"]
    for name, kind in header["columns"]:
        width = 3 if name in ("positions", "colors") else 1
        column = np.frombuffer(rest, kind, count * width, at)
        columns[name] = column.reshape(count, width) if width > 1 else column
        at += column.nbytes
    assert at == len(rest)
    for name, names in header["labels"].items():
        columns[name] = np.array(names, dtype=object)[columns[name]]
    return SimpleNamespace(**header | {"columns": columns, "positions": columns["positions"]})


def symbols(read: SimpleNamespace) -> list[str]:
    return [chemical_symbols[number] for number in read.columns["elements"]]


def structures() -> dict[str, Atoms]:
    rng = np.random.default_rng(1)
    water = molecule("H2O")
    salt = bulk("NaCl", "rocksalt", a=5.64, cubic=True).repeat(2)
    hexagonal = bulk("ZnO", "wurtzite", a=3.25, c=5.2).repeat((3, 2, 2))
    slab = fcc111("Pt", (3, 3, 4), vacuum=6.0)
    slab.pbc = (True, True, False)
    far = molecule("CH3CH2OH")
    far.positions += [812.5, -633.25, 47.125]
    cloud = Atoms("C200Au57", rng.uniform(-30, 30, (257, 3)))
    slanted = Atoms("Si8", rng.uniform(0, 1, (8, 3)) @ (cell := np.array([[7, 0, 0], [1.5, 6, 0], [-2, 1, 8]])), cell=cell, pbc=True)
    return {"water": water, "salt": salt, "hexagonal": hexagonal, "slab": slab, "far": far, "cloud": cloud, "slanted": slanted}


STRUCTURES = structures()


def assert_same_cell(read: SimpleNamespace, atoms: Atoms, tolerance: float) -> None:
    if atoms.cell.rank < 3:
        assert read.cell is None
        return
    np.testing.assert_allclose(read.cell["vectors"], atoms.cell.array, rtol=0, atol=tolerance)
    assert [bool(side) for side in read.cell["periodic"]] == list(atoms.pbc)


@pytest.mark.parametrize("name", STRUCTURES)
@pytest.mark.parametrize("form", ["xyz", "extxyz", "proteindatabank", "gromacs"])
def test_files_that_ase_writes(form: str, name: str, tmp_path: Path) -> None:
    atoms, path = STRUCTURES[name], tmp_path / f"a.{SUFFIX[form]}"
    ase.io.write(path, atoms, format=form)
    there, read = ase.io.read(path, format=form), dump(path)
    scale = {"Nanometre": 10.0, "Angstrom": 1.0}[read.unit]
    np.testing.assert_allclose(read.positions * scale, there.positions, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(read.positions * scale, atoms.positions, rtol=0, atol=DECIMALS[form])
    assert symbols(read) == list(atoms.symbols)
    if form == "extxyz":
        assert_same_cell(read, atoms, DECIMALS[form])
    elif form != "xyz" and there.cell.rank == 3:
        vectors = np.array(read.cell["vectors"]) * scale
        np.testing.assert_allclose(vectors, there.cell.array, rtol=0, atol=1e-9)


@pytest.mark.parametrize("form", ["xyz", "extxyz", "proteindatabank"])
def test_frames_of_trajectories(form: str, tmp_path: Path) -> None:
    frames = [STRUCTURES["salt"].copy() for _ in range(5)]
    for number, atoms in enumerate(frames):
        atoms.positions += 0.1 * number
    path = tmp_path / f"a.{SUFFIX[form]}"
    ase.io.write(path, frames, format=form)
    for number in range(5):
        read = dump(path, number)
        assert read.frames == 5
        np.testing.assert_allclose(read.positions, frames[number].positions, rtol=0, atol=DECIMALS[form])
    np.testing.assert_array_equal(dump(path, "last").positions, dump(path, 4).positions)
    packed = path.with_suffix(path.suffix + ".gz")
    packed.write_bytes(gzip.compress(path.read_bytes()))
    np.testing.assert_array_equal(dump(packed, 3).positions, dump(path, 3).positions)


def test_columns_of_extended_xyz(tmp_path: Path) -> None:
    atoms = STRUCTURES["slab"].copy()
    rng = np.random.default_rng(2)
    atoms.arrays["q"] = rng.normal(size=len(atoms))
    atoms.arrays["is_fixed"] = rng.integers(0, 2, len(atoms)).astype(bool)
    atoms.calc = SinglePointCalculator(atoms, forces=rng.normal(size=(len(atoms), 3)), energy=-1.0)
    atoms.info["note"] = 'with "quotes" and = signs'
    path = tmp_path / "a.extxyz"
    ase.io.write(path, atoms)
    there, read = ase.io.read(path), dump(path)
    np.testing.assert_allclose(read.columns["q"], there.arrays["q"], rtol=1e-7)
    np.testing.assert_array_equal(read.columns["is_fixed"], there.arrays["is_fixed"])
    forces = np.stack([read.columns[f"forces_{axis}"] for axis in "xyz"], axis=1)
    np.testing.assert_allclose(forces, there.get_forces(), rtol=1e-6)
    assert_same_cell(read, atoms, DECIMALS["extxyz"])


@pytest.mark.parametrize("lattice", ['"5 0 0 1 6 0 2 3 7"', "[[5, 0, 0], [1, 6, 0], [2, 3, 7]]"])
def test_notations_of_the_lattice(lattice: str, tmp_path: Path) -> None:
    """ASE reads the first alone; in the second, rows are vectors by the specification of the format."""
    path = tmp_path / "a.xyz"
    path.write_text(f"1\nLattice={lattice} pbc=[T, F, T] Properties=species:S:1:pos:R:3\nSi 1 2 3\n")
    there = Atoms("Si", [(1, 2, 3)], cell=[[5, 0, 0], [1, 6, 0], [2, 3, 7]], pbc=(True, False, True))
    if lattice.startswith('"'):
        there = ase.io.read(path, format="extxyz")
    assert_same_cell(dump(path), there, ROUNDING)


@pytest.mark.parametrize("name", ["salt", "hexagonal", "slanted"])
def test_cif_that_ase_writes(name: str, tmp_path: Path) -> None:
    path = tmp_path / "a.cif"
    ase.io.write(path, STRUCTURES[name])
    there, read = ase.io.read(path), dump(path)
    np.testing.assert_allclose(read.cell["vectors"], there.cell.array, rtol=0, atol=ROUNDING)
    np.testing.assert_allclose(read.positions, there.positions, rtol=0, atol=ROUNDING)
    assert symbols(read) == list(there.symbols)


CRYSTALS = {
    "diamond": ("C", [(0, 0, 0)], 227, [3.57, 3.57, 3.57, 90, 90, 90]),
    "rutile": (["Ti", "O"], [(0, 0, 0), (0.3056, 0.3056, 0)], 136, [4.594, 4.594, 2.959, 90, 90, 90]),
    "quartz": (["Si", "O"], [(0.4697, 0, 0), (0.4135, 0.2669, 0.1191)], 154, [4.916, 4.916, 5.405, 90, 90, 120]),
    "monoclinic": (["Zr", "O"], [(0.275, 0.039, 0.208), (0.07, 0.33, 0.345)], 14, [5.145, 5.208, 5.311, 90, 99.2, 90]),
}


@pytest.mark.parametrize("name", CRYSTALS)
def test_crystals_by_their_symmetry(name: str, tmp_path: Path) -> None:
    species, sites, number, parameters = CRYSTALS[name]
    group = Spacegroup(number)
    whole = crystal(species, sites, spacegroup=number, cellpar=parameters)
    keys = ["length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma"]
    lines = ["data_a", *(f"_cell_{key} {value}(2)" for key, value in zip(keys, parameters, strict=True))]
    lines += ["loop_", "_symmetry_equiv_pos_as_xyz"]
    for rotation, shift in group.get_symop():
        rows = []
        for row, constant in zip(rotation, shift, strict=True):
            terms = [{1: "+", -1: "-"}[value] + axis for value, axis in zip(row, "xyz", strict=True) if value]
            rows.append("".join(terms) + (f"+{round(constant * 12)}/12" if constant else ""))
        lines.append(f"'{','.join(rows)}'")
    lines += ["loop_", "_atom_site_label", "_atom_site_fract_x", "_atom_site_fract_y", "_atom_site_fract_z"]
    names = [species] if isinstance(species, str) else species
    lines += [f"{kind}{at + 1} {x} {y} {z}" for at, (kind, (x, y, z)) in enumerate(zip(names, sites, strict=True))]
    path = tmp_path / "a.cif"
    path.write_text("\n".join(lines) + "\n")
    read = dump(path)
    np.testing.assert_allclose(read.cell["vectors"], whole.cell.array, rtol=0, atol=ROUNDING)

    def places(positions: np.ndarray, kinds: list[str]) -> list[tuple]:
        shares = np.linalg.solve(whole.cell.array.T, positions.T).T % 1.0
        return sorted((kind, *(np.round(share, 5) % 1.0)) for kind, share in zip(kinds, shares, strict=True))

    assert places(read.positions, symbols(read)) == places(whole.positions, list(whole.symbols))


def lammps(style: str, positions: np.ndarray, cell: np.ndarray, origin: np.ndarray, order: np.ndarray) -> str:
    """A dump as LAMMPS writes it, in a restricted triclinic box or an orthogonal one."""
    (lx, _, _), (xy, ly, _), (xz, yz, lz) = cell.tolist()
    (x, y, z) = origin.tolist()
    tilted = bool(xy or xz or yz)
    low = [x + min(0, xy, xz, xy + xz), y + min(0, yz), z]
    high = [x + lx + max(0, xy, xz, xy + xz), y + ly + max(0, yz), z + lz]
    tilts = [xy, xz, yz]
    lines = ["ITEM: TIMESTEP", "7", "ITEM: NUMBER OF ATOMS", str(len(positions))]
    lines.append("ITEM: BOX BOUNDS" + (" xy xz yz" if tilted else "") + " pp pp ff")
    for axis in range(3):
        lines.append(f"{low[axis]!r} {high[axis]!r}" + (f" {tilts[axis]!r}" if tilted else ""))
    lines.append(f"ITEM: ATOMS id type {' '.join(axis + style for axis in 'xyz')} ")
    shown = np.linalg.solve(cell.T, (positions - origin).T).T if "s" in style else positions
    lines += [f"{at + 1} {at % 3 + 1} " + " ".join(repr(float(value)) for value in shown[at]) + " " for at in order]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("cell", [np.diag([7.0, 8.0, 9.0]), np.array([[7, 0, 0], [1.5, 6, 0], [-2, -1, 8]])])
@pytest.mark.parametrize("style", ["", "s", "u", "su"])
def test_lammps_dumps(style: str, cell: np.ndarray, tmp_path: Path) -> None:
    rng, origin = np.random.default_rng(3), np.array([-1.0, 2.0, 0.5])
    positions = rng.uniform(0, 1, (50, 3)) @ cell + origin
    path = tmp_path / "a.lammpstrj"
    path.write_text(lammps(style, positions, cell, origin, rng.permutation(50)) * 2)
    read = dump(path, 1)
    assert read.frames == 2
    np.testing.assert_allclose(read.positions, positions, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(read.columns["ids"], np.arange(1, 51))
    assert list(read.columns["types"]) == [str(at % 3 + 1) for at in range(50)]
    np.testing.assert_allclose(read.cell["vectors"], cell, rtol=0, atol=1e-12)
    np.testing.assert_allclose(read.cell["origin"], origin, rtol=0, atol=1e-12)
    assert read.cell["periodic"] == [1, 1, 0]
    # ASE places the origin of the cell at 0 where coordinates are scaled.
    there = ase.io.read(path, index=0, format="lammps-dump-text")
    np.testing.assert_allclose(there.cell.array, read.cell["vectors"], rtol=0, atol=ROUNDING)
    if "s" not in style:
        np.testing.assert_allclose(there.positions, read.positions, rtol=0, atol=ROUNDING)


def test_gsd_that_hoomd_writes(tmp_path: Path) -> None:
    rng, path = np.random.default_rng(4), tmp_path / "a.gsd"
    with gsd.hoomd.open(path, "w") as file:
        for number in range(4):
            frame = gsd.hoomd.Frame()
            frame.configuration.step = number
            frame.configuration.box = [10, 11, 12, 0.1, -0.2, 0.3]
            frame.particles.N = 20 if number < 3 else 7
            frame.particles.position = rng.uniform(-5, 5, (frame.particles.N, 3))
            if number in (0, 3):
                frame.particles.types = ["polymer", "solvent"]
                frame.particles.typeid = rng.integers(0, 2, frame.particles.N)
                frame.particles.charge = rng.normal(size=frame.particles.N)
            if number == 0:
                frame.particles.diameter = rng.uniform(0.5, 2, 20)
                frame.bonds.N = 3
                frame.bonds.group = [[0, 1], [5, 4], [2, 3]]
            file.append(frame)
    with gsd.hoomd.open(path) as file:
        for number, frame in enumerate(file):
            read = dump(path, number)
            assert read.frames == 4
            np.testing.assert_array_equal(read.positions.astype("f4"), frame.particles.position)
            np.testing.assert_array_equal(read.columns["radii"], frame.particles.diameter / 2)
            np.testing.assert_array_equal(read.columns["types"], np.array(frame.particles.types)[frame.particles.typeid])
            if "charge" in read.columns:
                np.testing.assert_array_equal(read.columns["charge"], frame.particles.charge)
            np.testing.assert_allclose(read.cell["vectors"], gsd_vectors(frame), rtol=1e-6)
            np.testing.assert_allclose(read.cell["origin"], -gsd_vectors(frame).sum(0) / 2, rtol=1e-6)
            assert {tuple(bond) for bond in read.bonds} == {tuple(sorted(map(int, bond))) for bond in frame.bonds.group}


def gsd_vectors(frame: gsd.hoomd.Frame) -> np.ndarray:
    lx, ly, lz, xy, xz, yz = frame.configuration.box
    return np.array([[lx, 0, 0], [xy * ly, ly, 0], [xz * lz, yz * lz, lz]], dtype="f8")


@pytest.mark.parametrize("kind", ["<f4", ">f4", "<f8", ">f8", "<i4", ">i2"])
@pytest.mark.parametrize("order", "CF")
@pytest.mark.parametrize("width", [3, 4])
def test_arrays(kind: str, order: str, width: int, tmp_path: Path) -> None:
    values = np.random.default_rng(5).uniform(0, 100, (1000, width)).astype(kind)
    np.save(tmp_path / "a.npy", np.array(values, order=order))
    read = dump(tmp_path / "a.npy")
    np.testing.assert_array_equal(read.positions, values[:, :3])
    if width == 4:
        np.testing.assert_array_equal(read.columns["radii"], values[:, 3].astype("f4"))


def test_structured_arrays(tmp_path: Path) -> None:
    rng = np.random.default_rng(6)
    kind = np.dtype([("tag", "u1"), ("pos", ">f8", 3), ("species", "U2"), ("rgb", "u1", 3), ("q", "f4"), ("v", "f4", (2, 2))], align=True)
    rows = np.zeros(30, kind)
    rows["pos"], rows["q"] = rng.normal(size=(30, 3)), rng.normal(size=30)
    rows["species"], rows["rgb"] = rng.choice(["O", "Fe"], 30), rng.integers(0, 256, (30, 3))
    rows["v"] = rng.normal(size=(30, 2, 2))
    np.save(tmp_path / "a.npy", rows)
    read = dump(tmp_path / "a.npy")
    np.testing.assert_array_equal(read.positions, rows["pos"])
    assert symbols(read) == list(rows["species"])
    np.testing.assert_allclose(read.columns["colors"], rows["rgb"] / 255, rtol=1e-6)
    np.testing.assert_array_equal(read.columns["q"], rows["q"])
    np.testing.assert_array_equal(read.columns["v_3"], rows["v"][:, 1, 1])
    plain = np.zeros(5, [("x", "f4"), ("y", "f4"), ("z", "f4"), ("r", "f4")])
    plain["r"] = 2.0
    np.save(tmp_path / "b.npy", plain)
    np.testing.assert_array_equal(dump(tmp_path / "b.npy").columns["radii"], plain["r"])


@pytest.mark.parametrize("save", [np.savez, np.savez_compressed])
def test_archives(save, tmp_path: Path) -> None:
    rng = np.random.default_rng(7)
    arrays = {
        "colors": rng.uniform(0, 1, (40, 3)),
        "positions": np.asfortranarray(rng.normal(size=(40, 3))),
        "radii": rng.uniform(0, 1, 40).astype("f4"),
        "types": rng.integers(0, 3, 40),
        "atomic_numbers": rng.integers(1, 100, 40).astype("u1"),
        "speed": rng.normal(size=40).astype("f4"),
        "cell": np.array([[4.0, 1, 2], [0, 5, 3], [0, 0, 6]]),
        "pbc": np.array([True, False, True]),
        "unrelated": np.arange(7),
    }
    save(tmp_path / "a.npz", **{name: array for name, array in arrays.items() if name != "unrelated"})
    read = dump(tmp_path / "a.npz")
    np.testing.assert_array_equal(read.positions, arrays["positions"])
    for name in ("radii", "speed"):
        np.testing.assert_array_equal(read.columns[name], arrays[name])
    np.testing.assert_array_equal(read.columns["colors"], arrays["colors"].astype("f4"))
    np.testing.assert_array_equal(read.columns["elements"], arrays["atomic_numbers"])
    assert list(read.columns["types"]) == [str(kind) for kind in arrays["types"]]
    np.testing.assert_array_equal(read.cell["vectors"], arrays["cell"])
    assert read.cell["periodic"] == [1, 0, 1]


@pytest.mark.parametrize("separator", [",", ";", "\t", " "])
def test_tables(separator: str, tmp_path: Path) -> None:
    values = np.random.default_rng(8).normal(size=(50, 5))
    path = tmp_path / "a.csv"
    header = separator.join(["x", "y", "z", "speed", "mass"])
    np.savetxt(path, values, delimiter=separator, header=header)
    read = dump(path)
    np.testing.assert_array_equal(read.positions, np.loadtxt(path, delimiter=separator)[:, :3])
    np.testing.assert_allclose(read.columns["mass"], values[:, 4], rtol=1e-6)


def test_elements_of_a_protein(tmp_path: Path) -> None:
    """Elements by the columns of the atom's name, where ASE is told them."""
    lines = [
        "ATOM      1  N   MET A   1      38.198  19.582  28.104  1.00  0.00           N",
        "ATOM      2  CA  MET A   1      38.198  18.582  28.104  1.00  0.00           C",
        "ATOM      3  SD  MET A   1      38.198  17.582  28.104  1.00  0.00           S",
        "ATOM      4 HG11 VAL A   2      38.198  16.582  28.104  1.00  0.00           H",
        "HETATM    5 CA    CA A   3      38.198  15.582  28.104  1.00  0.00          CA",
        "HETATM    6 FE   HEM A   4      38.198  14.582  28.104  1.00  0.00          FE",
        "HETATM    7  O   HOH A   5      38.198  13.582  28.104  1.00  0.00           O",
    ]
    whole, bare = tmp_path / "a.pdb", tmp_path / "b.pdb"
    whole.write_text("\n".join(lines))
    bare.write_text("\n".join(line[:66] for line in lines))
    there = ase.io.read(whole)
    assert symbols(dump(whole)) == symbols(dump(bare)) == list(there.symbols)
