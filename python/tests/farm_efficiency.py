"""What a farm costs: farm_efficiency.py [--rounds N] [--iterations N] [--block N] [--blocks N].

First, the work of a farm of two workers of one thread each beside that of two separate renders of the same iterations, in
turns: seconds, and seconds of the processor of all processes, those of the driver, the scheduler and of starting included. On a
machine that others use too, the second is the one to look at. Then the memory of a driver that is given many blocks.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import psutil

import sppm
from sppm.farm import Driver, Job
from sppm.farm._cluster import client_of

WORKERS = 2


def scene_of(iterations: int, **settings: object) -> sppm.Scene:
    """Cornell with global radii."""
    scene = sppm.Scene.load("cornell")
    scene.settings = scene.settings.replace(iterations=iterations, radius_schedule="global", **settings)  # type: ignore[arg-type]
    return scene


def cpu() -> float:
    """Seconds of the processor of this process and its children, ended ones included."""
    times = psutil.Process().cpu_times()
    running = sum(sum(child.cpu_times()[:4]) for child in psutil.Process().children(recursive=True))
    return times.user + times.system + times.children_user + times.children_system + running


def render(folder: Path, iterations: int) -> None:
    """Two renders at once, of half the iterations each, in processes of their own."""
    code = ("import sys, sppm; scene = sppm.Scene.load(sys.argv[1]); "
            "sppm.render_part(scene, int(sys.argv[2]), int(sys.argv[3]), sys.argv[4], threads=1)")
    scene_of(iterations).save(folder / "a.toml")
    half = iterations // WORKERS
    words = [sys.executable, "-c", code, str(folder / "a.toml")]
    parts = [[*words, str(half * k), str(half * (k + 1)), str(folder / f"{k}.sppm")] for k in range(WORKERS)]
    for process in [subprocess.Popen(part) for part in parts]:
        process.wait()


def farm(folder: Path, iterations: int, block: int | None) -> tuple[float, float]:
    """A farm. Returns the seconds, and those of the processor, without the start and the end of the cluster."""
    with client_of(WORKERS, None) as client:
        client.wait_for_workers(WORKERS)
        began, processor = time.monotonic(), cpu()
        Driver(client, block=block, tell=lambda text: None).run([Job(scene_of(iterations), folder / "farm.exr")])
        return time.monotonic() - began, cpu() - processor


def efficiency(words: argparse.Namespace) -> None:
    """Prints the ratios of all rounds."""
    ratios: list[tuple[float, float]] = []
    for _ in range(words.rounds):
        with tempfile.TemporaryDirectory() as name:
            began, processor = time.monotonic(), cpu()
            render(Path(name), words.iterations)
            alone = time.monotonic() - began, cpu() - processor
            whole = farm(Path(name), words.iterations, words.block)
        ratios.append((alone[0] / whole[0], alone[1] / whole[1]))
        print(f"two renders {alone[0]:.1f} s, {alone[1]:.1f} s of CPU; the farm {whole[0]:.1f} s, {whole[1]:.1f} s of CPU; "
              f"efficiency {ratios[-1][0]:.3f} by time, {ratios[-1][1]:.3f} by CPU", flush=True)
    medians = [sorted(column)[len(column) // 2] for column in zip(*ratios, strict=True)]
    print(f"median efficiency {medians[0]:.3f} by time, {medians[1]:.3f} by CPU", flush=True)


class Weighed(Driver):
    """A driver that notes its memory when it stores."""

    sizes: list[int]

    def _store(self, work: object, parts: list[bytes]) -> None:
        super()._store(work, parts)  # type: ignore[arg-type]
        self.sizes.append(psutil.Process().memory_info().rss)


def memory(blocks: int) -> None:
    """Prints the memory of a driver that is given so many blocks, of one iteration each."""
    scene = scene_of(blocks, width=16, height=12, photons_per_iteration=100)
    with tempfile.TemporaryDirectory() as folder, client_of(WORKERS, None) as client:
        driver = Weighed(client, block=1, tell=lambda text: None)
        driver.sizes = []
        began = time.monotonic()
        driver.run([Job(scene, Path(folder, "a.exr"))])
        sizes = [size / 2**20 for size in driver.sizes]
        quarters = [sizes[min(len(sizes) - 1, len(sizes) * k // 4)] for k in range(5)]
        print(f"{blocks} blocks in {time.monotonic() - began:.0f} s, {len(sizes)} sums; memory of the driver with its scheduler, "
              f"MiB, from the first sum to the last: {', '.join(f'{size:.0f}' for size in quarters)}", flush=True)


def main() -> None:
    """Runs it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--iterations", type=int, default=60)
    parser.add_argument("--block", type=int, help="iterations of a block; on a busy machine, as many as take 10 seconds of a core")
    parser.add_argument("--blocks", type=int, default=10_000)
    words = parser.parse_args()
    if words.rounds:
        efficiency(words)
    if words.blocks:
        memory(words.blocks)


if __name__ == "__main__":
    main()
