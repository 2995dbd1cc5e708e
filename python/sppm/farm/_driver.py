"""The driver: gives blocks of iterations to workers, and adds up what comes back.

    while iterations are missing:
        give each worker a block to render, and another to begin with next
        add the largest of the parts that are there to the state file, and write the image
        if there are many more: have workers add up the smallest, four at a time; each sum is a part again

What comes back stays on its workers until it is in the state file. So a worker that is lost takes with it the block that it
renders, and what it has of others; Dask makes it again. Blocks are therefore stored as soon as what came before is stored: each
by itself if they come slowly; and if they come faster than the driver can store them, sums of them. A sum is of four parts, and
nobody waits for it: on a worker that renders it may take as long as a block, and of a thousand workers some are lost
meanwhile. The driver keeps ranges of iterations alone. All that it knows is in the state file, so it may be killed at any time.
"""

from __future__ import annotations

import importlib
import os
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any, cast

import sppm
from sppm import _sppm

from . import _tasks
from ._jobs import Job, Range
from ._work import Block, Part, Work, joined, without

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
"""Parts that the driver adds up itself at a time; to leave more of them to workers saves its network."""
_AT_ONCE = 16
"""Workers whose answers are taken at the same time."""
_FETCH = 5.0
"""Seconds in which a result arrives, unless it was lost just now."""
_ATTEMPTS = 4
"""How often a block is given out that fails."""
_SLOW = 4.0
"""A block that takes so many times as long as others is given out once more."""
_STORING = 0.1
"""The share of the driver's time that goes into adding parts to state files, at most."""
_AHEAD = 2
"""Blocks that a worker has: one that it renders, and the next."""


class FarmError(sppm.RenderError):
    """A farm cannot go on. What is done is in the state files."""


FarmError.__module__ = "sppm.farm"


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
        try:
            for job in jobs:
                # No variable has the lock: a traceback that Dask keeps may hold them until garbage is collected.
                works.append(Work(job, [], lock=_sppm.Lock(os.fspath(job.state))))
                job.load()
                works[-1].missing = without((0, job.iterations), job.done)
                if job.done:
                    self._tell(f"going on from {job.state} after {works[-1].done} of {job.iterations} iterations")
            waiting = list(works)
            while waiting:
                self._look_at_workers()
                self._give(waiting)
                self._wait(waiting)
                self._collect()
                for work in waiting:
                    self._mind_losses(work)
                    self._keep(work)
                    self._add(work)
                for work in [work for work in waiting if not work.is_left(self._blocks)]:
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
        futures += [total.future for work in works for total in work.sums]
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
                block.job.ready.append(Part([block], block.future))
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

    def _mind_losses(self, work: Work) -> None:
        """Takes back parts that were lost with their worker; Dask makes them again. A sum that waits for one of them is given up,
        as what else is in it could be lost meanwhile."""
        for total in [total for total in work.sums if any(_is_under_way(part.future) for part in total.of)]:
            work.sums.remove(total)
            work.ready += total.of
        lost = [part for part in work.ready if _is_under_way(part.future)]
        work.ready = [part for part in work.ready if part not in lost]
        for part in lost:
            if len(part.blocks) > 1:
                # Of blocks that Dask still knows; they are rendered on the way.
                work.sums.append(part)
            else:
                part.blocks[0].given = time.monotonic()
                self._blocks += part.blocks

    def _add(self, work: Work) -> None:
        """Has workers add up the smallest parts, where there are more than the driver adds itself."""
        while len(work.ready) > _DIRECT:
            work.ready.sort(key=lambda part: len(part.blocks))
            some, work.ready = work.ready[:_FAN], work.ready[_FAN:]
            # Before blocks that wait on the same worker.
            future = self._client.submit(self._tasks.add_parts, [part.future for part in some], pure=True, priority=10,
                                         **self._placed())
            work.sums.append(Part([block for part in some for block in part.blocks], future, some))

    def _keep(self, work: Work) -> None:
        """Adds the largest parts that are there to the state file; the blocks in them may then be forgotten."""
        for total in [total for total in work.sums if not _is_under_way(total.future)]:
            work.sums.remove(total)
            if total.future.status == "finished":
                _release(total.of)
                total.of = []
                work.ready.append(total)
            else:
                self._render_again(total, _outcome(total.future) or total.future.status)
        began = time.monotonic()
        if not work.ready or began < work.next_store:
            return
        work.ready.sort(key=lambda part: len(part.blocks))
        parts, work.ready = work.ready[-_DIRECT:], work.ready[:-_DIRECT]
        parts, contents = self._fetch(work, parts)
        try:
            if contents:
                self._store(work, contents)
        except Exception as error:
            # Damaged.
            for part in parts:
                self._render_again(part, error)
            return
        work.job.done = joined([*work.job.done, *(block.range for part in parts for block in part.blocks)])
        # At once: references to them may outlive this, in exceptions of Dask that have not been collected yet, and what is
        # referred to is rendered again when its worker is lost.
        _release(parts)
        work.stored = time.monotonic()
        work.next_store = work.stored + (work.stored - began) * (1.0 / _STORING - 1.0)
        if time.monotonic() - work.written > self._every:
            self._write_image(work)

    def _fetch(self, work: Work, parts: list[Part]) -> tuple[list[Part], list[bytes]]:
        """The parts that arrive, and their contents. The others stay with ``work``. Raises FarmError if one does not come again
        and again."""

        def fetch(part: Part) -> bytes | Exception:
            try:
                # What is lost just now would be waited for until it is rendered again. Large ones get more time with every
                # attempt.
                return cast("bytes", part.future.result(timeout=_FETCH * 4.0**part.fetched))
            except Exception as error:
                return error

        with ThreadPoolExecutor(_DIRECT) as threads:
            found = list(zip(parts, threads.map(fetch, parts), strict=True))
        for part, content in found:
            if isinstance(content, bytes):
                continue
            if part.future.status == "error":
                self._render_again(part, content)
                continue
            part.fetched += 1
            if part.fetched > _ATTEMPTS:
                raise FarmError(f"results of workers do not arrive: {content}") from content
            self._tell(f"a sum of {len(part.blocks)} blocks did not arrive, and is fetched again: {content}")
            work.ready.append(part)
        arrived = [(part, content) for part, content in found if isinstance(content, bytes)]
        return [part for part, _ in arrived], [content for _, content in arrived]

    def _render_again(self, part: Part, why: Any) -> None:
        """Gives out the blocks of a part that failed, under other names."""
        self._tell(f"a sum of {len(part.blocks)} blocks failed: {why}")
        for block in part.blocks:
            self._client.cancel([block.future], force=True)
            self._try_again(block, "a sum that failed")

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
        waiting = sum(part.count for work in works for part in (*work.ready, *work.sums))
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


def _release(parts: list[Part]) -> None:
    """Lets workers forget these parts."""
    for part in parts:
        part.future.release()


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


def _duration(seconds: float) -> str:
    minutes, rest = divmod(int(max(seconds, 0.0)), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}h{minutes:02}" if hours else f"{minutes}min {rest:02}s" if minutes else f"{rest}s"
