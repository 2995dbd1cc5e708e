"""The farm at scale: its own driver and a real Dask scheduler, with hundreds of workers in a few processes and stand-ins for
renders.

farm_scale.py [--workers N] [--hosts N] [--blocks N] [--seconds S] [--fail-every S] [--host-fails S]

A stand-in for a block sleeps, and returns the iterations that it is of. So the sum tells whether each was counted exactly
once. The scheduler, each host of workers and the driver are processes of their own. Workers close without warning and others
come, one somewhere every so many seconds; and once a whole host is killed with all its workers. Prints what it found; exits
with 1 if a sum is wrong.
"""

from __future__ import annotations

import argparse
import asyncio
import json
import logging
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
import zlib
from pathlib import Path
from typing import Any

import dask.config
import psutil
from distributed import Client, Scheduler, Worker

import sppm
from sppm import _sppm
from sppm.farm import Driver, Job
from sppm.farm._work import Work

SECONDS, LOG = "SPPM_FARM_SECONDS", "SPPM_FARM_LOG"
"""Variables: what a block takes on the average, and a file that gets a byte for each block that is begun."""
QUIET = {
    "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False",
    "DASK_DISTRIBUTED__ADMIN__TICK__INTERVAL": "10s",
    "DASK_DISTRIBUTED__ADMIN__SYSTEM_MONITOR__INTERVAL": "100s",
    "DASK_DISTRIBUTED__COMM__TIMEOUTS__CONNECT": "300s",
    "DASK_DISTRIBUTED__COMM__TIMEOUTS__TCP": "300s",
}
"""What Dask's workers do many times a second, each: a hundred of them in a process would do little else. And patience, as hundreds
of workers of one machine do not start within seconds."""
PATIENT = {"distributed.comm.timeouts.connect": "300s", "distributed.comm.timeouts.tcp": "300s"}
"""The same patience for the driver."""
PART = 1000
"""Bytes of a stand-in for a part besides its list."""


class StandIns:
    """Tasks that take time and add up lists of iterations."""

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
        log = os.open(os.environ[LOG], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(log, b".")
        os.close(log)
        time.sleep(float(os.environ[SECONDS]) * random.uniform(0.5, 1.5))
        return json.dumps([[start, stop]]).encode() + b" " * PART

    @staticmethod
    def add_parts(parts: list[bytes]) -> bytes:
        return json.dumps([block for part in parts for block in json.loads(part)]).encode() + b" " * PART


class Counting(Driver):
    """A driver that notes what it is given, in place of a file of sums."""

    def __init__(self, *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self.stored: list[tuple[int, int]] = []
        self.memory: list[tuple[int, int]] = []
        """Blocks that were stored, and bytes of the driver then."""
        self.sums = 0

    def _store(self, work: Work, parts: list[bytes]) -> None:
        self.stored += [(start, stop) for part in parts for start, stop in json.loads(part)]
        self.memory.append((len(self.stored), psutil.Process().memory_info().rss))
        self.sums += 1

    def _write_image(self, work: Work) -> None:
        pass


async def schedule() -> None:
    """A scheduler, which prints its address."""
    async with Scheduler(host="127.0.0.1", port=0, dashboard=False) as scheduler:
        print(scheduler.address, flush=True)
        await scheduler.finished()


async def host(address: str, count: int, fail_every: float) -> None:
    """So many workers, of which now and then one is lost, with what it has, and another comes."""
    workers = [Worker(address, nthreads=1, host="127.0.0.1", dashboard=False, memory_limit=0) for _ in range(count)]
    for at in range(0, count, 20):
        await asyncio.gather(*workers[at : at + 20])
    chance = random.Random()
    while True:
        await asyncio.sleep(chance.uniform(0.0, 2.0 * fail_every) if fail_every > 0.0 else 3600.0)
        lost = chance.randrange(count)
        await workers[lost].close(timeout=0.1, executor_wait=False, nanny=False, reason="failure")
        workers[lost] = await Worker(address, nthreads=1, host="127.0.0.1", dashboard=False, memory_limit=0)


def start(*words: object) -> subprocess.Popen[str]:
    """This script, in another role."""
    command = [sys.executable, __file__, *map(str, words)]
    environment = {**os.environ, **QUIET}
    return subprocess.Popen(command, stdout=subprocess.PIPE, text=True, stderr=subprocess.DEVNULL, env=environment)


def drive(words: argparse.Namespace, address: str, hosts: list[subprocess.Popen[str]], folder: Path) -> bool:
    """Renders, and says what was found."""
    scene = sppm.Scene.load("cornell")
    scene.settings = scene.settings.replace(iterations=words.blocks)
    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(words.workers, timeout=300)
        driver = Counting(client, block=1, every=10.0, tasks=StandIns, tell=lambda text: None)
        began, processor = time.monotonic(), time.process_time()
        if words.host_fails > 0.0:
            killing = threading.Timer(words.host_fails, lambda: os.kill(hosts[0].pid, signal.SIGKILL))
            killing.daemon = True
            killing.start()
        driver.run([Job(scene, folder / "a.png")])
        took, processor = time.monotonic() - began, time.process_time() - processor
    begun = Path(os.environ[LOG]).stat().st_size
    ideal = words.blocks * words.seconds / words.workers
    is_right = sorted(driver.stored) == [(k, k + 1) for k in range(words.blocks)]
    # From a quarter on, when all is warm.
    early = next(memory for blocks, memory in driver.memory if blocks >= words.blocks // 4)
    print(f"{words.workers} workers on {words.hosts} hosts, {words.blocks} blocks of {words.seconds} s: {took:.1f} s, "
          f"{ideal / took:.2f} of the ideal {ideal:.1f} s; {begun - words.blocks} blocks rendered again; {driver.sums} sums; "
          f"driver: {processor:.0f} s of CPU, {early / 2**20:.0f} MiB after a quarter of the blocks, "
          f"{driver.memory[-1][1] / 2**20:.0f} MiB at the end; each iteration once: {is_right}")
    return is_right


def main() -> int:
    """Runs it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--workers", type=int, default=1000)
    parser.add_argument("--hosts", type=int, default=8)
    parser.add_argument("--blocks", type=int, default=10_000)
    parser.add_argument("--seconds", type=float, default=20.0)
    parser.add_argument("--fail-every", type=float, default=2.0, help="seconds between two losses of a worker; 0: none")
    parser.add_argument("--host-fails", type=float, default=60.0, help="after so many seconds a host is killed; 0: none")
    parser.add_argument("--role")
    parser.add_argument("--address")
    words = parser.parse_args()
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if words.role == "scheduler":
        asyncio.run(schedule())
        return 0
    if words.role == "host":
        asyncio.run(host(words.address, words.workers, words.fail_every))
        return 0
    with tempfile.TemporaryDirectory() as folder, dask.config.set(PATIENT):
        os.environ[LOG], os.environ[SECONDS] = str(Path(folder, "log")), str(words.seconds)
        os.environ["PYTHONPATH"] = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
        scheduler = start("--role=scheduler")
        assert scheduler.stdout is not None
        address = scheduler.stdout.readline().strip()
        each = words.workers // words.hosts
        of_host = ("--role=host", "--address", address, "--workers", each, "--fail-every", words.fail_every * words.hosts)
        hosts = [start(*of_host) for _ in range(words.hosts)]
        try:
            return 0 if drive(words, address, hosts, Path(folder)) else 1
        finally:
            for process in [*hosts, scheduler]:
                process.kill()
                process.wait()


if __name__ == "__main__":
    # As a module, whose classes workers find instead of copies of them.
    import farm_scale

    sys.exit(farm_scale.main())
