"""Kills workers and drivers of a farm: farm_kills.py [--workers N] [--kills N] [--drivers N] [--seconds S]

First, workers of one render are killed at random times, by SIGKILL; then the driver of another, with all its workers, and the
same command is given again. Workers note when they begin and end a block, so what was rendered in vain is known. Says how
much that was per kill, in blocks, and whether the images are those of a render without a farm. Exits with 1 if they are not, or
if more than a block was lost for each worker that was killed.
"""

from __future__ import annotations

import argparse
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import psutil

import sppm
from sppm.farm import Driver, Job, _tasks
from sppm.farm._cluster import client_of

LOG = "SPPM_FARM_LOG"
"""The variable that names the file in which workers note the blocks that they begin and end."""
SMALL = {"width": 48, "height": 32, "photons_per_iteration": 10_000, "radius_schedule": "global"}
PAUSE = (1.5, 3.5)
"""Seconds that a block takes besides its rendering, at least and at most, so that kills and not the processor decide."""


class Noting:
    """Tasks that note the blocks that they begin and end."""

    versions, pack, hand_on, add_parts = _tasks.versions, _tasks.pack, _tasks.hand_on, _tasks.add_parts

    @staticmethod
    def render_block(packed: bytes, name: str, start: int, stop: int, *rest: Any) -> bytes:
        note("begin", start, stop)
        part = _tasks.render_block(packed, name, start, stop, *rest)
        time.sleep(random.uniform(*PAUSE))
        note("end", start, stop)
        return part


def note(*words: object) -> None:
    """Appends a line, all at once, so that lines of several processes do not mix."""
    line = " ".join(map(str, [*words, os.getpid(), time.time()])) + "\n"
    file = os.open(os.environ[LOG], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(file, line.encode())
    os.close(file)


class Noted:
    """What workers noted."""

    def __init__(self, log: Path, killed: dict[int, float]) -> None:
        """``killed``: when each process was killed, by its id."""
        self.begun = 0
        self.lost: list[float] = []
        """The seconds that each block took that was begun again."""
        self.kept: dict[tuple[str, str], float] = {}
        """The seconds of the last time that each block was rendered."""
        begins: dict[str, tuple[tuple[str, str], float]] = {}
        for line in log.read_text().splitlines() if log.exists() else []:
            what, start, stop, process, at = line.split()
            if what == "begin":
                self.begun += 1
                begins[process] = ((start, stop), float(at))
                continue
            block, begun = begins.pop(process)
            if block in self.kept:
                self.lost.append(self.kept[block])
            self.kept[block] = float(at) - begun
        self.lost += [killed[int(process)] - begun for process, (_, begun) in begins.items() if int(process) in killed]

    @property
    def lost_blocks(self) -> float:
        """The work that was lost, in blocks."""
        return sum(self.lost) / (sum(self.kept.values()) / len(self.kept))


def working(log: Path) -> list[int]:
    """The processes that have begun a block."""
    lines = log.read_text().splitlines() if log.exists() else []
    return sorted({int(line.split()[3]) for line in lines})


def scene_of(iterations: int, seed: int) -> sppm.Scene:
    """Cornell in small."""
    scene = sppm.Scene.load("cornell")
    scene.settings = scene.settings.replace(**SMALL, iterations=iterations, seed=seed)  # type: ignore[arg-type]
    return scene


def is_right(file: Path, scene: sppm.Scene) -> bool:
    """Whether the image is that of a render without a farm."""
    return np.array_equal(sppm.Film.load(file).radiance, sppm.render(scene, progress=False).radiance)


def kill_workers(folder: Path, words: argparse.Namespace) -> bool:
    """Kills workers of one render at random times, until there were enough."""
    chance, over, log = random.Random(words.seed), threading.Event(), Path(os.environ[LOG])
    killed: dict[int, float] = {}
    # More iterations than it takes: the render goes on as long as there are kills.
    scene = scene_of(words.iterations, words.seed)

    def kill() -> None:
        while len(killed) < words.kills and not over.wait(chance.uniform(0.2, words.seconds)):
            # Those that have begun a block; others may still be starting.
            workers = [process for process in working(log) if psutil.pid_exists(process) and process not in killed]
            if len(workers) == words.workers:
                worker = chance.choice(workers)
                os.kill(worker, signal.SIGKILL)
                killed[worker] = time.time()

    with client_of(words.workers, None) as client:
        thread = threading.Thread(target=kill)
        thread.start()
        driver = Driver(client, tell=lambda text: None, every=1e3, block=words.block, tasks=Noting)
        driver.run([Job(scene, folder / "workers.exr")])
        over.set()
        thread.join()
    noted = Noted(log, killed)
    same = is_right(folder / "workers.exr", scene)
    print(f"{len(killed)} workers killed, of {words.workers}, one every {0.1 + words.seconds / 2:.1f} s when all are there: "
          f"{len(noted.kept)} blocks, {len(noted.lost)} begun again ({driver.repeated} given out twice); lost per kill, in "
          f"blocks: {noted.lost_blocks / max(1, len(killed)):.2f}; the same image: {same}", flush=True)
    return same and noted.lost_blocks <= len(killed) and len(killed) >= words.kills


def kill_drivers(folder: Path, words: argparse.Namespace) -> bool:
    """Kills the driver and all its workers, and begins again, until there were enough."""
    if words.drivers == 0:
        return True
    chance, log = random.Random(words.seed + 1), Path(os.environ[LOG])
    log.unlink(missing_ok=True)
    scene = scene_of(words.iterations // 4, words.seed + 1)
    scene.save(folder / "driver.toml")
    command = [sys.executable, __file__, "--drive", str(folder), "--workers", str(words.workers), "--block", str(words.block)]
    killed: dict[int, float] = {}
    drivers, before = 0, 0
    while drivers < words.drivers:
        process = subprocess.Popen(command, start_new_session=True)
        # From when the first block is begun.
        while Noted(log, killed).begun == before and process.poll() is None:
            time.sleep(0.05)
        time.sleep(chance.uniform(0.0, 2 * words.seconds))
        if process.poll() is not None:
            break
        workers = psutil.Process(process.pid).children(recursive=True)
        os.killpg(process.pid, signal.SIGKILL)
        killed |= {worker.pid: time.time() for worker in workers}
        process.wait()
        drivers += 1
        time.sleep(0.5)
        before = Noted(log, killed).begun
    process = subprocess.run(command, check=False)
    noted = Noted(log, killed)
    same = process.returncode == 0 and is_right(folder / "driver.exr", scene)
    print(f"{drivers} drivers killed, each with its {words.workers} workers: {len(noted.kept)} blocks, {len(noted.lost)} begun "
          f"again; lost per kill, in blocks: {noted.lost_blocks / max(1, drivers):.2f}; the same image: {same}", flush=True)
    return same and noted.lost_blocks <= drivers * words.workers and drivers >= words.drivers


def drive(folder: Path, words: argparse.Namespace) -> None:
    """The driver that is killed."""
    with client_of(words.workers, None) as client:
        scene = sppm.Scene.load(folder / "driver.toml")
        driver = Driver(client, tell=lambda text: None, every=1e3, block=words.block, tasks=Noting)
        driver.run([Job(scene, folder / "driver.exr")])


def main() -> int:
    """Runs it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--workers", type=int, default=3)
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--drivers", type=int, default=10)
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--iterations", type=int, default=3000)
    parser.add_argument("--block", type=int, default=5)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--drive", type=Path)
    words = parser.parse_args()
    if words.drive:
        drive(words.drive, words)
        return 0
    with tempfile.TemporaryDirectory(prefix="sppm-kills-") as folder:
        os.environ[LOG] = str(Path(folder, "log"))
        results = [kill(Path(folder), words) for kill in (kill_workers, kill_drivers)]
    return 0 if all(results) else 1


if __name__ == "__main__":
    # As a module, whose classes workers find instead of copies of them.
    import farm_kills

    sys.exit(farm_kills.main())
