"""How soon Ctrl-C is answered: interrupt_latency.py [COUNT], by default 20 for each case. Prints median and maximum.

A program is started for each, and gets SIGINT at a random time after it has said that it is ready. The answer is the time
until the exception is caught; the image is there when `Interrupted.film` is. It is not a test, as it measures time.
"""

from __future__ import annotations

import random
import signal
import statistics
import subprocess
import sys
import time

BEGIN = """
import time, numpy as np, sppm
scene = sppm.Scene.load("cornell")
large = dict(width=4000, height=3000, iterations=1 << 20, photons_per_iteration=500_000)
random = np.random.default_rng(0)

def when(iteration):
    return lambda progress: progress.iteration == iteration and print("ready", flush=True)

def spheres(n):
    side = round(n ** (1 / 3)) + 1
    scene = sppm.Scene(sppm.Camera.look_at([2 * side] * 3, [side / 2] * 3), background=[1, 1, 1])
    scene.add_spheres(random.uniform(0, side, (n, 3)), 0.2, sppm.Diffuse(0.6))
    return scene

many = {many}
try:
    {run}
except KeyboardInterrupt as interrupt:
    print(time.time(), flush=True)
    getattr(interrupt, "film", None)
    print(time.time(), flush=True)
"""
READY = "print('ready', flush=True); "
CASES = {
    "512x384": ("None", "sppm.render(scene, iterations=1 << 20, progress=when(3))", 0.5),
    "4000x3000": ("None", "sppm.render(scene, **large, progress=when(1))", 3.0),
    "4000x3000, paths": ("None", "sppm.render(scene, **large, method='path', progress=when(1))", 3.0),
    "million spheres": ("spheres(10**6)", READY + "sppm.render(many, iterations=1 << 20)", 6.0),
    "reading a scene": ("sppm.Scene.to_toml(spheres(300_000))", READY + "sppm.Scene.parse(many)", 0.5),
    "choosing settings": ("None", READY + "sppm.render(scene, quality='final', width=4000, height=3000)", 1.0),
}
"""What is prepared, what runs, and the seconds within which it is interrupted."""


def told(seconds: list[float]) -> str:
    if not seconds:
        return "all were complete before"
    return f"median {1e3 * statistics.median(seconds):.0f} ms, maximum {1e3 * max(seconds):.0f} ms"


def main(count: int) -> None:
    random.seed(1)
    for name, (many, run, within) in CASES.items():
        answers, images = [], []
        for _ in range(count):
            program = BEGIN.replace("{many}", many).replace("{run}", run)
            process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
            assert process.stdout is not None and process.stdout.readline() == "ready\n"
            time.sleep(random.uniform(0, within))
            sent = time.time()
            process.send_signal(signal.SIGINT)
            printed, _ = process.communicate()
            if len(times := printed.split()) == 2:  # else it was complete before
                answers.append(float(times[0]) - sent)
                images.append(float(times[1]) - sent)
        print(f"{name}: {len(answers)} answers, {told(answers)}; images: {told(images)}", flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 20)
