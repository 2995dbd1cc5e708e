"""Kills workers and drivers of a farm: farm_kills.py [--workers N] [--kills N] [--drivers N] [--seconds S]

First, workers of one render are killed at random times, by SIGKILL; then the driver of another, with all its workers, and the
same command is given again. Counts the blocks that were begun, so that those that were begun again are known; says how many
were lost per kill, and whether the images are those of a render without a farm. Exits with 1 if they are not, or if a kill of a
worker lost more than a block, on the average.
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
SMALL = {"width": 48, "height": 32, "photons_per_iteration": 50_000, "radius_schedule": "global"}


class Noting:
    """Tasks that note the blocks that they begin and end."""

    versions, pack, hand_on, add_parts = _tasks.versions, _tasks.pack, _tasks.hand_on, _tasks.add_parts

    @staticmethod
    def render_block(packed: bytes, name: str, start: int, stop: int, *rest: Any) -> bytes:
        note("begin", start, stop)
        part = _tasks.render_block(packed, name, start, stop, *rest)
        note("end", start, stop)
        return part


def note(*words: object) -> None:
    """Appends a line, all at once, so that lines of several processes do not mix."""
    line = " ".join(map(str, [*words, os.getpid()])) + "\n"
    file = os.open(os.environ[LOG], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(file, line.encode())
    os.close(file)


def noted(log: Path) -> tuple[int, int, int]:
    """Blocks that were begun, that were ended, and different ones."""
    lines = [line.split() for line in log.read_text().splitlines()]
    begun = [tuple(line[1:3]) for line in lines if line[0] == "begin"]
    return len(begun), len([line for line in lines if line[0] == "end"]), len(set(begun))


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
    chance, killed, over = random.Random(words.seed), [], threading.Event()
    # More iterations than it takes: the render goes on as long as there are kills.
    scene = scene_of(words.iterations, words.seed)

    def kill() -> None:
        while len(killed) < words.kills and not over.wait(chance.uniform(0.2, words.seconds)):
            nannies = psutil.Process().children()
            workers = [child for child in nannies if "spawn_main" in " ".join(child.cmdline())]
            if len(workers) == words.workers:
                worker = chance.choice(workers)
                worker.kill()
                killed.append(worker.pid)

    with client_of(words.workers, None) as client:
        thread = threading.Thread(target=kill)
        thread.start()
        driver = Driver(client, tell=lambda text: None, every=1e3, block=words.block, tasks=Noting)
        driver.run([Job(scene, folder / "workers.exr")])
        over.set()
        thread.join()
    begun, ended, different = noted(Path(os.environ[LOG]))
    twice = driver.repeated
    lost = begun - different
    same = is_right(folder / "workers.exr", scene)
    print(f"{len(killed)} workers killed, one of {words.workers} every {words.seconds / 2 + 0.1:.1f} s: {different} blocks of "
          f"{words.block} iterations, {lost} begun again ({ended - different} of them had ended, {twice} were given out twice), "
          f"{lost / max(1, len(killed)):.2f} per kill; the same image: {same}", flush=True)
    return same and lost - twice <= len(killed) and len(killed) >= words.kills


def kill_drivers(folder: Path, words: argparse.Namespace) -> bool:
    """Kills the driver and all its workers, and begins again, until there were enough."""
    chance, log = random.Random(words.seed + 1), Path(os.environ[LOG])
    log.unlink()
    scene = scene_of(words.iterations // 4, words.seed + 1)
    scene.save(folder / "driver.toml")
    command = [sys.executable, __file__, "--drive", str(folder), "--workers", str(words.workers), "--block", str(words.block)]
    killed, most, before = 0, 0, 0
    while killed < words.drivers:
        process = subprocess.Popen(command, start_new_session=True)
        # From when the first block is begun.
        lines = before
        while lines == before and process.poll() is None:
            time.sleep(0.05)
            lines = noted(log)[0] if log.exists() else 0
        time.sleep(chance.uniform(0.0, 2 * words.seconds))
        if process.poll() is not None:
            break
        os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        killed += 1
        time.sleep(0.5)
        begun, before = noted(log)[0] - before, noted(log)[0]
        state = folder / "driver.exr.sppm"
        kept = sum(stop - start for start, stop in sppm.merge([state]).iterations) if state.exists() else 0
        most = max(most, noted(log)[2] - kept // words.block)
        print(f"  driver {killed}: {begun} blocks begun, {kept} iterations kept", flush=True)
    process = subprocess.run(command, check=False)
    begun, _, different = noted(log)
    same = process.returncode == 0 and is_right(folder / "driver.exr", scene)
    print(f"{killed} drivers killed with their {words.workers} workers: {begun - different} of {different} blocks begun again, "
          f"{(begun - different) / max(1, killed):.2f} per kill; the same image: {same}", flush=True)
    return same and begun - different <= killed * words.workers and killed >= words.drivers


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
    parser.add_argument("--iterations", type=int, default=6000)
    parser.add_argument("--block", type=int, default=10)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--drive", type=Path)
    words = parser.parse_args()
    if words.drive:
        drive(words.drive, words)
        return 0
    with tempfile.TemporaryDirectory(prefix="sppm-kills-") as folder:
        os.environ[LOG] = str(Path(folder, "log"))
        results = [kill_workers(Path(folder), words), kill_drivers(Path(folder), words)]
    return 0 if all(results) else 1


if __name__ == "__main__":
    # As a module, whose classes workers find instead of copies of them.
    import farm_kills

    sys.exit(farm_kills.main())
