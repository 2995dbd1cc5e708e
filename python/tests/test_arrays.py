"""Arrays of any layout come in, with at most one copy."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import sppm

N = 70_000
"""More rows than are converted at a time."""
RANDOM = np.random.default_rng(0)
CENTERS = RANDOM.uniform(-100, 100, (N, 3)).astype(np.float32)
RADII = RANDOM.uniform(0.1, 2, N).astype(np.float32)


def misaligned(array: np.ndarray) -> np.ndarray:
    """The same values, one byte off any alignment."""
    raw = np.empty(array.nbytes + 1, np.uint8)
    shifted = raw[1:].view(array.dtype).reshape(array.shape)
    shifted[:] = array
    assert not shifted.flags.aligned
    return shifted


def read_only(array: np.ndarray) -> np.ndarray:
    array = array.copy()
    array.flags.writeable = False
    return array


class Wrapped:
    """Anything with ``__array__``."""

    def __init__(self, array: np.ndarray) -> None:
        self.array = array

    def __array__(self, dtype=None, copy=None) -> np.ndarray:
        return self.array if dtype is None else self.array.astype(dtype)


class Atoms:
    """As ASE's ``Atoms`` and MDAnalysis' groups, which have ``positions``."""

    def __init__(self, array: np.ndarray) -> None:
        self.positions = array

    def __len__(self) -> int:
        return len(self.positions)


LAYOUTS = {
    "float32": lambda a: a,
    "float64": lambda a: a.astype(np.float64),
    "longdouble": lambda a: a.astype(np.longdouble),
    "big-endian": lambda a: a.astype(">f4"),
    "big-endian float64": lambda a: a.astype(">f8"),
    "Fortran": np.asfortranarray,
    "strided": lambda a: np.repeat(a, 2, axis=0)[::2],
    "reversed": lambda a: a[::-1].copy()[::-1],
    "misaligned": misaligned,
    "misaligned float64": lambda a: misaligned(a.astype(np.float64)),
    "read-only": read_only,
    "a field of records": lambda a: np.rec.fromarrays([a, a], names="x,y").x if a.ndim == 1 else a,
    "__array__": Wrapped,
    "mapped": lambda a: a.view(np.memmap),
    "a matrix": lambda a: np.matrix(a) if a.ndim == 2 else a,
    "unmasked": lambda a: np.ma.masked_array(a),
    "lists": lambda a: a.tolist(),
}


@pytest.mark.filterwarnings("ignore:the matrix subclass:PendingDeprecationWarning")
@pytest.mark.parametrize("layout", LAYOUTS)
def test_layouts(layout: str) -> None:
    change = LAYOUTS[layout]
    scene = sppm.Scene()
    added = scene.add_spheres(change(CENTERS), change(RADII), sppm.Diffuse(0.5), velocity=change(CENTERS))
    assert added == range(N)
    assert np.array_equal(scene.centers, CENTERS)
    assert np.array_equal(scene.radii, RADII)
    assert np.array_equal(scene.velocities, CENTERS)
    assert not scene.emissions.any() and not scene.material_indices.any()
    scene.centers, scene.radii = change(CENTERS * 2), change(RADII * 2)
    assert np.array_equal(scene.centers, CENTERS * 2) and np.array_equal(scene.radii, RADII * 2)


@pytest.mark.parametrize("dtype", ["f2", "i1", "u1", ">i2", "i4", "u8", "i8"])
def test_other_types(dtype: str) -> None:
    scene = sppm.Scene()
    numbers = np.arange(1, 31).reshape(10, 3).astype(dtype)
    scene.add_spheres(numbers, numbers[:, 0], sppm.Diffuse(0.5))
    assert np.array_equal(scene.centers, numbers.astype("f4")) and np.array_equal(scene.radii, numbers[:, 0].astype("f4"))


def test_one_sphere_none_and_one_for_all() -> None:
    scene = sppm.Scene()
    assert scene.add_spheres([1, 2, 3], 4, sppm.Diffuse(0.5), emission=5) == range(1)
    assert scene.add_spheres([], [], sppm.Diffuse(0.5)) == range(1, 1)
    assert scene.add_spheres(np.zeros((0, 3)), 1, 0) == range(1, 1)
    assert scene.add_spheres(np.ones((3, 3)), 2, 0, emission=[1, 2, 3]) == range(1, 4)
    assert scene.radii.tolist() == [4, 2, 2, 2]
    assert scene.emissions.tolist() == [[5, 5, 5]] + [[1, 2, 3]] * 3


def test_materials_of_each_sphere() -> None:
    scene = sppm.Scene()
    red, blue, glass = sppm.Diffuse([1, 0, 0]), sppm.Diffuse([0, 0, 1]), sppm.Dielectric()
    scene.add_spheres(np.ones((4, 3)), 1, [red, glass, red, blue])
    assert scene.materials == (red, glass, blue)
    assert scene.material_indices.tolist() == [0, 1, 0, 2]
    scene.add_spheres(np.ones((2, 3)), 1, np.array([2, 1], np.uint8))
    scene.add_spheres([1, 1, 1], 1, 2)
    assert scene.material_indices.tolist() == [0, 1, 0, 2, 2, 1, 2]
    scene.material_indices = 1
    assert set(scene.material_indices.tolist()) == {1}


def test_atoms() -> None:
    scene = sppm.Scene()
    scene.add_spheres(Atoms(CENTERS[:5]), 1.5, sppm.Diffuse(0.5))
    assert np.array_equal(scene.centers, CENTERS[:5])


def test_atoms_of_ase() -> None:
    build = pytest.importorskip("ase.build")
    data = pytest.importorskip("ase.data")
    atoms = build.molecule("C60")
    scene = sppm.Scene()
    scene.add_spheres(atoms, data.covalent_radii[atoms.numbers], sppm.Diffuse(0.3))
    assert len(scene) == 60 and np.allclose(scene.centers, atoms.positions)
    assert np.allclose(scene.radii, 0.76)


def test_rows_that_are_wrong_change_nothing(cornell) -> None:
    before = cornell.digest
    radii = RADII.copy()
    radii[-1] = np.inf
    with pytest.raises(sppm.SceneError, match=rf"radius of sphere \[{N - 1}\]"):
        cornell.add_spheres(CENTERS, radii, [sppm.Diffuse(0.1)] * N)
    with pytest.raises(sppm.SceneError, match=r"radius of sphere \[8\]"):
        cornell.radii = [1] * 8 + [-1]
    assert cornell.digest == before and len(cornell.materials) == 6


def test_arrays_of_a_scene_are_copies(cornell) -> None:
    centers = cornell.centers
    assert centers.shape == (9, 3) and centers.dtype == np.float32 and not centers.flags.writeable
    cornell.remove_spheres(slice(1, None))
    assert len(centers) == 9 and len(cornell.centers) == 1


PEAK = """
import sys
import numpy as np, sppm

def peak():
    # Not that of getrusage, which begins with the peak of the process that has started this one.
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))

n = int(sys.argv[1])
centers = np.zeros((n, 3), sys.argv[2])[::-1]
radii = np.ones(n, sys.argv[2])
centers[:] = 1
scene = sppm.Scene()
scene.add_spheres([0, 0, 0], 1, sppm.Diffuse(0.5))
before = peak()
scene.add_spheres(centers, radii, 0, emission=[0, 0, 0])
print(peak() - before)
assert len(scene) == n + 1
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the system does not tell the peak of memory")
@pytest.mark.parametrize("dtype", ["<f4", ">f8"])
def test_ten_million_spheres_are_copied_once(dtype: str) -> None:
    """A sphere of a scene takes 44 bytes. The peak is that of the scene, and not of a second copy of anything."""
    SPHERES, BYTES_PER_SPHERE, SLACK = 10_000_000, 44, 32 << 20
    done = subprocess.run(
        [sys.executable, "-c", PEAK, str(SPHERES), dtype], capture_output=True, text=True, check=True
    )
    more = int(done.stdout)
    assert SPHERES * BYTES_PER_SPHERE * 0.9 < more < SPHERES * BYTES_PER_SPHERE + SLACK


RENDER = """
import sys
import numpy as np, sppm

def peak():
    with open("/proc/self/status") as status:
        return next(int(line.split()[1]) * 1024 for line in status if line.startswith("VmHWM"))

side = int(sys.argv[1])
centers = np.stack(np.meshgrid(*[np.arange(side, dtype="<f4")] * 3), axis=-1).reshape(-1, 3)
scene = sppm.Scene(background=[1, 1, 1])
scene.add_spheres(centers, 0.3, sppm.Diffuse(0.5))
scene.camera = sppm.Camera(eye=[0.5, 0.5, -side])
before = peak()
options = dict(width=8, height=8, iterations=1, photons_per_iteration=1000, initial_radius=1, max_depth=5, threads=2)
first = sppm.render(scene, **options)
print(peak() - before)
scene.name = "another"
second = sppm.render(scene, **options)
print(peak() - before)
assert np.array_equal(first.radiance, second.radiance)
"""


@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the system does not tell the peak of memory")
def test_a_render_shares_the_spheres_of_its_scene() -> None:
    """What comes to the 44 bytes of a sphere are the engine's own tables, of at most 62 bytes a sphere."""
    SIDE, BYTES_PER_SPHERE, SLACK = 150, 62, 24 << 20
    done = subprocess.run([sys.executable, "-c", RENDER, str(SIDE)], capture_output=True, text=True, check=True)
    for more in map(int, done.stdout.split()):
        assert SIDE**3 * 50 < more < SIDE**3 * BYTES_PER_SPHERE + SLACK
