"""Renders are watched, stopped, resumed and iterated by hand."""

from __future__ import annotations

import json
import shutil
import time
import warnings
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from conftest import ENDLESS, SMALL

import sppm
from sppm import _progress


def test_the_image_does_not_depend_on_how_it_is_rendered(cornell) -> None:
    right = sppm.render(cornell, iterations=4)
    for options in ({"threads": 1}, {"engine": "reference"}, *({"lanes": lanes} for lanes in sppm.available_lanes())):
        assert sppm.render(cornell, iterations=4, **options) == right
    with sppm.Render(cornell, iterations=4, paused=True) as render:
        steps = [render.iterate(), render.iterate(2), render.iterate(7)]
    assert [film.iterations for film in steps] == [1, 3, 4]
    assert steps[-1] == right == render.film and steps[1] == sppm.render(cornell, iterations=3)
    assert sppm.render(cornell, iterations=4, seed=2) != right
    assert right.count is not None and right.radius is not None and (right.radius <= 2).all() and right.count.max() > 1


def test_settings_are_those_of_the_scene_unless_given(cornell) -> None:
    assert sppm.render(cornell).radiance.shape == (30, 40, 3)
    assert sppm.render(cornell, width=8, height=4).radiance.shape == (4, 8, 3)
    assert cornell.settings.width == 40


@pytest.mark.parametrize("method", ["sppm", "path", "hybrid"])
@pytest.mark.parametrize("samples", [("light_samples", "--light-samples", 16), ("glint_samples", "--glint-samples", 64)])
def test_samples_are_those_of_the_command(cornell, command, tmp_path: Path, method, samples) -> None:
    name, option, most = samples
    film = sppm.render(cornell, iterations=2, method=method, **{name: 3})
    assert film != sppm.render(cornell, iterations=2, method=method)
    file = tmp_path / "cornell.toml"
    cornell.save(file)
    command("render", file, "-n", 2, "--method", method, option, 3, "-o", tmp_path / "a.pfm")
    assert (sppm.Film.load(tmp_path / "a.pfm").radiance == film.radiance).all()
    with pytest.raises(ValueError, match=name):
        sppm.render(cornell, iterations=2, **{name: most + 1})


def test_progress_is_an_iterator(cornell) -> None:
    with sppm.Render(cornell, iterations=20) as render:
        seen = list(render)
        assert render.is_over and render.ended_by == "iterations"
    done = [progress.iteration for progress in seen]
    assert done == sorted(set(done)) and done[-1] == 20
    assert seen[-1].photons == 80_000 and seen[-1].iterations == 20
    assert seen[-1].mean_radius is not None and 0 < seen[-1].mean_radius < 2
    assert list(render) == [] or list(render)[-1] == seen[-1]
    assert render.report["iterations"] == 20 and render.report["camera_segments"] > 0


def test_snapshots_come_while_it_renders(cornell) -> None:
    seen = []
    with sppm.Render(cornell, **ENDLESS) as render:
        for film in render.films(every=3):
            seen.append(film)
            if len(seen) == 3:
                render.stop()
    iterations = [film.iterations for film in seen]
    assert len(seen) in (3, 4) and all(b > a for a, b in zip(iterations, iterations[1:], strict=False))
    for film in seen[:3]:
        assert film == sppm.render(cornell, iterations=film.iterations)
    assert [film.iterations for film in sppm.Render(cornell, iterations=1).films()] == [1]


def test_stopping_keeps_the_image(cornell) -> None:
    with sppm.Render(cornell, **ENDLESS) as render:
        assert not render.wait(0.3) and not render.is_over
        assert "running" in repr(render)
        assert render.progress.iteration >= 0
        render.stop()
        film = render.result()
    assert render.ended_by == "stop" and film.iterations == render.report["iterations"]
    assert film == sppm.render(cornell, iterations=film.iterations)


def test_a_render_that_is_stopped_at_once_has_no_image(cornell) -> None:
    with sppm.Render(cornell, paused=True) as render:
        render.stop()
        assert render.wait(60)
        assert render.film is None and render.ended_by == "stop"
        with pytest.raises(sppm.RenderError, match="before its first iteration was complete; it has no image"):
            render.result()


def test_an_error_in_the_block_is_not_hidden(cornell) -> None:
    with pytest.raises(ZeroDivisionError), sppm.Render(cornell, **ENDLESS):
        _ = 1 / 0


def test_goals_end_a_render(cornell) -> None:
    for limit in (0.2, timedelta(milliseconds=200)):
        with sppm.Render(cornell, time=limit) as render:
            film = render.result()
        assert render.ended_by == "time" and film.iterations > 2
    with sppm.Render(cornell, until_error=1e9) as render:
        assert render.result().iterations == 2 and render.ended_by == "error"
        assert render.report["estimated_error"] > 0
    assert render.progress.estimated_error is not None


def test_iterations_that_are_given_too_end_a_render_before_its_goal(cornell) -> None:
    for goal in ({"time": 3600}, {"until_error": 1e-9}):
        with sppm.Render(cornell, iterations=3, **goal, paused=True) as render:
            film = render.iterate(5)
            assert film is not None and film.iterations == 3 == render.progress.iterations
            assert render.is_over and render.ended_by == "iterations"


def test_a_resumed_render_keeps_its_goal(cornell, tmp_path: Path) -> None:
    path = tmp_path / "a.sppm"
    with sppm.Render(cornell, until_error=1e-9, checkpoint=path, paused=True) as render:
        render.iterate(2)
    with sppm.Render.resume(path, paused=True) as resumed:
        resumed.iterate(2)
        assert resumed.progress.iteration == 4 and resumed.progress.estimated_error is not None
    # Unless it is given another.
    with sppm.Render.resume(path, until_error=1e9) as resumed:
        resumed.result()
        assert resumed.ended_by == "error"


def test_checkpoints_are_resumed(cornell, tmp_path: Path) -> None:
    right = sppm.render(cornell, iterations=9)
    path = tmp_path / "a.sppm"
    with sppm.Render(cornell, iterations=9, checkpoint=path, every=2, paused=True) as render:
        render.iterate(5)
        assert path.exists()
    assert render.checkpoint == str(path)
    with sppm.Render.resume(path, threads=1, engine="reference") as resumed:
        assert resumed.result() == right
        assert resumed.report["resumed_after"] == 5
    # The same call goes on from what is there, and the complete render takes more iterations.
    assert sppm.render(cornell, iterations=9, checkpoint=path) == right
    assert sppm.Render.resume(path, iterations=12).result() == sppm.render(cornell, iterations=12)
    with pytest.raises(sppm.InputError, match="holds 12 iterations of .*; continue it by sppm.Render.resume"):
        sppm.render(cornell, seed=3, checkpoint=path)
    with pytest.raises(sppm.InputError, match="iterations 3: .* holds 12 already"):
        sppm.Render.resume(path, iterations=3)
    with pytest.raises(sppm.FileError):
        sppm.Render.resume(__file__)


def test_a_resumed_render_is_saved_as_often_as_it_is_told(cornell, tmp_path: Path) -> None:
    path = tmp_path / "a.sppm"
    with sppm.Render(cornell, iterations=9, checkpoint=path, every=timedelta(hours=1), paused=True) as render:
        render.iterate()
        assert not render.progress.saved
    for every, is_saved in ((None, False), (2, True), (timedelta(hours=1), False)):
        with sppm.Render.resume(path, every=every, paused=True) as render:
            render.iterate(2)
            assert render.progress.saved == is_saved, every


def test_renders_of_files_heed_the_options_of_a_render(cornell, tmp_path: Path) -> None:
    path, image = tmp_path / "a.sppm", tmp_path / "a.exr"
    sppm.render(cornell, checkpoint=path).save(image)
    wrong = [
        ({"memory_limit": 1}, "memory_limit: the render needs up to"),
        ({"threads": 0}, "threads is 0"),
        ({"lanes": "wide"}, 'lanes "wide": there is no such'),
    ]
    for options, why in wrong:
        for begin in (lambda given: sppm.Render.resume(path, iterations=3, **given), lambda given: sppm.Render.like(image, **given)):
            with pytest.raises(sppm.InputError, match=why):
                begin(options)
    with pytest.raises(sppm.InputError, match="engine reference has no lanes"):
        sppm.Render.resume(path, engine="reference", lanes="emulated")
    # A render that is repeated can be resumed as any other.
    with sppm.Render.like(image, checkpoint=tmp_path / "b.sppm", every=1, paused=True) as render:
        render.iterate()
        assert render.progress.saved
    assert sppm.info(tmp_path / "b.sppm")["iterations"] == 1


def test_an_image_of_an_older_light_transport_is_repeated_with_a_warning(tmp_path: Path) -> None:
    """It is another image."""
    path = tmp_path / "old.sppm"
    shutil.copy(Path(__file__).parents[2] / "fixtures/checkpoints/version-1.sppm", path)
    with sppm.Render.like(path) as render, pytest.warns(sppm.RenderWarning, match=r"old\.sppm was made by version 1 of the light"):
        assert render.result().iterations == 2


def test_parts_tell_what_they_hold_and_what_is_missing(cornell, tmp_path: Path) -> None:
    cornell.settings = cornell.settings.replace(radius_schedule="global", iterations=8)
    files = [tmp_path / name for name in ("a.sppm", "b.sppm", "c.sppm")]
    for file, (start, stop) in zip(files, [(0, 2), (4, 6), (0, 2)], strict=True):
        sppm.render_part(cornell, start, stop, file)
    for parts, iterations, missing, repeated in (
        (files[:1], [(0, 2)], [(2, 8)], []),
        (files[1::-1], [(0, 2), (4, 6)], [(2, 4), (6, 8)], []),
        (files, [(0, 2), (4, 6)], [(2, 4), (6, 8)], ["c.sppm"]),
    ):
        merged = sppm.merge(parts)
        assert (merged.iterations, merged.missing) == (iterations, missing)
        assert all(isinstance(file, str) for file in merged.repeated)
        assert [Path(file).name for file in merged.repeated] == repeated


def test_resuming_the_command_s_checkpoint_leaves_its_files(cornell, command, tmp_path: Path) -> None:
    cornell.save(tmp_path / "cornell.toml")
    path = tmp_path / "a.sppm"
    command("render", tmp_path / "cornell.toml", "-n", 2, "-o", tmp_path / "a.pfm", "--checkpoint", path)
    before = (tmp_path / "a.pfm").read_bytes()
    film = sppm.Render.resume(path, iterations=4).result()
    assert film is not None and film == sppm.render(cornell, iterations=4)
    assert (tmp_path / "a.pfm").read_bytes() == before


def test_a_part_is_resumed_to_its_own_end(cornell, command, tmp_path: Path) -> None:
    cornell.save(tmp_path / "cornell.toml")
    path = tmp_path / "part.sppm"
    part = ["--radius-schedule=global", "-n6", "--range=2..5", "--quiet"]
    command("render", tmp_path / "cornell.toml", *part, "-o", path)
    info = sppm.info(path)
    assert info["iterations"] == 3 and info["which"] == [[2, 5]]
    film = sppm.Render.resume(path).result()
    assert film is not None and film.iterations == 3
    # What is told of an image of some iterations is what the command tells.
    command("merge", path, "-o", tmp_path / "some.exr", "--quiet")
    told = json.loads(command("info", tmp_path / "some.exr", "--json"))
    assert told["which"] == sppm.info(tmp_path / "some.exr")["which"] == [[2, 5]]


def test_a_damaged_checkpoint_is_a_warning(cornell, tmp_path: Path) -> None:
    path = tmp_path / "a.sppm"
    for iterations in (3, 6):
        sppm.render(cornell, iterations=iterations, checkpoint=path)
    path.write_bytes(path.read_bytes()[:-100])
    shutil.copy(path, tmp_path / "b")
    with pytest.warns(sppm.RenderWarning, match="resumed from the older generation"), warnings.catch_warnings():
        warnings.simplefilter("always")
        assert sppm.Render.resume(path, iterations=7).result() == sppm.render(cornell, iterations=7)


@pytest.mark.parametrize("when", ["during the render", "at its end"])
def test_a_checkpoint_that_cannot_be_written_is_a_warning(cornell, tmp_path: Path, when: str) -> None:
    folder = tmp_path / "folder"
    folder.mkdir()
    every: int | timedelta = 1 if when == "during the render" else timedelta(hours=1)
    with sppm.Render(cornell, iterations=3, checkpoint=folder / "a.sppm", every=every, paused=True) as render:
        render.iterate()
        shutil.rmtree(folder)
        if when == "during the render":
            with pytest.warns(sppm.RenderWarning, match="the checkpoint was not written: .*folder"):
                render.iterate()
            folder.mkdir()
            render.iterate()
            assert render.checkpoint == str(folder / "a.sppm")
        else:
            render.iterate()
            with pytest.warns(sppm.RenderWarning, match="the checkpoint was not written: .*folder"):
                render.iterate()
                assert render.result() == sppm.render(cornell, iterations=3)
            # It is not lost, but elsewhere.
            assert render.checkpoint is not None
            rescued = Path(render.checkpoint)
            assert sppm.Render.resume(rescued).result() == sppm.render(cornell, iterations=3)
            for file in rescued.parent.glob(f"{rescued.name}*"):
                file.unlink()


def test_a_checkpoint_is_used_by_one_render(cornell, tmp_path: Path) -> None:
    path = tmp_path / "a.sppm"
    with sppm.Render(cornell, **ENDLESS, checkpoint=path), pytest.raises(sppm.InputError, match="checkpoint"):
        sppm.Render(cornell, **ENDLESS, checkpoint=path)


def test_no_output_overwrites_the_scene(tmp_path: Path, cornell) -> None:
    path = tmp_path / "a.toml"
    cornell.save(path)
    loaded = sppm.Scene.load(path)
    for scene in (loaded, loaded.copy()):
        with pytest.raises(sppm.InputError, match="checkpoint: .* is also"):
            sppm.render(scene, checkpoint=path)


def test_no_output_overwrites_the_profile(tmp_path: Path, cornell) -> None:
    path = tmp_path / "profile.toml"
    path.write_text("")
    with pytest.raises(sppm.InputError, match="checkpoint: .* is also"):
        sppm.render(cornell, profile=path, checkpoint=path)
    assert path.read_text() == ""


def test_progress_is_told_to_a_function(cornell) -> None:
    told: list[sppm.Progress] = []
    sppm.render(cornell, iterations=30, progress=told.append)
    assert told[-1].iteration == 30
    assert [p.iteration for p in told] == sorted({p.iteration for p in told})
    # Those of the last iteration, which are a part of those of all.
    last = told[-1]
    assert 0 < last.seconds < last.elapsed_seconds


def test_an_error_of_that_function_stops_the_render(cornell) -> None:
    def fail(_: object) -> None:
        raise ZeroDivisionError

    began = time.monotonic()
    with pytest.raises(ZeroDivisionError):
        sppm.render(cornell, **{**SMALL, "iterations": 1 << 30}, progress=fail)
    assert time.monotonic() - began < 30


def test_a_bar_is_shown_if_asked_for(cornell, capfd) -> None:
    sppm.render(cornell, progress=True)
    assert "iteration" in capfd.readouterr().err
    sppm.render(cornell)
    sppm.render(cornell, progress=False)
    printed = capfd.readouterr()
    assert printed.out == printed.err == ""


def test_rays_are_broadcast(cornell) -> None:
    many = sppm.trace(cornell, [50, 50, 200], np.eye(3))
    one = [sppm.trace(cornell, [50, 50, 200], way) for way in np.eye(3)]
    assert many.t.tolist() == [hit.t[0] for hit in one] and many.normal.shape == (3, 3)
    assert len(sppm.trace(cornell, np.zeros((0, 3)), [0, 0, 1]).t) == 0
    assert sppm.trace(sppm.Scene(), [0, 0, 0], [0, 0, 1]).sphere.tolist() == [-1]


def test_rays_without_a_time_meet_the_scene_as_the_shutter_opens() -> None:
    scene = sppm.Scene(sppm.Camera([0, 0, 10], [0, 0, -1], shutter=(1, 2)))
    scene.add_spheres([0, 0, 0], 1, sppm.Diffuse(0.5), velocity=[3, 0, 0])
    ways = ([[0, 0, 10], [3, 0, 10], [6, 0, 10]], [0, 0, -1])
    assert sppm.trace(scene, *ways).sphere.tolist() == sppm.trace(scene, *ways, time=1.0).sphere.tolist() == [-1, 0, -1]
    assert sppm.trace(scene, *ways, time=2.0).sphere.tolist() == [-1, -1, 0]


@pytest.mark.parametrize("news", [[1, 2, 3, 6], [2, 2, 6], [6]])
def test_the_bar_is_where_the_render_is(news: list[int], monkeypatch: pytest.MonkeyPatch) -> None:
    """Also if several iterations have passed since the last news, or none."""

    class Tqdm:
        def __init__(self, total: int, **_: object) -> None:
            self.n, self.total, self.is_open = 0, total, True
            bars.append(self)

        def update(self, more: int) -> None:
            self.n += more

        def close(self) -> None:
            self.is_open = False

    bars: list[Tqdm] = []
    told: list[int] = []
    monkeypatch.setattr(_progress, "_tqdm", lambda: Tqdm)
    with _progress.Bar(True, 6) as bar:
        for iteration in news:
            bar.update(sppm.Progress(iteration=iteration, iterations=6))
            told.append(bars[0].n)
    assert told == news and bars[0].total == 6 and not bars[0].is_open
    # Until a goal is reached nobody knows how many iterations there will be.
    with _progress.Bar(True, sppm._sppm.MAX_ITERATIONS):
        assert bars[1].total is None
