"""What the driver of a farm reckons with, by itself: no workers are needed."""

from __future__ import annotations

import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import sppm
from sppm import _sppm
from sppm.farm import Driver, FarmError, Job, jobs_of
from sppm.farm import _driver, _jobs
from sppm.farm import _tasks as tasks
from sppm.farm._work import Block, Part, Work

SMALL = {"width": 8, "height": 6, "photons_per_iteration": 500, "iterations": 40}


def job(output: Path, **changes: Any) -> Job:
    scene = sppm.Scene.load("cornell")
    scene.settings = scene.settings.replace(**{**SMALL, **changes})
    return Job(scene, output)


def driver(workers: dict[str, Any], **options: Any) -> Any:
    found: Any = Driver(SimpleNamespace(cluster=None), **options)
    found._workers = workers
    return found


def part(work: Work, start: int, stop: int, content: bytes = b"", status: str = "finished") -> Part:
    future = SimpleNamespace(status=status, result=lambda timeout: content, release=lambda: None)
    return Part([Block(work, (start, stop), future, 0.0)], future)


def test_a_job_is_left_until_all_of_it_is_stored(tmp_path: Path) -> None:
    work = Work(job(tmp_path / "a.exr"), [(0, 4), (9, 12)])
    assert work.is_left([])
    assert [work.take(3), work.take(3), work.take(3), work.take(3)] == [(0, 3), (3, 4), (9, 12), None]
    assert not work.is_left([])
    block = part(work, 0, 3).blocks[0]
    assert work.is_left([block])
    assert not Work(job(tmp_path / "b.exr"), []).is_left([block]), "a block of another job"
    # What is there, or is being added up, is not in the state file yet.
    for name in ("ready", "sums"):
        setattr(work, name, [part(work, 0, 3)])
        assert work.is_left([])
        setattr(work, name, [])


def test_the_state_file_is_replaced_and_never_rewritten(tmp_path: Path) -> None:
    """Whoever reads it, and whatever ends the driver meanwhile: it is the old one or the new one."""
    work = Work(job(tmp_path / "a.exr"), [])
    packed = tasks.pack(work.job.scene)
    parts = [tasks.render_block(packed, "a", k, k + 1, 1, _sppm.TRANSPORT) for k in range(3)]
    one = driver({})
    one._store(work, parts[:1])
    before = work.job.state.read_bytes()
    with work.job.state.open("rb") as reader:
        one._store(work, parts[1:])
        assert reader.read() == before
    assert sppm.merge([work.job.state]).iterations == [(0, 3)]
    assert [file.name for file in tmp_path.iterdir()] == ["a.exr.sppm"]


def test_the_largest_parts_are_stored_first_and_none_is_lost(tmp_path: Path) -> None:
    work = Work(job(tmp_path / "a.exr"), [])
    packed = tasks.pack(work.job.scene)
    for k in range(_driver._DIRECT + 3):
        work.ready.append(part(work, k, k + 1, tasks.render_block(packed, "a", k, k + 1, 1, _sppm.TRANSPORT)))
    one = driver({}, every=1e9)
    one._keep(work)
    assert work.done == _driver._DIRECT and len(work.ready) == 3
    work.next_store = 0.0
    one._keep(work)
    assert work.job.done == [(0, _driver._DIRECT + 3)] and not work.ready


def test_parts_that_went_with_their_worker_are_waited_for_again(tmp_path: Path) -> None:
    work = Work(job(tmp_path / "a.exr"), [])
    there, lost = part(work, 0, 1), part(work, 1, 2, status="lost")
    several = part(work, 2, 4, status="lost")
    several.blocks += part(work, 4, 6).blocks
    work.ready = [there, lost, several]
    # A sum that waits for one is given up: what else is in it is taken back.
    total, kept = part(work, 6, 9, status="pending"), part(work, 6, 8)
    total.of = [kept, part(work, 8, 9, status="lost")]
    work.sums = [total]
    one = driver({})
    one._mind_losses(work)
    assert work.ready == [there, kept]
    assert work.sums == [several]
    assert [block.range for block in one._blocks] == [(1, 2), (8, 9)]


def stub(told: list[str]) -> Any:
    """A driver whose client notes nothing and ends nothing."""
    one = driver({}, every=1e9, tell=told.append)
    one._client = SimpleNamespace(
        cancel=lambda futures, force: None, submit=lambda *_, key, **rest: SimpleNamespace(status="pending", key=key))
    return one


def test_a_damaged_part_is_rendered_again_and_counts_for_nothing(tmp_path: Path) -> None:
    """With those that were to be stored together with it."""
    work = Work(job(tmp_path / "a.exr"), [])
    packed = tasks.pack(work.job.scene)
    good, damaged = (bytearray(tasks.render_block(packed, "a", k, k + 1, 1, _sppm.TRANSPORT)) for k in range(2))
    damaged[-50] ^= 1
    work.ready = [part(work, 0, 1, bytes(good)), part(work, 1, 2, bytes(damaged))]
    told: list[str] = []
    one = stub(told)
    one._keep(work)
    assert work.job.done == [] and not work.ready and not work.job.state.exists()
    assert sorted((block.range, block.attempt) for block in one._blocks) == [((0, 1), 1), ((1, 2), 1)]
    # Under other names, as what Dask has by the old ones is damaged.
    assert all(block.future.key.endswith("-1") for block in one._blocks)
    assert any("checksum" in line for line in told)
    assert list(tmp_path.iterdir()) == []


def test_what_does_not_arrive_is_fetched_again_and_in_the_end_told(tmp_path: Path) -> None:
    def fail(timeout: float) -> bytes:
        waited.append(timeout)
        raise TimeoutError("gone")

    waited: list[float] = []
    work = Work(job(tmp_path / "a.exr"), [])
    late = part(work, 0, 1)
    late.future.result = fail
    work.ready = [late]
    told: list[str] = []
    one = stub(told)
    for _ in range(_driver._ATTEMPTS):
        work.next_store = 0.0
        one._keep(work)
        assert work.ready == [late] and work.job.done == [] and work.is_left([])
    assert len(told) == _driver._ATTEMPTS and "is fetched again: gone" in told[-1]
    assert waited == sorted(set(waited)), "each time it gets longer"
    work.next_store = 0.0
    with pytest.raises(FarmError, match="results of workers do not arrive: gone"):
        one._keep(work)


@pytest.mark.parametrize(("kind", "hint"), [("KilledWorker", "; the workers may lack memory: 3"), ("RenderError", ": 3")])
def test_a_block_that_kills_its_workers_may_need_memory(kind: str, hint: str, tmp_path: Path) -> None:
    why = type(kind, (Exception,), {})(3)
    future = SimpleNamespace(status="error", exception=lambda timeout: why)
    work = Work(job(tmp_path / "a.exr"), [])
    block = Block(work, (4, 6), future, 0.0, attempt=_driver._ATTEMPTS - 1)
    with pytest.raises(FarmError) as caught:
        stub([])._try_again(block, "error")
    assert str(caught.value) == f"iterations 4..6 of {work.job.output} failed 4 times{hint}"


def test_workers_of_another_version_get_nothing(tmp_path: Path) -> None:
    assert driver({"a": True, "b": True})._placed() == {}
    # Those that have not answered yet are neither.
    some = driver({"a": True, "b": False, "c": object()})
    assert some._placed() == {"workers": ["a"], "allow_other_workers": False}


def test_blocks_take_about_the_time_asked_for_and_become_short_towards_the_end(tmp_path: Path) -> None:
    work = Work(job(tmp_path / "a.exr"), [(0, 10_000)])
    two = driver({"a": True, "b": True}, seconds=10.0)
    assert two._size(work) == 1, "at first nothing is known"
    two._begun = time.monotonic() - 1000.0
    # What was done long ago says nothing.
    two._finished = [(time.monotonic() - 500.0, 1_000_000), (time.monotonic(), 400)]
    assert two._rate() == pytest.approx(40.0, rel=0.05)
    assert two._size(work) == pytest.approx(10.0 * 40.0 / 2, rel=0.05)
    work.missing = [(0, 10), (20, 50)]
    assert two._size(work) == 40 // (2 * 2)
    work.missing = [(0, 1)]
    assert two._size(work) == 1
    assert driver({}, block=7)._size(work) == 7


def test_progress_counts_what_is_done_and_not_stored_yet(tmp_path: Path) -> None:
    told: list[str] = []
    one = driver({"a": True}, show=told.append)
    work = Work(job(tmp_path / "a.exr"), [])
    work.job.done = [(0, 5), (7, 10)]
    work.ready, work.sums = [part(work, 10, 13)], [part(work, 20, 24)]
    one._begun = time.monotonic() - 1000.0
    one._finished = [(time.monotonic(), 20)]
    one._show_progress([work])
    assert told == ["15 of 40 iterations, 1 workers, 2 iterations/s, 12s to go"]


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(-1, "0s"), (59.9, "59s"), (60, "1min 00s"), (3599, "59min 59s"), (3600, "1h00"), (5 * 3600 + 61, "5h01")],
)
def test_times_are_told_in_two_units(seconds: float, text: str) -> None:
    assert _driver._duration(seconds) == text


def test_a_job_has_radii_that_can_be_merged(tmp_path: Path) -> None:
    scene = sppm.Scene.load("cornell")
    scene.settings = scene.settings.replace(**SMALL, radius_pilots=2, radius_clearance=0.5)
    settings = Job(scene, tmp_path / "a.exr").scene.settings
    assert (settings.radius_schedule, settings.radius_pilots, settings.radius_clearance) == ("global", 0, 0)


@pytest.mark.parametrize(
    "changes",
    [{}, {"glint_samples": 3}, {"light_samples": 2}, {"filter": "mitchell"}, {"initial_radius": 0.3}, {"seed": 2**64 - 1}],
    ids=str,
)
def test_a_state_is_of_the_render_with_its_settings(changes: dict[str, Any], tmp_path: Path) -> None:
    made = job(tmp_path / "a.exr", **changes)
    sppm.render_part(made.scene, 0, 2, made.state)
    again = job(tmp_path / "a.exr", **changes)
    again.load()
    assert again.done == [(0, 2)]
    other = job(tmp_path / "a.exr", **({} if changes else {"max_depth": 9}))
    with pytest.raises(sppm.InputError, match=r"a\.exr\.sppm is of another render"):
        other.load()


def test_whoever_gives_a_radius_chooses_the_rest_of_the_sampling_by_hand() -> None:
    size = {"width": 8, "height": 6}
    for settings, sweeps in (({"initial_radius": 3.0}, []), ({}, ["radius=3"])):
        (given,) = jobs_of(["cornell"], None, {**size, **settings}, sweeps, "draft")
        assert [word for word in given.chosen.split() if word.startswith("-")] == ["-n", "--photons", "--depth"]
        assert given.scene.settings.glint_samples == 1


def test_sweeps_name_settings_as_options_do() -> None:
    for sweep, name, values in (
        ("photons=10, 20", "photons_per_iteration", [10, 20]),
        ("depth=3", "max_depth", [3]),
        ("glint-samples=1,4", "glint_samples", [1, 4]),
        (" radius = 0.5,2", "initial_radius", [0.5, 2.0]),
        ("filter=box,gaussian", "filter", ["box", "gaussian"]),
        ("max_depth=3", "max_depth", [3]),
    ):
        found = _jobs._axis(sweep)
        assert {one for one, _, _ in found} == {name} and [value for _, value, _ in found] == values


def test_a_folder_is_its_scene_files_in_order(tmp_path: Path) -> None:
    for name in ("b.toml", "a.toml", "notes.txt", "a.exr", "a.exr.sppm"):
        (tmp_path / name).write_text("")
    assert _jobs._files(str(tmp_path)) == [str(tmp_path / "a.toml"), str(tmp_path / "b.toml")]


def test_images_are_called_as_their_scenes_unless_they_have_a_name(tmp_path: Path) -> None:
    made = job(tmp_path / "x.exr")
    made.scene.save(tmp_path / "box.toml")
    box, folder = str(tmp_path / "box.toml"), tmp_path / "new"
    outputs = [
        ([box], None, [], ["box.png"]),
        ([box], folder / "mine.exr", [], [folder / "mine.exr"]),
        ([box], None, ["seed=1,2"], ["box-seed-1.png", "box-seed-2.png"]),
        (["cornell", box], None, [], ["cornell.png", "box.png"]),
        # One value is one render.
        ([box], folder / "mine.exr", ["seed=1"], [folder / "mine.exr"]),
    ]
    for scenes, output, sweeps, expected in outputs:
        assert [one.output for one in jobs_of(scenes, output, {}, sweeps, "paper")] == [Path(name) for name in expected]
        assert not folder.exists()
    several = jobs_of(["cornell", box], folder, {}, [], "paper")
    assert [one.output for one in several] == [folder / "cornell.png", folder / "box.png"] and folder.is_dir()


def test_a_sweep_goes_before_what_is_given_for_all(tmp_path: Path) -> None:
    jobs = jobs_of(["cornell"], tmp_path, {"seed": 5, "width": 20}, ["seed=1,2", "radius=3,4"], "paper")
    found = [(j.scene.settings.seed, j.scene.settings.initial_radius, j.scene.settings.width) for j in jobs]
    assert found == [(1, 3.0, 20), (1, 4.0, 20), (2, 3.0, 20), (2, 4.0, 20)]
    assert len({j.output for j in jobs}) == 4


def test_two_renders_do_not_write_one_image(tmp_path: Path) -> None:
    paths = [tmp_path / folder / "a.toml" for folder in ("one", "two")]
    for path in paths:
        path.parent.mkdir()
        job(tmp_path).scene.save(path)
    with pytest.raises(sppm.InputError, match=r"a\.png would be the image of two renders"):
        jobs_of([str(path) for path in paths], tmp_path, {}, [])


def test_every_image_is_shown_once_it_is_whole(tmp_path: Path) -> None:
    """Also if nobody asks for another picture, and the one before had as many iterations."""
    seen: list[tuple[str, ...]] = []
    told: list[tuple[Any, ...]] = []
    viewer = SimpleNamespace(
        begin=lambda name: seen.append(("begin", name)), tell=lambda *given: told.append(given[:2]), wants=lambda _: False,
        show=lambda state, *_: seen.append(("show", Path(state).name)))
    one = driver({}, viewer=viewer)
    names = ["a", "b", "c"]
    works: list[Any] = [SimpleNamespace(job=job(tmp_path / f"{name}.exr", iterations=4), done=0, stored=0.0) for name in names]
    for time_, work in enumerate(works, 1):
        work.done, work.stored = 3, float(time_)
        one._show_picture(works)
        work.done = 4
        one._show_picture(works)
        one._show_picture(works)
    assert [entry for entry in seen if entry[0] == "show"] == [("show", f"{name}.exr.sppm") for name in names]
    assert told[0] == ((3, 4), 3 * SMALL["photons_per_iteration"])
    assert [entry for entry in seen if entry[0] == "begin"] == [("begin", f"{name}.exr") for name in names]
