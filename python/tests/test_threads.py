"""Renders beside other threads, signals and processes."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from conftest import ENDLESS, SMALL

import sppm

PATIENCE = 60.0
"""Seconds after which something hangs."""


def late_ticks(seconds: float) -> float:
    """The share of ticks, one each 10 ms, that come so late that the next is due."""
    lateness: list[float] = []

    def tick() -> None:
        begin = time.perf_counter()
        for i in range(1, round(seconds * 100)):
            time.sleep(max(0.0, begin + i * 0.01 - time.perf_counter()))
            lateness.append(time.perf_counter() - begin - i * 0.01)

    thread = threading.Thread(target=tick)
    thread.start()
    thread.join(PATIENCE)
    return sum(late > 0.01 for late in lateness) / len(lateness)


OTHER = """
import sppm
with sppm.Render(sppm.Scene.load("cornell"), iterations=1 << 30, width=256, height=192, threads=1) as render:
    print(render.film.iterations > 0, flush=True)
    render.wait()
"""


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="the system cannot pause processes")
def test_other_threads_go_on(cornell) -> None:
    """A thread that ticks every 10 ms misses at most one tick in a hundred while a render runs and is watched.

    On a busy machine ticks are late anyway. So they are counted first while another process renders as much; only if
    none is late then, those beside a render of this process are judged.
    """
    MOST = 0.01
    judged: list[float] = []
    other = subprocess.Popen([sys.executable, "-c", OTHER], stdout=subprocess.PIPE, text=True)
    try:
        assert other.stdout is not None and other.stdout.readline() == "True\n"
        for _ in range(12):
            other.send_signal(signal.SIGCONT)
            is_quiet = late_ticks(1.0) == 0.0
            other.send_signal(signal.SIGSTOP)
            if not is_quiet:
                continue
            with sppm.Render(cornell, **{**ENDLESS, "width": 256, "height": 192}) as render:
                watching = threading.Thread(target=render.wait, args=(1.2,))
                watching.start()
                judged.append(late_ticks(1.0))
                watching.join(PATIENCE)
            if judged[-1] <= MOST:
                return
    finally:
        other.kill()
        other.communicate()
    if len(judged) < 5:
        pytest.skip("the machine is too busy to tell")
    pytest.fail(f"shares of late ticks: {judged}")


PROGRAM = """
import json, sys, time, sppm
scene = sppm.Scene.load("cornell")

def tell(progress):
    if progress.iteration >= 2 and not told:
        told.append(progress)
        print("ready", flush=True)

told = []
settings = dict(iterations=1 << 30, width={side}, height={side}, checkpoint={checkpoint!r}, progress=tell)
try:
    film = sppm.render(scene, **settings, interrupt={interrupt!r})
    how = "returned"
except KeyboardInterrupt as stopped:
    assert isinstance(stopped, sppm.Interrupted)
    film, how = stopped.film, "raised"
print(json.dumps([how, time.time(), film.iterations, float(film.radiance.mean())]))
"""


@pytest.mark.parametrize(("interrupt", "how", "side"), [("raise", "raised", 512), ("return", "returned", 64)])
def test_control_c_keeps_the_image(tmp_path: Path, interrupt: str, how: str, side: int) -> None:
    checkpoint = str(tmp_path / "a.sppm")
    program = PROGRAM.format(interrupt=interrupt, side=side, checkpoint=checkpoint)
    process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    assert process.stdout is not None and process.stdout.readline() == "ready\n"
    # Somewhere in an iteration.
    time.sleep(0.05)
    sent = time.time()
    process.send_signal(signal.SIGINT)
    printed, _ = process.communicate(timeout=PATIENCE)
    told, answered, iterations, mean = json.loads(printed)
    assert told == how
    assert iterations > 0 and mean > 0.1
    print(f"answered after {answered - sent:.3f} s")
    # A tenth of that on a quiet machine; on a busy one its threads wait for their turns.
    assert answered - sent < 2.0
    with sppm.Render.resume(checkpoint, iterations=iterations + 1) as resumed:
        assert resumed.result(progress=False).iterations == iterations + 1


def test_an_interruption_before_the_first_image_has_none(cornell, monkeypatch) -> None:
    def interrupted(*_: object) -> bool:
        raise KeyboardInterrupt

    with sppm.Render(cornell, paused=True) as render:
        # Signals cannot be timed before the first iteration.
        monkeypatch.setattr(render, "_check_free", lambda: None)
        monkeypatch.setattr("sppm._render.Bar.__enter__", interrupted)
        with pytest.raises(sppm.Interrupted) as caught:
            render.result(progress=False)
    assert caught.value.film is None
    assert "before its first iteration" in str(caught.value)


class Slow:
    """Stands for a render that takes its time to end, such as one that develops a large image or writes a checkpoint."""

    iterations = 5

    def __init__(self) -> None:
        self.may_end = threading.Event()
        self.stopped = self.is_interrupted = False

    def wait(self, seconds: float) -> bool:
        if not self.is_interrupted:
            self.is_interrupted = True
            raise KeyboardInterrupt
        return self.may_end.wait(seconds)

    def stop(self) -> None:
        self.stopped = True

    def progress(self) -> tuple[object, ...]:
        return (3, 5, 0.1, 0.3, 100, None, None, False, 0.0)

    def finish(self) -> tuple[str, str, None]:
        return "{}", "stop", None

    def take_image(self) -> tuple[object, ...]:
        return np.ones((2, 3, 3), np.float32), None, None, None, "{}"

    def warnings(self) -> list[str]:
        return []


def test_control_c_does_not_wait_for_the_image() -> None:
    slow = Slow()
    render = sppm.Render.adopt(slow, False)  # type: ignore[arg-type]
    with pytest.raises(sppm.Interrupted) as caught, render:
        render.result(progress=False)
    assert slow.stopped and not slow.may_end.is_set()
    assert "if there is one" in str(caught.value)
    # Python waits for this thread before it exits.
    assert any(not thread.daemon for thread in threading.enumerate() if thread is not threading.main_thread())
    slow.may_end.set()
    assert caught.value.film is not None and caught.value.film.width == 3
    assert "its image is the attribute film" in str(caught.value)


MANY = sppm.Scene.load("cornell").to_toml() + "\n".join(
    f"[[sphere]]\ncenter = [{i % 97}.5, {i % 89}.25, 300]\nradius = 0.01\nmaterial = 'm0000000000'" for i in range(60_000)
)
"""A scene that takes a while to be read."""


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="the system does not tell the names of threads")
@pytest.mark.parametrize("what", ["reading", "choosing"])
def test_control_c_is_answered_before_a_render_begins(what: str, cornell, tmp_path: Path) -> None:
    """When the handler of the signal runs, the work that it interrupts is not done yet."""
    working: list[bool] = []

    def interrupt(*_: object) -> None:
        working.append("work" in threads())
        raise KeyboardInterrupt

    before = signal.signal(signal.SIGALRM, interrupt)
    try:
        if what == "reading":
            signal.setitimer(signal.ITIMER_REAL, 0.03)
            with pytest.raises(KeyboardInterrupt):
                sppm.Scene.parse(MANY)
        else:
            signal.setitimer(signal.ITIMER_REAL, 0.1)
            with pytest.raises(sppm.Interrupted) as caught:
                sppm.render(cornell, quality="final", width=1000, height=800, progress=False)
            assert caught.value.film is None
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)
    assert working == [True]


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="the system does not tell the names of threads")
def test_work_that_is_interrupted_is_given_up(cornell) -> None:
    """Little more processor time is spent. That of this thread, which only waits and looks, does not count."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    def others() -> float:
        return time.process_time() - time.thread_time()

    def settle() -> float:
        while {"work", "render"} & set(threads()):
            time.sleep(0.002)
        return others()

    options = {"quality": "final", "width": 1000, "height": 800}
    begun = settle()
    with sppm.Render(cornell, **options, paused=True):
        pass
    whole = settle() - begun

    def after_interrupt() -> float:
        before = signal.signal(signal.SIGALRM, interrupt)
        try:
            signal.setitimer(signal.ITIMER_REAL, 0.02)
            with pytest.raises(sppm.Interrupted):
                sppm.render(cornell, **options, progress=False)
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
            signal.signal(signal.SIGALRM, before)
        interrupted = others()
        return settle() - interrupted

    # The least of three, as threads that wait for work on a busy machine take some of it as well.
    assert min(after_interrupt() for _ in range(3)) < whole / 2


def threads() -> list[str]:
    """The names of this process's threads."""
    names = []
    for path in Path("/proc/self/task").iterdir():
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):
            names.append(path.joinpath("comm").read_text().strip())
    return names


def test_a_loop_over_renders_ends_with_control_c(cornell) -> None:
    """As ``Interrupted`` is a ``KeyboardInterrupt``, ``except Exception`` does not keep the loop going."""
    with pytest.raises(KeyboardInterrupt):
        try:
            raise sppm.Interrupted(None)
        except Exception:  # noqa: BLE001
            pytest.fail("caught")


def in_child(work) -> int:
    """Runs ``work`` in a forked process, and returns its exit code; 99 if it hangs."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            signal.alarm(int(PATIENCE))
            work()
            code = 0
        finally:
            os._exit(code)
    _, status = os.waitpid(child, 0)
    return os.waitstatus_to_exitcode(status)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_fork_after_a_render_can_render(cornell, tmp_path: Path) -> None:
    right = sppm.render(cornell)
    sppm.compare(right, right)

    def work() -> None:
        film = sppm.render(cornell)
        assert film == right
        film.save(tmp_path / "child.exr")
        assert sppm.compare(film, right).identical

    assert in_child(work) == 0
    assert sppm.Film.load(tmp_path / "child.exr") == sppm.Film(right.radiance)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_fork_after_reading_can_read() -> None:
    """Readers use many threads, which a child does not have."""
    file = Path(__file__).parents[2] / "fixtures/particles/melt.dump"
    right = sppm.load_particles(file), sppm.Particles.load(file)

    def work() -> None:
        assert sppm.load_particles(file) == sppm.Scene.load(file) == right[0]
        assert sppm.load_particles(right[1], name="melt") == right[0]
        assert sppm.Scene.parse(right[0].to_toml()) == right[0]

    assert in_child(work) == 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="the system cannot fork")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_fork_during_a_render_leaves_it_to_the_parent(cornell) -> None:
    render = sppm.Render(cornell, **ENDLESS)
    film = render.film
    assert film is not None

    def work() -> None:
        for use in (lambda: render.film, render.stop, lambda: render.progress, lambda: render.is_over, render.close):
            with pytest.raises(sppm.RenderError, match="runs in the process that this one was forked from"):
                use()
        globals()["kept"] = None
        assert sppm.render(cornell).iterations == SMALL["iterations"]

    assert in_child(work) == 0

    def drop() -> None:
        nonlocal render
        del render

    assert in_child(drop) == 0
    assert not render.is_over
    render.close()


def test_many_renders_at_once_give_their_images(cornell) -> None:
    scenes = [cornell, *(sppm.Scene.load(name) for name in ("mirror", "surgery", "random"))]
    right = [sppm.render(scene, **SMALL, threads=1) for scene in scenes]
    films: dict[int, sppm.Film] = {}

    def work(i: int) -> None:
        films[i] = sppm.render(scenes[i % 4], **SMALL, threads=1 + i % 3)

    threads = [threading.Thread(target=work, args=(i,)) for i in range(16)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert len(films) == 16
    assert all(film == right[i % 4] for i, film in films.items())


def test_one_render_is_asked_from_many_threads(cornell) -> None:
    seen: list[int] = []
    with sppm.Render(cornell, **ENDLESS) as render:

        def ask() -> None:
            for _ in range(5):
                film = render.film
                assert film is not None
                seen.append(film.iterations)

        threads = [threading.Thread(target=ask) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(PATIENCE)
    assert len(seen) == 20 and min(seen) >= 1


def test_a_scene_is_changed_from_many_threads() -> None:
    scene = sppm.Scene()

    def add() -> None:
        for _ in range(50):
            scene.add_spheres([[1, 2, 3], [4, 5, 6]], 1, sppm.Diffuse(0.5))

    threads = [threading.Thread(target=add) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE)
    assert len(scene) == 400 and len(scene.materials) == 200
    assert sorted(set(scene.material_indices.tolist())) == list(range(200))


def test_a_scene_may_change_while_it_renders(cornell) -> None:
    right = sppm.render(cornell, iterations=3)
    with sppm.Render(cornell, iterations=3, paused=True) as render:
        render.iterate()
        cornell.remove_spheres(slice(None))
        cornell.camera = sppm.Camera()
        assert render.iterate(2) == right
