"""The farm: the bits of one machine, however many workers there are and whatever happens to them."""

from __future__ import annotations

import base64
import hashlib
import json
import os
import random
import re
import signal
import socket
import subprocess
import sys
import tempfile
import time
import urllib.error
import urllib.parse
import urllib.request
import zlib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import balls

import sppm
from sppm import _sppm
from sppm.farm import Driver, FarmError, Job, jobs_of
from sppm.farm import _tasks as tasks
from sppm.farm._cluster import client_of
from sppm.farm._work import joined, without

pytestmark = pytest.mark.filterwarnings("ignore")  # Dask warns of ports, of slow starts, of workers that are gone

SMALL = {"width": 24, "height": 16, "photons_per_iteration": 2000, "iterations": 20}


def small(name: str = "cornell", **changes: Any) -> sppm.Scene:
    scene = sppm.Scene.load(name)
    scene.settings = scene.settings.replace(**{**SMALL, **changes}, radius_schedule="global")
    return scene


def whole(scene: sppm.Scene) -> np.ndarray:
    return sppm.render(scene, progress=False).radiance


@pytest.fixture(scope="module")
def client():
    with client_of(2, None) as client:
        yield client


def farm(client, jobs: list[Job], **options: Any) -> list[str]:
    told: list[str] = []
    Driver(client, tell=told.append, every=0.5, **options).run(jobs)
    return told


@pytest.mark.parametrize("block", [None, 1, 3, 20])
def test_the_image_is_that_of_one_machine(client, tmp_path: Path, block) -> None:
    scene = small(seed=block or 0)
    told = farm(client, [Job(scene, tmp_path / "a.exr")], block=block)
    assert np.array_equal(sppm.Film.load(tmp_path / "a.exr").radiance, whole(scene))
    assert sorted(os.listdir(tmp_path)) == ["a.exr", "a.exr.sppm"]
    assert told == [f"wrote {tmp_path / 'a.exr'}: 20 iterations"]
    assert sppm.merge([tmp_path / "a.exr.sppm"]).iterations == [(0, 20)]


def test_alpha_is_that_of_one_machine(client, tmp_path: Path) -> None:
    scene = balls(radius_schedule="global", iterations=12)
    job = Job(scene, tmp_path / "a.exr")
    farm(client, [job], block=3)
    # The driver may still hold the lock of its state file.
    sppm.merge([job.state], tmp_path / "b.sppm")
    film = sppm.Render.resume(tmp_path / "b.sppm").result(progress=False)
    assert film == sppm.render(scene, progress=False) and film.alpha is not None
    assert sppm.compare(film, job.output).identical


def test_it_goes_on_from_its_state(client, tmp_path: Path) -> None:
    scene = small(seed=31)
    job = Job(scene, tmp_path / "a.exr")
    sppm.render_part(scene, 4, 9, job.state)
    told = farm(client, [job], block=2)
    assert told[0] == f"going on from {job.state} after 5 of 20 iterations"
    assert np.array_equal(sppm.Film.load(tmp_path / "a.exr").radiance, whole(scene))
    # And on to more.
    more = small(seed=31, iterations=23)
    farm(client, [Job(more, tmp_path / "a.exr")])
    assert np.array_equal(sppm.Film.load(tmp_path / "a.exr").radiance, whole(more))


def test_files_are_free_once_a_farm_has_ended(client, tmp_path: Path) -> None:
    """Whoever still holds frames of it, as tracebacks do."""
    frames: list[Any] = []
    job = Job(small(seed=33, iterations=2), tmp_path / "a.exr")
    Driver(client, tell=lambda _: frames.append(sys._getframe())).run([job])
    assert frames and _sppm.Lock(os.fspath(job.state))
    bad = Job(small(seed=9), tmp_path / "b.exr")
    sppm.render_part(small(seed=8), 0, 2, bad.state)
    with pytest.raises(sppm.InputError, match="of another render") as refused:
        Driver(client, tell=frames.append).run([Job(small(seed=10, iterations=2), tmp_path / "c.exr"), bad])
    assert refused.traceback
    assert all(_sppm.Lock(os.fspath(tmp_path / name)) for name in ("b.exr.sppm", "c.exr.sppm"))


def test_a_checkpoint_may_be_all_that_is_asked_for(client, tmp_path: Path) -> None:
    scene = small(seed=32, iterations=3)
    farm(client, [Job(scene, tmp_path / "a.sppm")])
    assert [file.name for file in tmp_path.iterdir()] == ["a.sppm"]
    assert sppm.merge([tmp_path / "a.sppm"]).iterations == [(0, 3)]


def test_a_state_of_another_render_is_refused(client, tmp_path: Path) -> None:
    job = Job(small(seed=8), tmp_path / "a.exr")
    sppm.render_part(small(seed=9), 0, 2, job.state)
    before = job.state.read_bytes()
    with pytest.raises(sppm.InputError, match="a.exr.sppm is of another render"):
        farm(client, [job])
    with pytest.raises(sppm.InputError, match="holds iterations up to 2, not 1; ask for"):
        farm(client, [Job(small(seed=9, iterations=1), tmp_path / "a.exr")])
    assert job.state.read_bytes() == before
    # However few of them it holds, it is of more.
    sppm.render_part(small(seed=9), 6, 8, tmp_path / "b.exr.sppm")
    with pytest.raises(sppm.InputError, match="holds iterations up to 8, not 4"):
        farm(client, [Job(small(seed=9, iterations=4), tmp_path / "b.exr")])
    sppm.render_part(small(seed=9), 0, 2, tmp_path / "first.sppm")
    sppm.merge([tmp_path / "b.exr.sppm", tmp_path / "first.sppm"], tmp_path / "c.exr.sppm")
    with pytest.raises(sppm.InputError, match="holds iterations up to 8, not 4"):
        farm(client, [Job(small(seed=9, iterations=4), tmp_path / "c.exr")])


def test_a_second_driver_is_refused(client, tmp_path: Path) -> None:
    job = Job(small(seed=21, iterations=1), tmp_path / "a.exr")
    lock = _sppm.Lock(str(job.state))
    with pytest.raises(sppm.FileError, match="a.exr.sppm: is in use by another render"):
        farm(client, [job])
    del lock
    farm(client, [job])
    # And the first one has let go of it.
    farm(client, [Job(small(seed=21, iterations=2), tmp_path / "a.exr")])


def test_settings_are_chosen_as_by_render(tmp_path: Path) -> None:
    size = {"width": 32, "height": 24, "seed": 3}
    (job,) = jobs_of(["cornell"], tmp_path / "a.exr", {**size, "iterations": 2}, [])
    render = sppm.Scene.load("cornell")
    render.settings = render.settings.replace(**size, radius_schedule="global")
    film = sppm.render(render, quality="good", iterations=2, progress=False)
    assert vars(job.scene.settings) == {**film.metadata["settings"], "radius_pilots": 0, "radius_clearance": 0}
    assert job.scene.settings.glint_samples > 1 and "--glint-samples" in job.chosen.split()
    assert job.chosen.startswith("quality good: --photons ") and "-n" not in job.chosen.split()
    # The same again; and what is given is not chosen.
    (again,) = jobs_of(["cornell"], tmp_path / "a.exr", {**size, "iterations": 2}, [])
    assert again.name == job.name
    (given, _) = jobs_of(["cornell"], tmp_path, {**size, "max_depth": 7}, ["radius=3,4"], "draft")
    assert (given.scene.settings.max_depth, given.scene.settings.initial_radius) == (7, 3.0)
    assert "--depth" not in given.chosen and "--radius" not in given.chosen and "-n" in given.chosen.split()
    (paper,) = jobs_of(["cornell"], tmp_path / "a.exr", {}, [], "paper")
    assert (paper.scene.settings.iterations, paper.chosen) == (6, "")
    # A scene that states its settings keeps them.
    small("cornell").save(tmp_path / "b.toml")
    (own,) = jobs_of([str(tmp_path / "b.toml")], None, {}, [])
    assert own.scene.settings == small("cornell").settings and not own.chosen
    # One that leaves its photons to be chosen keeps its depth, and one that leaves its depth its photons.
    text = small("cornell", max_depth=3, photons_per_iteration=1234).to_toml()
    for option, left, stated, kept in [
        ("--photons", "photons_per_iteration", "max_depth", 3),
        ("--depth", "max_depth", "photons_per_iteration", 1234),
    ]:
        lines = [f'{left} = "auto"' if line.startswith(left) else line for line in text.splitlines()]
        (tmp_path / "c.toml").write_text("\n".join(lines))
        (job,) = jobs_of([str(tmp_path / "c.toml")], None, {}, [])
        assert getattr(job.scene.settings, stated) == kept
        assert [word for word in job.chosen.split() if word.startswith("--")] == [option]
    # A quality that the file states is that of what is chosen, and one that is given goes before it.
    chosen = ("iterations", "photons_per_iteration", "max_depth", "initial_radius")
    lines = [line for line in text.splitlines() if not line.startswith(chosen)]
    for quality in ("draft", "good", "final"):
        stated = [f'{line}\nquality = "{quality}"' if line == "[settings]" else line for line in lines]
        (tmp_path / "d.toml").write_text("\n".join(stated))
        (job,) = jobs_of([str(tmp_path / "d.toml")], None, {}, [])
        for other in ("draft", "final"):
            (given,) = jobs_of([str(tmp_path / "d.toml")], None, {}, [], other)
            assert given.chosen.startswith(f"quality {other}: -n ")
        (tmp_path / "d.toml").write_text("\n".join(lines))
        (right,) = jobs_of([str(tmp_path / "d.toml")], None, {}, [], quality)
        assert job.scene.settings == right.scene.settings and job.chosen == right.chosen
        assert job.chosen.startswith(f"quality {quality}: -n ")


class Seen:
    """A viewer that notes what it is shown."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self.shown: list[tuple[int, int]] = []
        self.told: list[tuple[int, int]] = []

    def begin(self, name: str) -> None:
        self.names.append(name)

    def wants(self, is_new: bool) -> bool:
        return is_new

    def tell(self, done: tuple[int, int], photons: int, seconds: float, workers: int) -> None:
        self.told.append(done)

    def show(self, file: str, iterations: int, seconds: float) -> None:
        done = sum(stop - start for start, stop in sppm.merge([file]).iterations)
        self.shown.append((done, iterations))


def test_the_viewer_is_shown_what_is_stored(client, tmp_path: Path) -> None:
    seen = Seen()
    jobs = [Job(small(seed=40, iterations=8), tmp_path / "a.exr"), Job(small(seed=41, iterations=6), tmp_path / "b.exr")]
    farm(client, jobs, block=1, viewer=seen)
    assert set(seen.names) == {"a.exr", "b.exr"}
    assert {(8, 8), (6, 6)} <= set(seen.shown)
    # Nothing is shown twice in a row, and all is told.
    assert all(a != b for a, b in zip(seen.shown, seen.shown[1:], strict=False))
    assert seen.told


def test_the_page_of_a_farm(tmp_path: Path) -> None:
    """The command prints the address first; the page asks for its token."""
    small(iterations=400, seed=50).save(tmp_path / "a.toml")
    words = [sys.executable, "-m", "sppm.farm", "a.toml", "--workers=1", "--view", "--no-open", "--quiet"]
    with subprocess.Popen(words, cwd=tmp_path, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        try:
            assert process.stdout is not None
            address = process.stdout.readline().strip()
            assert address.startswith("http://127.0.0.1:")
            with urllib.request.urlopen(address, timeout=30) as page:
                assert b"sppm" in page.read()
            with pytest.raises(urllib.error.HTTPError):
                urllib.request.urlopen(address[:-3] + "xx/", timeout=30)
        finally:
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=60)
    assert process.returncode == 130


def texts(address: str) -> Iterator[dict[str, Any]]:
    """What a page at `address` is told over its websocket (RFC 6455)."""
    place = urllib.parse.urlsplit(address)
    assert place.hostname and place.port
    with socket.create_connection((place.hostname, place.port), timeout=30) as peer, peer.makefile("rb") as stream:
        headers = {"Host": place.netloc, "Connection": "Upgrade", "Upgrade": "websocket", "Sec-WebSocket-Version": "13"}
        headers["Sec-WebSocket-Key"] = base64.b64encode(bytes(16)).decode()
        lines = [f"GET {place.path}socket HTTP/1.1", *(f"{name}: {value}" for name, value in headers.items()), "", ""]
        peer.sendall("\r\n".join(lines).encode())
        assert b" 101 " in stream.readline()
        while stream.readline().strip():
            pass
        while True:
            kind, length = stream.read(2)
            if length >= 126:
                length = int.from_bytes(stream.read(2 if length == 126 else 8), "big")
            body = stream.read(length)
            if kind & 15 == 1:
                yield json.loads(body)


def test_a_page_is_told_how_far_a_farm_is() -> None:
    """Between two pictures too."""
    viewer = _sppm.Viewer("a.exr", (None, None), None)
    viewer.tell((3, 8), 12_345, 2.5, 4)
    told = next(text for text in texts(viewer.address) if text["type"] == "status")
    figures = {"iterations": 3, "limit": 8, "photons": 12_345, "seconds": 2.5, "workers": 4}
    assert {name: told[name] for name in figures} == figures


def test_sweeps_and_folders(client, tmp_path: Path) -> None:
    small("mirror").save(tmp_path / "one.toml")
    small("motion").save(tmp_path / "two.toml")
    jobs = jobs_of([str(tmp_path)], tmp_path / "out", {"iterations": 3}, ["radius=0.5,1", "seed=1,2"])
    assert len(jobs) == 8
    farm(client, jobs)
    assert (tmp_path / "out" / "one-initial_radius-0.5-seed-2.png").exists()
    scene = small("motion", iterations=3, initial_radius=1.0, seed=2)
    last = sppm.Film.load(tmp_path / "out" / "two-initial_radius-1-seed-2.png").to_srgb()
    sppm.render(scene, progress=False).save(tmp_path / "last.png")
    assert np.array_equal(last, sppm.Film.load(tmp_path / "last.png").to_srgb())


@pytest.mark.parametrize(
    ("sweep", "why"),
    [("radius", "name a setting"), ("size=1", "name a setting"), ("seed=1,x", "'x' is not a value of seed")],
)
def test_sweeps_that_are_none(sweep: str, why: str) -> None:
    with pytest.raises(sppm.InputError, match=why):
        jobs_of(["cornell"], None, {}, [sweep])


def test_a_folder_without_scenes_is_refused(tmp_path: Path) -> None:
    with pytest.raises(sppm.InputError, match="no scene file"):
        jobs_of([str(tmp_path)], None, {}, [])


@pytest.mark.parametrize(
    ("options", "why"),
    [
        ({"memory_limit": 1}, "memory_limit: the render needs up to"),
        ({"threads": 0}, "threads is 0"),
        ({"engine": "gpu"}, 'engine "gpu": there is no such'),
        ({"engine": "reference", "lanes": "avx2"}, "lanes: engine reference has no lanes"),
    ],
)
def test_parts_heed_the_options_of_a_render(options: dict[str, Any], why: str, tmp_path: Path) -> None:
    with pytest.raises(sppm.InputError, match=why):
        sppm.render_part(small(), 0, 1, tmp_path / "a.sppm", **options)
    assert not (tmp_path / "a.sppm").exists()


class Mixed:
    """Tasks whose blocks are rendered on whatever lanes there are, in turns."""

    versions, pack, hand_on, add_parts = tasks.versions, tasks.pack, tasks.hand_on, tasks.add_parts

    @staticmethod
    def render_block(packed: bytes, name: str, start: int, stop: int, *_: Any) -> bytes:
        with tempfile.TemporaryDirectory() as folder:
            file = Path(folder, "part.sppm")
            kinds = _sppm.lanes()
            scene = sppm.Scene.parse(zlib.decompress(packed).decode())
            lanes: Any = kinds[start % len(kinds)]
            sppm.render_part(scene, start, stop, file, lanes=lanes, threads=1)
            return file.read_bytes()


class Random(Driver):
    """A driver that gives out blocks of random sizes."""

    def _size(self, work: Any) -> int:
        return random.randint(1, 6)


@pytest.mark.parametrize("workers", [1, 2, 4, 7])
def test_any_workers_blocks_and_lanes_give_one_digest(workers: int, tmp_path: Path) -> None:
    scene = small(seed=60, iterations=60)
    with client_of(workers, None) as client:
        Random(client, tell=lambda text: None, tasks=Mixed).run([Job(scene, tmp_path / "a.exr")])
    digest = hashlib.sha256(sppm.Film.load(tmp_path / "a.exr").radiance.tobytes()).hexdigest()
    assert digest == hashlib.sha256(whole(scene).tobytes()).hexdigest()
    assert len(_sppm.lanes()) > 1


class Failing:
    """Tasks of which some fail."""

    versions, pack, hand_on, add_parts = tasks.versions, tasks.pack, tasks.hand_on, tasks.add_parts

    @staticmethod
    def render_block(packed: bytes, name: str, start: int, *rest: Any) -> bytes:
        raise sppm.RenderError(f"no {start}")


def test_a_block_that_always_fails_ends_the_farm(client, tmp_path: Path) -> None:
    with pytest.raises(FarmError, match=r"iterations 0\.\.20 of .* failed 4 times: no 0"):
        farm(client, [Job(small(seed=77), tmp_path / "a.exr")], block=20, tasks=Failing)


def test_workers_of_another_light_transport_get_no_work(client, tmp_path: Path) -> None:
    told: list[str] = []
    driver = Driver(client, tell=told.append, transport=_sppm.TRANSPORT + 1)
    until = time.monotonic() + 30.0
    while len(told) < 2 and time.monotonic() < until:
        driver._look_at_workers()
        time.sleep(0.05)
    assert len(told) == 2 and all("gets no work" in line for line in told)
    assert driver._good == []
    with pytest.raises(sppm.RenderError, match="light transport"):
        tasks.render_block(tasks.pack(small()), "x", 0, 1, 1, _sppm.TRANSPORT + 1)


def test_a_damaged_part_is_found() -> None:
    scene = small(seed=5)
    good, other = (tasks.render_block(tasks.pack(scene), "damage", k, k + 1, 1, _sppm.TRANSPORT) for k in (0, 1))
    damaged = bytearray(good)
    damaged[-50] ^= 1
    with pytest.raises(sppm.Error, match="checksum"):
        tasks.add_parts([bytes(damaged), other])
    assert tasks.add_parts([good, other]) != good


KILLS = int(os.environ.get("SPPM_FARM_KILLS", "4"))
"""Workers that are killed."""


def test_workers_may_be_killed(tmp_path: Path) -> None:
    """Each kill loses at most the block that was being rendered, on the average, and the image is that of one machine."""
    words = [str(Path(__file__).with_name("farm_kills.py")), "--drivers=0", f"--kills={KILLS}", f"--iterations={20 * KILLS + 100}"]
    ended = subprocess.run([sys.executable, *words], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stdout + ended.stderr


def test_the_driver_may_be_killed(tmp_path: Path) -> None:
    """With its workers, each time that it has stored something; what is stored is not rendered again."""
    small(iterations=400, seed=4, photons_per_iteration=20_000).save(tmp_path / "a.toml")
    words = [sys.executable, "-m", "sppm.farm", "a.toml", "-o", "a.exr", "--workers=2", "--every=0.2", "--block=5"]
    state = tmp_path / "a.exr.sppm"
    begins = []
    for _ in range(2):
        before = state.stat().st_mtime_ns if state.exists() else None
        process = subprocess.Popen(words, cwd=tmp_path, stderr=subprocess.PIPE, text=True, start_new_session=True)
        while not state.exists() or state.stat().st_mtime_ns == before:
            assert process.poll() is None, f"ended before it was killed: {process.communicate()[1]}"
            time.sleep(0.01)
        os.killpg(process.pid, signal.SIGKILL)
        begins.append(process.communicate()[1])
    ended = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert ended.returncode == 0, ended.stderr
    assert "going on from" not in begins[0]
    going_on = re.compile(r"going on from a\.exr\.sppm after (\d+) of 400 iterations")
    [first], [second] = (going_on.findall(said) for said in (begins[1], ended.stderr))
    assert 0 < int(first) < int(second) < 400
    scene = sppm.Scene.load(tmp_path / "a.toml")
    assert np.array_equal(sppm.Film.load(tmp_path / "a.exr").radiance, whole(scene))


def run(*words: object, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "sppm.farm", *map(str, words)], cwd=cwd, capture_output=True, text=True, check=False
    )


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["nothing.toml"], "nothing.toml"),
        (["cornell", "--workers=0"], "--workers 0 must be at least 1"),
        (["cornell", "--workers=2", "--scheduler=tcp://x:1"], "leave out one of the two"),
        (["cornell", "--width=0"], "width is 0"),
        (["cornell", "--tls-ca=none.pem"], "none.pem: there is no such file"),
        (["cornell", f"--tls-ca={__file__}"], "TLS needs --tls-ca and --tls-cert, and --tls-key"),
        (["cornell", f"--tls-key={__file__}", f"--tls-cert={__file__}"], "TLS needs --tls-ca and --tls-cert"),
        (["cornell", "--port=80"], "--port is of the page; ask for it by --view"),
        (["cornell", "--view", "--port=0"], "--port 0 must be from 1 to 65535"),
        (["cornell", "--view", "--listen=here"], "--listen here is no address of a machine"),
        (["cornell", "--display=x:y"], "--display x:y: write a host and a port"),
    ],
)
def test_bad_input_is_one_line(words: list[str], why: str, tmp_path: Path) -> None:
    ended = run(*words, cwd=tmp_path)
    assert ended.returncode == 2, ended.stderr
    assert why in ended.stderr and ended.stderr.count("\n") == 1 and "Traceback" not in ended.stderr, ended.stderr


def certificates(folder: Path, name: str) -> dict[str, Path]:
    """An authority with one certificate, as files."""
    from distributed import Security

    security = Security.temporary()
    files = {}
    for key, part in {"ca": "tls_ca_file", "certificate": "tls_client_cert", "key": "tls_client_key"}.items():
        files[key] = folder / f"{name}-{key}.pem"
        files[key].write_text(str(getattr(security, part)))
    return files


def is_refused(address: str, security: Any) -> bool:
    """Whether a client with this security cannot connect."""
    from distributed import Client

    for _ in range(3):
        try:
            Client(address, security=security, timeout=3, set_as_default=False).close()
        except AssertionError:
            # Dask's own: on a busy machine its event loop may take longer to start than it waits for.
            continue
        except (OSError, TypeError, ValueError, RuntimeError):
            return True
        return False
    return False


def test_tls(tmp_path: Path) -> None:
    from distributed import Security

    ours, theirs = certificates(tmp_path, "ours"), certificates(tmp_path, "theirs")
    scene = small(seed=6)
    with client_of(1, None, **ours) as client:
        address = client.scheduler_info()["address"]
        assert address.startswith("tls://")
        assert all(worker.startswith("tls://") for worker in client.scheduler_info()["workers"])
        with client_of(None, address, **ours) as second:
            Driver(second, tell=lambda text: None).run([Job(scene, tmp_path / "a.exr")])
        # Without a certificate, or with one of another authority, nobody gets in.
        other = Security(
            require_encryption=True,
            tls_ca_file=str(ours["ca"]),
            tls_client_cert=str(theirs["certificate"]),
            tls_client_key=str(theirs["key"]),
        )
        for security in (None, other):
            assert is_refused(address, security)
    assert np.array_equal(sppm.Film.load(tmp_path / "a.exr").radiance, whole(scene))


def test_what_is_missing() -> None:
    assert without((0, 10), []) == [(0, 10)]
    assert without((0, 10), [(0, 3), (3, 5), (7, 8)]) == [(5, 7), (8, 10)]
    assert without((0, 10), [(0, 10)]) == []
    assert without((0, 2), [(0, 1), (1, 4)]) == []


def test_ranges_are_joined() -> None:
    assert joined([]) == []
    assert joined([(4, 6), (0, 2), (2, 3), (6, 9)]) == [(0, 3), (4, 9)]


class Slow:
    """Tasks of which the first for iteration 7 takes longer than anybody waits."""

    versions, pack, hand_on, add_parts = tasks.versions, tasks.pack, tasks.hand_on, tasks.add_parts

    @staticmethod
    def render_block(packed: bytes, name: str, start: int, *rest: Any) -> bytes:
        from distributed import get_worker

        if str(get_worker().get_current_task()).endswith("-7-8"):
            time.sleep(120.0)
        return tasks.render_block(packed, name, start, *rest)


def test_slow_blocks_are_given_out_twice(client, tmp_path: Path) -> None:
    scene = small(seed=12, iterations=12)
    told = farm(client, [Job(scene, tmp_path / "a.exr")], block=1, tasks=Slow)
    assert any("take long" in line for line in told), told
    assert np.array_equal(sppm.Film.load(tmp_path / "a.exr").radiance, whole(scene))
