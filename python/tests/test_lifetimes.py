"""Nothing dies too early, and nothing is kept."""

from __future__ import annotations

import copy
import gc
import pickle
import subprocess
import sys
import time
import weakref
from pathlib import Path

import numpy as np
import pytest
from conftest import SMALL

import sppm
from sppm._interrupted import interrupted


def resident() -> int:
    """Bytes of memory that the process holds."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * 4096


def test_arrays_outlive_films_and_renders(cornell) -> None:
    right = sppm.render(cornell)
    expected = right.radiance.copy()
    arrays = []
    for _ in range(5):
        with sppm.Render(cornell) as render:
            film = render.result()
        arrays.append((film.radiance, film.radius, film.count))
        del film, render
        gc.collect()
    # Other memory is asked for, which would overwrite what was freed.
    rubbish = [np.full((30, 40, 3), np.nan, np.float32) for _ in range(100)]
    for radiance, radius, count in arrays:
        assert np.array_equal(radiance, expected)
        assert np.array_equal(radius, right.radius) and np.array_equal(count, right.count)
    del rubbish


def test_radiance_is_not_copied(cornell) -> None:
    film = sppm.render(cornell)
    assert film.radiance is film.radiance
    assert np.asarray(film) is film.radiance
    assert np.shares_memory(np.asarray(film), film.radiance)
    assert film.radiance.dtype == np.float32 and film.radiance.shape == (30, 40, 3)
    assert film.radiance.flags.c_contiguous and not film.radiance.flags.writeable
    assert np.array(film, copy=True).flags.writeable


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the system does not tell the memory")
def test_a_thousand_renders_leave_nothing(cornell) -> None:
    """Memory after 1000 renders is what it was after 200, but for what allocators keep."""
    SLACK = 8 << 20
    cornell.settings = cornell.settings.replace(iterations=1, photons_per_iteration=100)

    def cycle(times: int) -> None:
        for i in range(times):
            scene = cornell.copy()
            scene.add_spheres(np.full((10, 3), 40.0 + i % 7), 1, sppm.Diffuse(0.5))
            with sppm.Render(scene, threads=1) as render:
                assert render.result(progress=False).iterations == 1

    cycle(200)
    gc.collect()
    before = resident()
    cycle(1000)
    gc.collect()
    assert resident() - before < SLACK


@pytest.mark.skipif(not Path("/proc/self/statm").exists(), reason="the system does not tell the memory")
def test_dropped_renders_stop_and_free(cornell) -> None:
    SLACK = 8 << 20
    threads = Path("/proc/self/task")
    base = len(list(threads.iterdir()))
    for i in range(60):
        render = sppm.Render(cornell, iterations=1 << 30, threads=2)
        if i % 2:
            render.film  # noqa: B018
        del render
        if i == 20:
            before = resident()
    gc.collect()
    assert resident() - before < SLACK
    # The threads of a pool end by themselves, soon after it is dropped.
    deadline = time.monotonic() + 60
    while len(list(threads.iterdir())) > base + 1:
        assert time.monotonic() < deadline, "threads are left"
        time.sleep(0.05)


def test_films_and_scenes_are_collected(cornell) -> None:
    film = sppm.render(cornell)
    scene = cornell.copy()
    dead = [weakref.ref(one) for one in (film, film.radiance, film.radius, scene)]
    del film, scene
    gc.collect()
    assert [ref() for ref in dead] == [None] * 4


def test_a_program_may_end_while_it_renders() -> None:
    program = """
import sppm
render = sppm.Render(sppm.Scene.load("cornell"), iterations=1 << 30, width=64, height=48)
kept = [render.film, render]
print("done")
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stdout, done.stderr) == (0, "done\n", "")


@pytest.mark.parametrize("protocol", range(2, pickle.HIGHEST_PROTOCOL + 1))
def test_pickles_are_equal(cornell, protocol: int) -> None:
    cornell.add_spheres([40, 20, 50], 3, sppm.Dielectric([1, 0.9, 0.8], 1.33), emission=[1, 2, 3], velocity=[0, 1, 0])
    cornell.camera = cornell.camera.replace(shutter=[0, 0.5])
    cornell.background = [0.1, 0.2, 0.3]
    film = sppm.render(cornell)
    metrics = sppm.compare(film, film.radiance * 2)
    for value in (cornell, cornell.camera, cornell.settings, *cornell.materials, film, metrics, sppm.Progress(3)):
        again = pickle.loads(pickle.dumps(value, protocol))
        assert again == value and type(again) is type(value)
    again = pickle.loads(pickle.dumps(film, protocol))
    assert again.metadata == film.metadata and not again.radiance.flags.writeable
    assert sppm.render(pickle.loads(pickle.dumps(cornell, protocol))) == film
    stopped = pickle.loads(pickle.dumps(sppm.Interrupted(film), protocol))
    assert stopped.film == film and str(stopped) == str(sppm.Interrupted(film))
    # An image that nobody has asked for yet is developed for it.
    late = pickle.loads(pickle.dumps(interrupted(lambda: film), protocol))
    assert late.film == film
    error = pickle.loads(pickle.dumps(sppm.SceneError("wrong"), protocol))
    assert type(error) is sppm.SceneError and str(error) == "wrong"


def test_large_arrays_are_pickled_out_of_band(cornell) -> None:
    """Protocol 5 moves arrays without copying them, as Dask and multiprocessing do."""
    film = sppm.render(cornell)
    buffers: list[pickle.PickleBuffer] = []
    head = pickle.dumps(film, 5, buffer_callback=buffers.append)
    assert sum(len(buffer.raw()) for buffer in buffers) == 30 * 40 * (3 + 1 + 1) * 4 > 5 * len(head)
    assert pickle.loads(head, buffers=buffers) == film


def test_copies_are_independent(cornell) -> None:
    for twin in (cornell.copy(), copy.copy(cornell), copy.deepcopy(cornell)):
        assert twin == cornell and twin is not cornell
        assert twin.settings == cornell.settings
        twin.remove_spheres([0])
        twin.name = "another"
        assert len(cornell) == 9 and cornell.name == "Cornell Box"
    film = sppm.render(cornell)
    assert copy.copy(film) is film and copy.deepcopy(film) is film


def test_films_do_not_follow_the_arrays_they_were_made_from() -> None:
    for given in (np.ones((2, 3, 3), np.float32), np.ones((2, 3, 3))):
        film = sppm.Film(given, radius=given[..., 0], count=given[..., 1])
        given[:] = 7
        assert film.radiance.max() == 1 and film.radius.max() == 1 and film.count.max() == 1


def test_a_closed_render_keeps_its_results(cornell) -> None:
    render = sppm.Render(cornell, **{**SMALL, "iterations": 1 << 30})
    film = render.film
    render.close()
    render.close()
    assert film is not None and render.film is not None
    assert render.film.iterations >= film.iterations
    assert render.ended_by == "stop" and render.report["interrupted"]
    assert render.is_over and "over" in repr(render)
