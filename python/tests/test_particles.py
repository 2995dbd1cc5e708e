"""Molecules and particles: the scenes that the command makes of files, columns as arrays, ASE and MDAnalysis."""

from __future__ import annotations

import copy
import itertools
import json
import pickle
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import sppm

FIXTURES = Path(__file__).parents[2] / "fixtures/particles"
WATER, COPPER, MELT, HEAP = (str(FIXTURES / name) for name in ("water.pdb", "copper.xyz", "melt.dump", "heap.csv"))
SMALL = {"width": 40, "height": 30}

CASES: list[tuple[str, dict[str, object], list[str]]] = [
    (WATER, {}, []),
    (WATER, {"bonds": "file", "cell": True}, ["--bonds=file", "--cell"]),
    (WATER, {"radius": "covalent", "scale": 0.5, "unit": "angstrom"}, ["--ball-radius=covalent", "--ball-scale=0.5", "--unit=angstrom"]),
    (
        COPPER,
        {"color": "neighbours", "radius": 1.0, "style": "neighbours == 12: scale=0.35", "cell": True},
        ["--color=neighbours", "--ball-radius=1.0", "--style=neighbours == 12: scale=0.35", "--cell"],
    ),
    (
        COPPER,
        {"color": "z", "map": "coolwarm", "range": (1, 9.5), "cut": ["x < 9", "y > 3"], "zoom": 1.5},
        ["--color=z", "--map=coolwarm", "--color-range=1..9.5", "--cut=x < 9", "--cut=y > 3", "--zoom=1.5"],
    ),
    (
        COPPER,
        {"color": "x", "range": ("5%", "95%"), "view": "front", "light": "overcast"},
        ["--color=x", "--color-range=5%..95%", "--view=front", "--light=overcast"],
    ),
    (MELT, {"color": "molecule", "wrap": True, "cell": True, "background": "grey"}, ["--color=molecule", "--wrap", "--cell", "--background=grey"]),
    (MELT, {"frame": "last", "view": "top", "light": "dark", "material": "light 3"}, ["--frame=last", "--view=top", "--light=dark", "--material=light 3"]),
    (HEAP, {"color": "radius", "ground": True, "view": "iso"}, ["--color=radius", "--ground", "--view=iso"]),
    (WATER, {"color": "red", "style": 'element == "H": color=blue'}, ["--color=red", '--style=element == "H": color=blue']),
    (
        HEAP,
        {"style": [{"where": "radius > 1", "material": "mirror"}, {"where": "z > 2", "hide": True}]},
        ["--style=radius > 1: material=mirror", "--style=z > 2: hide", "-n2", "--photons=3000"],
    ),
]


@pytest.mark.parametrize(("file", "arguments", "options"), CASES, ids=[f"{Path(f).stem}-{'-'.join(a)}" for f, a, _ in CASES])
@pytest.mark.filterwarnings("ignore::sppm.ParticleWarning")
def test_scenes_are_those_of_the_command(file, arguments, options, tmp_path: Path, command) -> None:
    scene = sppm.load_particles(file, **arguments, **SMALL)
    number = 2 if scene.method == "sppm" else 3
    more = [f"-n{number}", "--quiet"] if "-n2" not in options else ["--quiet"]
    photons = {"photons_per_iteration": 3000} if number == 2 else {}
    for name in ("image.png", "image.exr"):
        command("render", file, "-o", tmp_path / name, "--width=40", "--height=30", *options, *more)
    film = sppm.render(scene, iterations=number, **photons)
    # The files differ in how they state the scene: ours has the balls, as they can be changed.
    assert sppm.compare(film, tmp_path / "image.exr").identical
    film.save(tmp_path / "ours.png")
    assert sppm.compare(tmp_path / "ours.png", tmp_path / "image.png").identical
    theirs = json.loads(command("info", tmp_path / "image.exr", "--json"))
    assert theirs["scene_digest"] == film.metadata["scene_digest"] == scene.digest
    for key in ("method", "settings", "scene"):
        assert theirs[key] == film.metadata[key], key


def test_load_shows_particles_as_the_command_does() -> None:
    scene = sppm.Scene.load(WATER)
    assert scene == sppm.load_particles(WATER) and scene.name == "water"
    assert scene.settings == sppm.load_particles(WATER).settings
    assert scene.method == "path"
    assert sppm.Scene.load("cornell").method == "sppm"


def test_changes_of_balls_from_a_file_are_saved(tmp_path: Path) -> None:
    scene_file = tmp_path / "water.toml"
    scene_file.write_text(f'[stage]\n[[particles]]\nfile = "{WATER}"\n')
    scene = sppm.Scene.load(scene_file)
    radii = scene.radii.copy()
    radii[7] = 9.5
    scene.radii = radii
    scene.save(tmp_path / "changed.toml")
    assert np.array_equal(sppm.Scene.load(tmp_path / "changed.toml").radii, radii)


def test_the_method_follows_the_materials() -> None:
    scene = sppm.load_particles(HEAP, **SMALL)
    for twin in (scene, scene.copy(), pickle.loads(pickle.dumps(scene))):
        assert twin.method == "path"
        twin.add_spheres([0, 0, 50], 1, sppm.Dielectric())
        assert twin.method == "sppm"
    film = sppm.render(sppm.load_particles(HEAP, **SMALL), iterations=1)
    assert film.metadata["method"] == "path" and film.radius is None
    film = sppm.render(sppm.load_particles(HEAP, **SMALL), iterations=1, method="sppm", photons_per_iteration=1000)
    assert film.metadata["method"] == "sppm"


def test_the_background_has_the_colour_asked_for(tmp_path: Path) -> None:
    film = sppm.render(sppm.load_particles(HEAP, **SMALL, background="#336699"), iterations=1)
    for shown in (film, pickle.loads(pickle.dumps(film))):
        assert np.abs(shown.to_srgb()[0, 0].astype(int) - (0x33, 0x66, 0x99)).max() <= 1
    assert np.abs(film.to_srgb(tone="agx")[0, 0].astype(int) - (0x33, 0x66, 0x99)).max() > 5
    film.save(tmp_path / "a.png")
    assert sppm.info(tmp_path / "a.png")["tone"] == "clamp"
    film.save(tmp_path / "a.exr")


def test_a_render_of_the_command_is_repeated(tmp_path: Path, command) -> None:
    command("render", WATER, "-o", tmp_path / "a.exr", "--width=40", "--height=30", "-n1", "--quiet")
    right = sppm.Film.load(tmp_path / "a.exr")
    with pytest.raises(sppm.FileError, match="water.pdb: there is no such file"):
        sppm.Render.like(tmp_path / "a.exr")
    scene = sppm.load_particles(WATER, **SMALL)
    assert sppm.compare(sppm.Render.like(tmp_path / "a.exr", scene).result(), right).identical


def test_files_are_columns() -> None:
    water = sppm.Particles.load(WATER)
    assert len(water) == 648 and water.positions.shape == (648, 3) and water.positions.dtype == np.float64
    assert water.positions[0].tolist() == [1.987, 1.640, 1.378]
    assert water.elements is not None and water.elements[:3].tolist() == [8, 1, 1]
    assert water.names is not None and water.names[:3].tolist() == ["O", "H1", "H2"]
    assert water.residues is not None and set(water.residues) == {"HOH"}
    assert water.chains is not None and water.residue_numbers is not None and water.ids is not None
    assert water.residue_numbers[3] == 2 and water.ids[-1] == 648
    assert water.bonds.shape[1] == 2 and (water.bonds[:, 0] < water.bonds[:, 1]).all()
    assert water.cell is not None and water.cell.vectors[0] == (18.7, 0.0, 0.0) and water.cell.periodic == (True,) * 3
    assert water.unit == "angstrom" and "648 with elements" in repr(water)
    copper = sppm.Particles.load(COPPER)
    assert set(copper.properties) == {"neighbours"} and copper.properties["neighbours"].max() >= 12
    assert sppm.Particles.load(COPPER, properties=[]).properties == {}
    heap = sppm.Particles.load(HEAP)
    assert heap.radii is not None and heap.elements is None and heap.unit is None and heap.cell is None
    for array in (water.positions, water.elements, water.names, water.bonds, heap.radii):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0
    assert sppm.frame_count(MELT) >= 1 == sppm.frame_count(HEAP)


@pytest.mark.parametrize("file", [WATER, COPPER, MELT, HEAP], ids=lambda file: Path(file).stem)
def test_columns_give_the_scene_of_the_file(file: str) -> None:
    particles = sppm.Particles.load(file)
    right = sppm.load_particles(file)
    # A file of macromolecules has the cell of a crystal, which is not what it shows; an array is taken at its word.
    view = {"view": "principal"} if file == WATER else {}
    again = sppm.load_particles(particles, name=right.name, **view)
    assert again == right
    for twin in (pickle.loads(pickle.dumps(particles)), copy.copy(particles), copy.deepcopy(particles)):
        assert sppm.load_particles(twin, name=right.name, **view) == right
        assert not twin.positions.flags.writeable


def test_cells_begin_where_the_file_says_and_repeat_where_it_says(tmp_path: Path) -> None:
    file = tmp_path / "a.dump"
    bounds = "ITEM: BOX BOUNDS pp ff pp\n-2 3\n1 5\n0.5 8\n"
    file.write_text(f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\n{bounds}ITEM: ATOMS id type x y z\n1 1 0 2 4\n")
    right = sppm.Cell(((5.0, 0.0, 0.0), (0.0, 4.0, 0.0), (0.0, 0.0, 7.5)), (-2.0, 1.0, 0.5), (True, False, True))
    particles = sppm.Particles.load(file)
    for twin in (particles, particles.replace(title="again"), pickle.loads(pickle.dumps(particles))):
        assert twin.cell == right


@pytest.mark.parametrize("number", [1.2345678, 0.1 + 0.2, 123456.7, np.float32(0.3), 3, 2.3456789e-6])
def test_numbers_of_styles_keep_their_digits(number: float) -> None:
    balls = sppm.Particles([[0, 0, 0], [1e6, 0, 0]], radii=[1, 1])
    for style in ({"radius": number}, {"scale": number}, {"style": {"where": "x > 1", "radius": number}}):
        scene = sppm.Scene()
        scene.add_particles(balls, **style)
        assert scene.radii.max(initial=0, where=scene.radii != 1) == np.float32(number)


def test_columns_of_my_own() -> None:
    random = np.random.default_rng(1)
    places = random.uniform(0, 9, (50, 3))
    charges = random.normal(size=50)
    particles = sppm.Particles(
        places.astype(">f4"),
        elements=["O", "H"] * 25,
        names=np.array(["a", "bb"] * 25),
        properties={"charge": charges},
        bonds=[(3, 1), (1, 3), (0, 2)],
        cell=[9, 9, 9],
        unit="angstrom",
        title="mine",
    )
    assert particles.bonds.tolist() == [[0, 2], [1, 3]] and particles.title == "mine"
    assert particles.elements is not None and particles.elements[:2].tolist() == [8, 1]
    assert particles.cell == sppm.Cell(((9.0, 0.0, 0.0), (0.0, 9.0, 0.0), (0.0, 0.0, 9.0)))
    assert particles.names is not None and particles.names[1] == "bb"
    scene = sppm.load_particles(particles, color="charge", map="coolwarm", style='name == "bb": hide')
    only = sppm.load_particles(particles, color="charge", map="coolwarm", cut='name == "a"')
    assert len(scene) == 25 + 3 and len(only) == len(scene)
    changed = particles.replace(elements=None, radii=np.full(50, 0.3))
    assert changed.elements is None and particles.radii is None
    assert changed.radii is not None and changed.radii[0] == np.float32(0.3)
    given = places.copy()
    kept = sppm.Particles(given)
    given[:] = 0
    assert kept.positions.max() > 1


def test_without_a_unit_distances_tell_it() -> None:
    water = sppm.Particles.load(WATER).replace(cell=None)
    angstrom = sppm.load_particles(water, radius="covalent").radii
    for unit, length in (("angstrom", 1.0), ("nanometre", 0.1), ("metre", 1e-10)):
        moved = water.replace(positions=water.positions * length)
        guessed, told = (sppm.load_particles(moved.replace(unit=some), radius="covalent") for some in (None, unit))
        assert guessed == told, unit
        assert guessed.radii.min() == pytest.approx(length * angstrom.min()), unit


def test_texts_of_each_column_are_its_own() -> None:
    columns = {"name": "names", "type": "types", "residue": "residues", "chain": "chains"}
    # The text x stands at another particle in each column.
    texts = {column: ["x" if i == k else "y" for i in range(4)] for k, column in enumerate(columns.values())}
    radii = np.float32([0.1, 0.2, 0.3, 0.4])
    particles = sppm.Particles(np.arange(12.0).reshape(4, 3), radii=radii, **texts)
    for k, key in enumerate(columns):
        scene = sppm.load_particles(particles, cut=f'{key} == "x"')
        assert set(scene.radii) & set(radii) == {radii[k]}, key


def test_particles_join_a_scene() -> None:
    scene = sppm.Scene(sppm.Camera.look_at([9, -30, 9], [9, 9, 9], up=[0, 0, 1]), background=[1, 1, 1])
    scene.add_spheres([0, 0, -1000], 990, sppm.Diffuse(0.5))
    added = scene.add_particles(WATER, radius="covalent", origin=(1, 2, 3))
    assert (added.start, len(added)) == (1, 648) and len(scene) == 649
    particles = sppm.Particles.load(WATER)
    right = np.sort((particles.positions - (1, 2, 3)).astype(np.float32)[:, 2])
    assert np.array_equal(np.sort(scene.centers[1:, 2]), right)
    assert (scene.material_indices[1:] > 0).all() and set(scene.radii[1:]) == {np.float32(0.31), np.float32(0.66)}
    more = scene.add_particles(particles, cut='element == "O"', color="red")
    assert len(more) == 216 and len(scene) == 649 + 216
    scene.check()
    before = scene.digest
    with pytest.raises(sppm.InputError, match="no particle is left"):
        scene.add_particles(WATER, cut="x > 1000")
    assert scene.digest == before


def test_frames_are_those_asked_for(tmp_path: Path) -> None:
    file = tmp_path / "moving.xyz"
    file.write_text("".join(f"1\nframe {k}\nO {k} 0 0\n" for k in range(3)))
    assert sppm.frame_count(file) == 3
    for frame, x in ((0, 0.0), (1, 1.0), ("last", 2.0)):
        particles = sppm.Particles.load(file, frame=frame)
        assert particles.positions.tolist() == [[x, 0.0, 0.0]] and particles.title == f"frame {int(x)}"
        scene = sppm.Scene()
        scene.add_particles(file, frame=frame)
        assert scene.centers.tolist() == [[x, 0.0, 0.0]]
        assert sppm.load_particles(file, frame=frame) == sppm.load_particles(particles, name="moving")


def test_particles_join_a_scene_as_they_are_shown_by_themselves() -> None:
    """Whatever is asked of them: each option changes the spheres, to those of a scene that shows them alone."""
    places = [[0.0, 0.0, 0.0], [1.1, 0.0, 0.0], [0.0, 1.2, 0.0], [12.0, 5.0, 3.0]]
    particles = sppm.Particles(
        places, elements=["C", "O", "H", "C"], properties={"q": [0, 1, 2, 5]}, bonds=[[0, 1]], cell=[9, 9, 9], unit="angstrom"
    )
    by_q: dict[str, object] = {"color": "q"}
    for base, option in (
        ({}, {"color": "red"}),
        (by_q, {"map": "magma"}),
        (by_q, {"range": (0, 2)}),
        ({}, {"radius": 0.25}),
        ({}, {"scale": 0.5}),
        ({}, {"material": "mirror"}),
        ({}, {"style": "q > 1: color=red"}),
        ({}, {"cut": "q < 3"}),
        ({}, {"bonds": "file"}),
        ({}, {"cell": True}),
        ({}, {"wrap": True}),
        ({}, {"unit": "nanometre"}),
    ):
        joined = []
        for arguments in (base, {**base, **option}):
            scene, alone = sppm.Scene(), sppm.load_particles(particles, **arguments)
            added = scene.add_particles(particles, **arguments)
            # The lamps are the first there.
            assert len(added) == len(alone) - 3 and np.array_equal(scene.radii, alone.radii[3:]), arguments
            colors = [[one.materials[i] for i in one.material_indices[-len(added) :]] for one in (scene, alone)]
            assert colors[0] == colors[1], arguments
            joined.append(scene)
        assert joined[0] != joined[1], option


def test_no_more_texts_are_taken_than_can_be_told_apart() -> None:
    texts = [str(i) for i in range(65_537)]
    most = sppm.Particles(np.zeros((65_536, 3)), names=texts[:-1])
    assert most.names is not None and most.names[[0, -1]].tolist() == ["0", "65535"]
    with pytest.raises(sppm.InputError, match="names has 65537 different texts; at most 65536 can be told apart"):
        sppm.Particles(np.zeros((65_537, 3)), names=texts)


def test_notes_are_warnings() -> None:
    with pytest.warns(sppm.ParticleWarning, match="no bonds to draw") as caught:
        sppm.load_particles(HEAP, bonds="file")
    assert caught[0].filename == __file__


def test_atoms_of_ase(tmp_path: Path) -> None:
    build = pytest.importorskip("ase.build")
    atoms = build.bulk("NaCl", "rocksalt", a=5.64, cubic=True).repeat(2)
    atoms.set_initial_charges([1.0, -1.0] * 32)
    atoms.new_array("forces", np.arange(192.0).reshape(64, 3))
    particles = sppm.Particles.of(atoms)
    assert particles.elements is not None and particles.elements[:2].tolist() == [11, 17]
    assert particles.cell is not None and particles.cell.vectors[2] == (0.0, 0.0, 11.28)
    assert {"initial_charges", "forces_x", "forces_y", "forces_z"} <= set(particles.properties)
    assert particles.unit == "angstrom"
    scene = sppm.load_particles(atoms, radius="covalent", cell=True, bonds="distance", style='element == "Na": color=red')
    assert len(scene) > 64 + 100
    coloured = sppm.load_particles(atoms, color="forces_z")
    assert len(coloured.materials) > 10
    # As if it came through a file.
    from ase.io import write

    path = tmp_path / "a.xyz"
    write(path, atoms, format="extxyz", columns=["symbols", "positions"])
    assert sppm.load_particles(path, name="a") == sppm.load_particles(atoms, name="a")
    alone = build.molecule("H2O")
    assert sppm.Particles.of(alone).cell is None
    # A slab does not repeat through its vacuum.
    for along in itertools.product((False, True), repeat=3):
        atoms.pbc = along
        cell = sppm.Particles.of(atoms).cell
        assert cell is not None and cell.periodic == along
    assert len(sppm.load_particles(alone, bonds="distance")) > 3


def test_columns_of_a_file_that_ase_has_read_are_those_of_the_file() -> None:
    read = pytest.importorskip("ase.io").read
    ours, theirs = sppm.Particles.load(WATER), sppm.Particles.of(read(WATER))
    for name in ("positions", "elements", "names", "residues", "residue_numbers"):
        assert np.array_equal(getattr(ours, name), getattr(theirs, name)), name
    assert set(theirs.properties) == {"occupancy", "bfactor"} and theirs.cell == ours.cell


class Group:
    """What the package looks at of a group of MDAnalysis: water and a stray atom, of which the group lacks the first."""

    positions = np.float32([[0.7, 0.5, 0], [-0.7, 0.5, 0], [5, 5, 5]])
    ix = np.array([1, 2, 3])
    names = np.array(["H1", "H2", "X"], object)
    resnames = np.array(["SOL", "SOL", "ION"], object)
    resids = np.array([1, 1, 2])
    segids = np.array(["A", "A", "B"], object)
    elements = np.array(["H", "H", ""], object)
    masses = np.array([1.0, 1.0, 30.0])
    dimensions = np.float32([10, 10, 10, 90, 90, 60])
    universe = SimpleNamespace(atoms=SimpleNamespace(n_atoms=4))

    class Bonds:
        indices = np.array([[0, 1], [1, 2], [2, 3]])

        def __len__(self) -> int:
            return 3

    bonds = Bonds()

    def __len__(self) -> int:
        return 3

    @property
    def atoms(self) -> Group:
        return self

    @property
    def charges(self) -> None:
        raise AttributeError("no charges here")


def test_groups_of_mdanalysis() -> None:
    particles = sppm.Particles.of(Group())
    assert particles.elements is not None and particles.elements.tolist() == [1, 1, 0]
    assert particles.bonds.tolist() == [[0, 1], [1, 2]]
    assert list(particles.properties) == ["masses"] and particles.chains is not None and particles.chains[2] == "B"
    assert particles.cell is not None
    assert np.allclose(particles.cell.vectors, [[10, 0, 0], [5, 75**0.5, 0], [0, 0, 10]], atol=1e-6)
    assert len(sppm.load_particles(Group(), radius=0.4, bonds="file", color="residue")) > 3 + 3


def test_every_attribute_of_a_group_is_a_column() -> None:
    class Full(Group):
        types = np.array(["a", "b", "a"], object)
        chainIDs = np.array(["X", "Y", "X"], object)
        molnums = np.array([0, 1, 2])
        ids = np.array([5, 6, 7])
        radii = np.array([1.0, 2.0, 3.0])
        charges = np.array([0.5, 0.25, -1.0])  # type: ignore[assignment]
        tempfactors = np.array([9.0, 8.0, 7.0])
        occupancies = np.array([1.0, 0.5, 1.0])

    right = {
        "names": ["H1", "H2", "X"],
        "types": ["a", "b", "a"],
        "residues": ["SOL", "SOL", "ION"],
        "residue_numbers": [1, 1, 2],
        # Not the segments, where chains have names.
        "chains": ["X", "Y", "X"],
        "molecules": [0, 1, 2],
        "ids": [5, 6, 7],
        "radii": [1.0, 2.0, 3.0],
    }
    particles = sppm.Particles.of(Full())
    assert {name: getattr(particles, name).tolist() for name in right} == right
    properties = {name: column.tolist() for name, column in particles.properties.items()}
    assert properties == {
        "charges": [0.5, 0.25, -1.0], "masses": [1.0, 1.0, 30.0], "tempfactors": [9.0, 8.0, 7.0], "occupancies": [1.0, 0.5, 1.0]
    }  # fmt: skip


def test_groups_in_no_box_have_no_cell() -> None:
    for nothing in (None, np.zeros(6, np.float32)):

        class Free(Group):
            dimensions = nothing

        assert sppm.Particles.of(Free()).cell is None


def test_cells_of_mdanalysis_have_their_lengths_and_angles() -> None:
    class Leaning(Group):
        dimensions = np.float32([10, 12, 14, 70, 100, 80])

    cell = sppm.Particles.of(Leaning()).cell
    assert cell is not None
    a, b, c = np.array(cell.vectors)
    assert np.allclose([np.linalg.norm(v) for v in (a, b, c)], [10, 12, 14])
    angles = [np.degrees(np.arccos(np.dot(v, w) / np.linalg.norm(v) / np.linalg.norm(w))) for v, w in ((b, c), (a, c), (a, b))]
    assert np.allclose(angles, [70, 100, 80])
    assert (a[1], a[2], b[2]) == (0, 0, 0) and b[1] > 0 and c[2] > 0


def test_particles_are_wrapped_into_a_cell_where_it_begins() -> None:
    vectors = ((10.0, 0.0, 0.0), (0.0, 10.0, 0.0), (0.0, 0.0, 10.0))
    # At 1, 6 and 2 of a cell that begins at 0, and at 11, 6 and 12 of one that begins at 5.
    for start, width in ((0.0, 5.0), (5.0, 6.0)):
        cell = sppm.Cell(vectors, origin=(start, 0.0, 0.0))
        particles = sppm.Particles([[1, 1, 1], [6, 1, 1], [12, 1, 1]], radii=np.full(3, 0.25), cell=cell)
        scene = sppm.load_particles(particles, wrap=True)
        assert np.ptp(scene.centers[scene.radii == 0.25, 0]) == width


def test_ends_of_ranges_keep_their_digits() -> None:
    """The range of all values is what they are mapped by without one."""
    values = 1234567.0 + np.arange(3.0)
    particles = sppm.Particles(np.arange(9.0).reshape(3, 3), radii=np.full(3, 0.3), properties={"time": values})
    usual = sppm.load_particles(particles, color="time")
    assert sppm.load_particles(particles, color="time", range=(values[0], values[-1])) == usual
    assert sppm.load_particles(particles, color="time", range=("0%", values[-1])) == usual
    assert sppm.load_particles(particles, color="time", range=(values[0], values[-1] + 1)) != usual


def test_real_groups_of_mdanalysis() -> None:
    mda = pytest.importorskip("MDAnalysis")
    universe = mda.Universe(WATER)
    whole = sppm.Particles.of(universe)
    right = sppm.Particles.load(WATER)
    assert np.allclose(whole.positions, right.positions, atol=1e-5)
    assert np.array_equal(whole.elements, right.elements) and np.array_equal(whole.names, right.names)
    assert np.array_equal(whole.bonds, right.bonds)
    assert whole.cell is not None and right.cell is not None
    assert np.allclose(whole.cell.vectors, right.cell.vectors)
    oxygens = universe.select_atoms("element O")
    assert len(sppm.load_particles(oxygens, color="resid")) == 216 + 3
