"""The driver: gives blocks of iterations to workers, and adds up what comes back.

    while iterations are missing:
        give each worker a block to render, and another to begin with next
        once some blocks are done: have workers add them up, as a tree
        once a tree is added up: add it to the state file, and write the image

Blocks that come back stay on their workers until the sum that they are in is in the state file. So a worker that is lost
takes with it the block that it renders, and those that it has rendered since the last sum; Dask renders them again. Blocks are
therefore added as soon as the sum before is stored: each by itself if they come slowly, and many together if they come
faster than the driver can store them. The driver keeps ranges of iterations alone. All that it knows is in the state file,
so it may be killed at any time.
"""

from __future__ import annotations

import importlib
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, cast

import sppm
from sppm import _sppm

from . import _tasks
from ._jobs import Job, Range

_TICK = 0.25
"""Seconds between two looks at what is going on."""
_LOOK = 1.0
"""Seconds between two looks at who is there; with more than _MANY workers more, in proportion."""
_MANY = 200
"""So many workers, or tasks, are many: each look at them takes time."""
_SHORT = 10.0
"""Seconds after which workers of this machine are replaced that have not come back."""
_FAN = 4
"""Parts that are added by one task."""
_DIRECT = 8
"""Parts that the driver adds up itself; to leave more of them to workers saves its network."""
_AT_ONCE = 16
"""Workers whose answers are taken at the same time."""
_FETCH = 5.0
"""Seconds in which a result arrives, unless it was lost just now."""
_ATTEMPTS = 4
"""How often a block is given out that fails."""
_SLOW = 4.0
"""A block that takes so many times as long as others is given out once more."""
_STORING = 0.1
"""The share of the driver's time that goes into adding sums to state files, at most."""
_LATE = 5.0
"""Seconds after which a sum is late."""
_AHEAD = 2
"""Blocks that a worker has: one that it renders, and the next."""


class FarmError(sppm.RenderError):
    """A farm cannot go on. What is done is in the state files."""


FarmError.__module__ = "sppm.farm"


@dataclass
class Block:
    """Some iterations of a job, and the task that renders them."""

    job: Work
    range: Range
    future: Any
    given: float
    attempt: int = 0
    worker: str = ""
    """The worker that it was meant for; Dask may move it."""
    fetched: int = 0
    """How often it did not arrive."""
    twin: Any = None
    """The same once more, if the first is slow."""

    @property
    def count(self) -> int:
        return self.range[1] - self.range[0]


@dataclass
class Sum:
    """Blocks that are being added up."""

    blocks: list[Block]
    roots: list[Any]
    """What is left to be added by the driver."""
    inner: list[Any]
    """The tasks below them."""
    begun: float


@dataclass
class Work:
    """A job under way."""

    job: Job
    missing: list[Range]
    ready: list[Block] = field(default_factory=list["Block"])
    next_sum: float = 0.0
    """When the next sum may begin."""
    sums: list[Sum] = field(default_factory=list["Sum"])
    scene: Any = None
    written: float = 0.0
    stored: float = 0.0
    """When a sum was stored last."""
    lock: Any = None

    @property
    def done(self) -> int:
        return sum(stop - start for start, stop in self.job.done)

    def take(self, count: int) -> Range | None:
        """The next iterations, at most so many."""
        if not self.missing:
            return None
        start, stop = self.missing.pop(0)
        if stop - start > count:
            self.missing.insert(0, (start + count, stop))
            stop = start + count
        return start, stop


Tell = Callable[[str], None]


class Driver:
    """Renders jobs on the workers of a Dask client."""

    def __init__(
        self,
        client: Any,
        *,
        threads: int | None = 1,
        block: int | None = None,
        seconds: float = 10.0,
        every: float = 10.0,
        tell: Tell = print,
        show: Callable[[str], None] | None = None,
        viewer: _sppm.Viewer | None = None,
        transport: int = _sppm.TRANSPORT,
        tasks: Any = _tasks,
    ) -> None:
        """``threads``: those that a block is rendered on. ``block``: iterations of a block; by default as many as take about
        ``seconds``. ``every``: seconds between two images. ``tell`` is given messages, ``show`` the progress; ``viewer`` shows
        the pictures. ``transport``: the version of the light transport that workers must compute. ``tasks``: what runs on
        them, the module ``_tasks`` or a stand-in.
        """
        self._client = client
        self._dask: Any = importlib.import_module("distributed")
        self._tasks = tasks
        self._threads = threads
        self._block = block
        self._seconds = seconds
        self._every = every
        self._tell = tell
        self._show = show
        self._viewer = viewer
        self._viewed: tuple[Work | None, int] = (None, 0)
        self._shown_whole: set[int] = set()
        self._told = 0.0
        self._transport = transport
        self._blocks: list[Block] = []
        self._workers: dict[str, Any] = {}
        self._look_next = 0.0
        # Of a cluster on this machine; others see to their workers themselves.
        self._wanted = len(client.cluster.workers) if client.cluster is not None else 0
        self._short_since = time.monotonic()
        self._finished: list[tuple[float, int]] = []
        self._durations: list[float] = []
        self._begun = time.monotonic()
        self.repeated = 0
        """Blocks that were given out again."""

    def run(self, jobs: list[Job]) -> None:
        """Renders all jobs, each from where its state file is.

        Raises FarmError if a block fails again and again, InputError if a state file is of another render, and FileError if
        another driver works on it.
        """
        works: list[Work] = []
        for job in jobs:
            lock = _sppm.Lock(os.fspath(job.state))
            job.load()
            works.append(Work(job, _without((0, job.iterations), job.done), lock=lock))
            if job.done:
                self._tell(f"going on from {job.state} after {works[-1].done} of {job.iterations} iterations")
        try:
            waiting = list(works)
            while waiting:
                self._look_at_workers()
                self._give(waiting)
                self._wait(waiting)
                self._collect()
                for work in waiting:
                    self._mind_losses(work)
                    self._add(work)
                    self._keep(work)
                for work in [work for work in waiting if not _left(work, self._blocks)]:
                    waiting.remove(work)
                    self._write_image(work)
                    work.scene = work.lock = None
                    self._tell(f"wrote {work.job.output}: {work.done} iterations")
                self._show_progress(works)
                self._show_picture(works)
        finally:
            for work in works:
                work.lock = None
            self._client.cancel([block.future for block in self._blocks], force=True)

    # Workers.

    def _look_at_workers(self) -> None:
        """Notes who has come and who has gone, and whether they compute what is asked for."""
        self._ask()
        if time.monotonic() < self._look_next:
            return
        self._look_next = time.monotonic() + _LOOK * max(1.0, len(self._workers) / _MANY)
        now = self._client.scheduler_info(n_workers=-1)["workers"]
        cluster = self._client.cluster
        if cluster is None or len(now) >= self._wanted:
            self._short_since = time.monotonic()
        elif time.monotonic() - self._short_since > _SHORT:
            # Those that die while they start are not started again by Dask.
            self._short_since = time.monotonic()
            self._tell(f"{len(now)} of {self._wanted} workers are left; others are started")
            cluster.scale(len(now))
            cluster.scale(self._wanted)
        for address in [address for address in self._workers if address not in now]:
            del self._workers[address]
            self._tell(f"worker {address} is gone; what it had is rendered again")
        new = [address for address in now if address not in self._workers]
        room = _MANY - sum(not isinstance(asked, bool) for asked in self._workers.values())
        for address in new[: max(room, 0)]:
            # By a task, as a call would wait for workers that have just gone.
            self._workers[address] = self._client.submit(
                self._tasks.versions, workers=[address], allow_other_workers=False, pure=False, priority=10
            )
        if len(new) > room:
            self._look_next = 0.0
        self._ask()

    def _ask(self) -> None:
        """Takes the answers of new workers."""
        answered = {address: asked for address, asked in self._workers.items()
                    if not isinstance(asked, bool) and not _is_under_way(asked)}
        if not answered:
            return
        with ThreadPoolExecutor(_AT_ONCE) as threads:
            outcomes = list(threads.map(_outcome, answered.values()))
        for address, found in zip(answered, outcomes, strict=True):
            if found is None:
                continue
            # Of the package, and of the light transport.
            versions = cast("tuple[str, int] | None", found if isinstance(found, tuple) else None)
            is_good = versions is not None and versions[1] == self._transport
            self._workers[address] = is_good
            if versions is None:
                self._tell(f"worker {address} gets no work: it cannot import sppm ({found})")
            elif not is_good:
                self._tell(f"worker {address} gets no work: its sppm {versions[0]} computes version {versions[1]} of the light "
                           f"transport, not {self._transport}")

    @property
    def _good(self) -> list[str]:
        return [address for address, is_good in self._workers.items() if is_good is True]

    @property
    def _bad(self) -> list[str]:
        return [address for address, is_good in self._workers.items() if is_good is False]

    # Blocks.

    def _give(self, works: list[Work]) -> None:
        """Gives blocks to workers that have fewer than two."""
        good = self._good
        loads = Counter(block.worker for block in self._blocks)
        places = [worker for depth in range(_AHEAD) for worker in good if loads[worker] <= depth]
        places = places[: max(0, _AHEAD * len(good) - len(self._blocks))]
        for work in works:
            while places:
                chosen = work.take(self._size(work))
                if chosen is None:
                    break
                worker = places.pop(0)
                future = self._submit(work, chosen, 0, worker)
                self._blocks.append(Block(work, chosen, future, time.monotonic(), worker=worker))
        if places:
            self._give_again()

    def _size(self, work: Work) -> int:
        """Iterations of the next block: at first one, soon as many as take about the seconds asked for, and towards the end
        fewer, so that all workers end together."""
        if self._block is not None:
            return self._block
        rate, workers = self._rate(), max(1, len(self._good))
        if rate is None:
            return 1
        left = sum(stop - start for start, stop in work.missing)
        # Short at first, so that there are pictures soon.
        seconds = min(self._seconds, (time.monotonic() - self._begun) / 4)
        return max(1, min(int(seconds * rate / workers), left // (2 * workers)))

    def _submit(self, work: Work, chosen: Range, attempt: int, worker: str = "") -> Any:
        """The task of a block. It is named by what it renders, so two that are alike are one. It is meant for ``worker``: by
        itself Dask would give it to one that has the scene already.
        """
        job, options = work.job, self._placed()
        preferred = {"workers": [worker], "allow_other_workers": True} if worker and not options else options
        if work.scene is None:
            packed = self._tasks.pack(job.scene)
            work.scene = self._client.submit(self._tasks.hand_on, packed, key=f"sppm-scene-{job.name}", **options)
        start, stop = chosen
        suffix = f"-{attempt}" if attempt else ""
        key = f"sppm-block-{job.name}-{start}-{stop}{suffix}"
        return self._client.submit(self._tasks.render_block, work.scene, job.name, start, stop, self._threads,
                                   self._transport, key=key, retries=0, **preferred)

    def _placed(self) -> dict[str, Any]:
        """Where tasks may run: anywhere, unless some workers are of another version."""
        return {"workers": self._good, "allow_other_workers": False} if self._bad else {}

    def _give_again(self) -> None:
        """There is nothing left to give: gives out once more the block that has taken by far too long."""
        if len(self._durations) < 3:
            return
        usual = sorted(self._durations)[len(self._durations) // 2]
        now = time.monotonic()
        for block in self._blocks:
            if block.twin is None and now - block.given > max(_SLOW * usual, 5.0):
                self._tell(f"iterations {block.range[0]}..{block.range[1]} take long; another worker renders them too")
                block.twin = self._submit(block.job, block.range, block.attempt + 100)
                self.repeated += 1

    def _wait(self, works: list[Work]) -> None:
        """Waits until something has ended, or for a moment."""
        futures: list[Any] = [future for block in self._blocks for future in (block.future, block.twin) if future is not None]
        futures += [root for work in works for total in work.sums for root in total.roots if _is_under_way(root)]
        if not futures or len(futures) > _MANY:
            time.sleep(_TICK)
            return
        try:
            with self._client.as_current():
                self._dask.wait(futures, timeout=_TICK, return_when="FIRST_COMPLETED")
        except TimeoutError:
            pass

    def _collect(self) -> None:
        """Takes the blocks that have ended."""
        now = time.monotonic()
        for block in list(self._blocks):
            if block.twin is not None and block.twin.status == "finished" and block.future.status != "finished":
                block.future, block.twin = block.twin, block.future
            if _is_under_way(block.future):
                continue
            status = block.future.status
            self._blocks.remove(block)
            if status == "finished":
                if block.twin is not None:
                    self._client.cancel([block.twin], force=True)
                    block.twin = None
                self._finished.append((now, block.count))
                self._durations = [*self._durations[-50:], now - block.given]
                block.job.ready.append(block)
            else:
                self._try_again(block, status)

    def _try_again(self, block: Block, status: str) -> None:
        """Gives out a block that has failed, unless it did so too often."""
        why = (_outcome(block.future) if status == "error" else None) or status
        where = f"iterations {block.range[0]}..{block.range[1]} of {block.job.job.output}"
        if block.attempt + 1 >= _ATTEMPTS:
            hint = "; the workers may lack memory" if type(why).__name__ == "KilledWorker" else ""
            raise FarmError(f"{where} failed {_ATTEMPTS} times{hint}: {why}")
        self._tell(f"{where} failed, and are given out again: {why}")
        self.repeated += 1
        attempt = block.attempt + 1
        future = self._submit(block.job, block.range, attempt)
        self._blocks.append(Block(block.job, block.range, future, time.monotonic(), attempt))

    # Sums.

    def _add(self, work: Work) -> None:
        """Begins the next sum, of the blocks that are done, once the last one is stored, but waits for none that is late: blocks
        in it may be rendered again.
        """
        now = time.monotonic()
        if not work.ready or now < work.next_sum or any(now - total.begun < _LATE for total in work.sums):
            return
        blocks, work.ready = work.ready, []
        level: list[Any] = [block.future for block in blocks]
        inner: list[Any] = []
        while len(level) > _DIRECT:
            inner += level
            # Before blocks that wait on the same worker.
            level = [self._client.submit(self._tasks.add_parts, level[at : at + _FAN], pure=True, priority=10, **self._placed())
                     for at in range(0, len(level), _FAN)]
        work.sums.append(Sum(blocks, level, inner, now))

    def _keep(self, work: Work) -> None:
        """Adds the sums that have ended to the state file; the blocks in them may then be forgotten."""
        for total in list(work.sums):
            if any(_is_under_way(root) for root in total.roots):
                continue
            work.sums.remove(total)
            began = time.monotonic()
            try:
                parts = self._fetch(total)
                if parts is None:
                    work.ready = [*total.blocks, *work.ready]
                    continue
                self._store(work, parts)
            except FarmError:
                raise
            except Exception as error:
                # Damaged: the blocks are rendered anew under other names.
                self._tell(f"a sum of {len(total.blocks)} blocks failed: {error}")
                for block in total.blocks:
                    self._client.cancel([block.future], force=True)
                    self._try_again(block, "a sum that failed")
                continue
            work.job.done = _joined([*work.job.done, *(block.range for block in total.blocks)])
            # At once: references to them may outlive this, in exceptions of Dask that have not been collected yet, and what is
            # referred to is rendered again when its worker is lost.
            for future in (*total.inner, *total.roots):
                future.release()
            work.stored = time.monotonic()
            work.next_sum = work.stored + (work.stored - began) * (1.0 / _STORING - 1.0)
            if time.monotonic() - work.written > self._every:
                self._write_image(work)

    def _fetch(self, total: Sum) -> list[bytes] | None:
        """What is left of a sum; ``None`` if it was lost before it came, and is to be added up again. Raises what a task of it
        raised, and FarmError if it does not come again and again."""
        # What is lost just now would be waited for until it is rendered again. Large ones get more time with every attempt.
        timeout = _FETCH * 4.0 ** max(block.fetched for block in total.blocks)
        try:
            return [root.result(timeout=timeout) for root in total.roots]
        except Exception as error:
            if any(root.status == "error" for root in total.roots):
                raise
            for block in total.blocks:
                block.fetched += 1
                if block.fetched > _ATTEMPTS:
                    raise FarmError(f"results of workers do not arrive: {error}") from error
            self._tell(f"a sum of {len(total.blocks)} blocks did not arrive, and is fetched again: {error}")
            return None

    def _mind_losses(self, work: Work) -> None:
        """Takes back blocks that were lost with their worker; Dask has them rendered again. A sum that has one is given up, as
        the other blocks in it need not wait for it, and could be lost meanwhile."""
        for total in [total for total in work.sums if any(_is_under_way(block.future) for block in total.blocks)]:
            work.sums.remove(total)
            work.ready = [*total.blocks, *work.ready]
        lost = [block for block in work.ready if _is_under_way(block.future)]
        for block in lost:
            block.given = time.monotonic()
        work.ready = [block for block in work.ready if block not in lost]
        self._blocks += lost

    def _store(self, work: Work, parts: list[bytes]) -> None:
        state = work.job.state
        with tempfile.TemporaryDirectory(prefix=".sppm-farm-", dir=state.parent) as folder:
            files = [Path(folder, f"{number}.sppm") for number in range(len(parts))]
            for file, part in zip(files, parts, strict=True):
                file.write_bytes(part)
            total = Path(folder, "sum.sppm")
            sppm.merge([state, *files] if state.exists() else files, total)
            os.replace(total, state)

    def _write_image(self, work: Work) -> None:
        if work.job.state.exists() and work.job.output.suffix != ".sppm":
            sppm.merge([work.job.state], work.job.output)
            work.written = time.monotonic()

    # Progress.

    def _rate(self) -> float | None:
        """Iterations per second, of late."""
        now = time.monotonic()
        self._finished = [(at, count) for at, count in self._finished if now - at < 120.0]
        if not self._finished:
            return None
        span = now - max(self._begun, self._finished[0][0] - self._seconds)
        return sum(count for _, count in self._finished) / max(span, 1e-3)

    def _show_progress(self, works: list[Work]) -> None:
        if self._show is None:
            return
        done, all_ = sum(work.done for work in works), sum(work.job.iterations for work in works)
        waiting = sum(block.count for work in works for block in work.ready)
        waiting += sum(block.count for work in works for total in work.sums for block in total.blocks)
        rate = self._rate()
        left = f", {_duration((all_ - done - waiting) / rate)} to go" if rate else ""
        images = f"{len(works)} images, " if len(works) > 1 else ""
        speed = f", {rate:.3g} iterations/s" if rate else ""
        self._show(f"{images}{done + waiting} of {all_} iterations, {len(self._good)} workers{speed}{left}")


    def _show_picture(self, works: list[Work]) -> None:
        """Shows what was stored last to those who look, and each image once it is whole."""
        if self._viewer is None:
            return
        whole = [work for work in works if work.done == work.job.iterations and id(work) not in self._shown_whole]
        for work in [*whole, max(works, key=lambda work: work.stored)]:
            self._show_work(self._viewer, work)

    def _show_work(self, viewer: _sppm.Viewer, work: Work) -> None:
        job, done, seconds = work.job, work.done, time.monotonic() - self._begun
        before, shown = self._viewed
        if work is not before:
            viewer.begin(job.output.name)
            before, shown = work, done if id(work) in self._shown_whole else 0
        if time.monotonic() - self._told > _LOOK:
            self._told = time.monotonic()
            photons = done * job.scene.settings.photons_per_iteration
            viewer.tell((done, job.iterations), photons, seconds, len(self._good))
        is_last = done == job.iterations and done != shown
        if done and (is_last or viewer.wants(done != shown)):
            viewer.show(os.fspath(job.state), job.iterations, seconds)
            shown = done
            if is_last:
                self._shown_whole.add(id(work))
        self._viewed = (before, shown)


def _is_under_way(future: Any) -> bool:
    """Whether a task has not ended, or its result was lost with its worker, so that Dask has it done again."""
    return future.status in ("pending", "lost")


def _outcome(future: Any) -> Any:
    """The result of a small task, or its exception; ``None`` if the worker that had it has just gone."""
    try:
        return future.exception(timeout=5) if future.status == "error" else future.result(timeout=5)
    except TimeoutError:
        return None
    except Exception as error:
        return error


def _left(work: Work, blocks: list[Block]) -> bool:
    """Whether anything of a job is left to be done."""
    return bool(work.missing or work.ready or work.sums or any(block.job is work for block in blocks))


def _without(whole: Range, done: list[Range]) -> list[Range]:
    """The ranges of ``whole`` between those that are done, which are in order."""
    missing: list[Range] = []
    start = whole[0]
    for first, stop in done:
        if first > start:
            missing.append((start, first))
        start = max(start, stop)
    if start < whole[1]:
        missing.append((start, whole[1]))
    return missing


def _joined(ranges: list[Range]) -> list[Range]:
    """The same iterations in order, in as few ranges as there can be."""
    joined: list[Range] = []
    for start, stop in sorted(ranges):
        if joined and joined[-1][1] == start:
            joined[-1] = (joined[-1][0], stop)
        else:
            joined.append((start, stop))
    return joined


def _duration(seconds: float) -> str:
    minutes, rest = divmod(int(max(seconds, 0.0)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}h{minutes:02}" if hours else f"{minutes}min {rest:02}s" if minutes else f"{rest}s"
