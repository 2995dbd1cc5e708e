"""The farm at scale: its own driver and a real Dask scheduler, with workers in one process and stand-ins for renders.

farm_scale.py [--workers N] [--blocks N] [--seconds S]

A stand-in for a block sleeps, and returns the iterations that it is of. So the sum tells whether each was counted exactly
once. Prints what it found; exits with 1 if a sum is wrong.
"""

from __future__ import annotations

import argparse
import json
import logging
import random
import resource
import sys
import tempfile
import time
import zlib
from pathlib import Path
from typing import Any

from distributed import Client, LocalCluster

import sppm
from sppm import _sppm
from sppm.farm import Driver, Job
from sppm.farm._driver import Work

SECONDS = 2.0
"""What a block takes on the average."""


class StandIns:
    """Tasks that take time and add up lists of iterations."""

    rendered = 0

    @staticmethod
    def versions() -> tuple[str, int]:
        return sppm.__version__, _sppm.TRANSPORT

    @staticmethod
    def pack(scene: sppm.Scene) -> bytes:
        return zlib.compress(scene.to_toml().encode())

    @staticmethod
    def hand_on(packed: bytes) -> bytes:
        return packed

    @staticmethod
    def render_block(packed: bytes, name: str, start: int, stop: int, *_: Any) -> bytes:
        time.sleep(SECONDS * random.uniform(0.5, 1.5))
        StandIns.rendered += 1
        return json.dumps([[start, stop]]).encode()

    @staticmethod
    def add_parts(parts: list[bytes]) -> bytes:
        return json.dumps([block for part in parts for block in json.loads(part)]).encode()


class Counting(Driver):
    """A driver that notes what it is given, in place of a file of sums."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.stored: list[tuple[int, int]] = []
        self.peaks: list[int] = []

    def _store(self, work: Work, part: bytes) -> None:
        self.stored += [(start, stop) for start, stop in json.loads(part)]
        self.peaks.append(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)

    def _write_image(self, work: Work) -> None:
        pass


def main() -> int:
    """Runs it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--workers", type=int, default=200)
    parser.add_argument("--blocks", type=int, default=5000)
    parser.add_argument("--seconds", type=float, default=SECONDS)
    words = parser.parse_args()
    globals()["SECONDS"] = words.seconds
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    scene = sppm.Scene.load("cornell")
    scene.settings = scene.settings.replace(iterations=words.blocks)
    with tempfile.TemporaryDirectory() as folder, LocalCluster(
        n_workers=words.workers, threads_per_worker=1, processes=False, dashboard_address=":0"
    ) as cluster, Client(cluster, set_as_default=False) as client:
        driver = Counting(client, block=1, every=2.0, tasks=StandIns, tell=lambda text: None)
        began = time.monotonic()
        driver.run([Job(scene, Path(folder, "a.png"))])
        took = time.monotonic() - began
    ideal = words.blocks * words.seconds / words.workers
    is_right = sorted(driver.stored) == [(k, k + 1) for k in range(words.blocks)]
    half = driver.peaks[len(driver.peaks) // 2]
    print(f"{words.workers} workers, {words.blocks} blocks of {words.seconds} s: {took:.1f} s, "
          f"{ideal / took:.2f} of the ideal {ideal:.1f} s; {StandIns.rendered - words.blocks} blocks rendered again; "
          f"{len(driver.peaks)} sums; peak memory grew {driver.peaks[-1] / half - 1:.1%} in the second half; "
          f"each iteration once: {is_right}")
    return 0 if is_right else 1


if __name__ == "__main__":
    # As a module, whose classes workers find instead of copies of them.
    import farm_scale

    sys.exit(farm_scale.main())
