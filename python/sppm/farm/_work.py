"""What a driver keeps of the jobs under way: blocks of iterations, and parts, which are their sums."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ._jobs import Job, Range


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
    twin: Any = None
    """The same once more, if the first is slow."""

    @property
    def count(self) -> int:
        return self.range[1] - self.range[0]


@dataclass
class Part:
    """Iterations whose sum is on a worker, or will be: those of a block, or of several that workers add up."""

    blocks: list[Block]
    future: Any
    of: list[Part] = field(default_factory=list["Part"])
    """The parts that it adds up, until it is there."""
    fetched: int = 0
    """How often it did not arrive."""

    @property
    def count(self) -> int:
        return sum(block.count for block in self.blocks)


@dataclass
class Work:
    """A job under way."""

    job: Job
    missing: list[Range]
    ready: list[Part] = field(default_factory=list["Part"])
    """Parts that are there, on their workers."""
    sums: list[Part] = field(default_factory=list["Part"])
    """Parts that are being added up."""
    next_store: float = 0.0
    """When parts may be stored next."""
    scene: Any = None
    written: float = 0.0
    stored: float = 0.0
    """When parts were stored last."""
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

    def is_left(self, blocks: list[Block]) -> bool:
        """Whether anything is left to be done; ``blocks``: those that are rendered, of all jobs."""
        return bool(self.missing or self.ready or self.sums or any(block.job is self for block in blocks))


def without(whole: Range, done: list[Range]) -> list[Range]:
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


def joined(ranges: list[Range]) -> list[Range]:
    """The same iterations in order, in as few ranges as there can be."""
    all_: list[Range] = []
    for start, stop in sorted(ranges):
        if all_ and all_[-1][1] == start:
            all_[-1] = (all_[-1][0], stop)
        else:
            all_.append((start, stop))
    return all_
