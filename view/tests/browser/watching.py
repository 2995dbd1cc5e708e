"""Measures what watching a render costs: `sppm render --view` with a client that takes every picture, beside `sppm render`.

Runs both in turns, with the same iterations, and prints the seconds of the processor of each (the server's included) and the
median of the ratios: the share of its speed that a watched render keeps where all cores are busy.
"""

import json
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time

import websocket
from page import SPPM

ROUNDS = int(sys.argv[1]) if len(sys.argv) > 1 else 9
ITERATIONS = sys.argv[2] if len(sys.argv) > 2 else "400"
SETTINGS = ["--width", "512", "--height", "384", "--photons", "200000", "--depth", "5", "--radius", "2", "-n", ITERATIONS]
# The time that a page takes to draw a picture before it asks for the next.
DRAWS = 0.016


def look(address, seen):
    """Takes pictures until the server is gone."""
    socket = websocket.create_connection(address.replace("http", "ws") + "socket", timeout=60)
    try:
        while True:
            if isinstance(socket.recv(), bytes):
                seen.append(time.monotonic())
                time.sleep(DRAWS)
                socket.send('{"type":"ack"}')
    except (websocket.WebSocketException, OSError):
        pass


def run(folder, watched):
    """Seconds, seconds of the processor, and pictures."""
    words = [SPPM, "render", "cornell", *SETTINGS, "--threads", "2", "--quiet", "-o", os.path.join(folder, "a.pfm")]
    words += ["--view", "--no-open"] if watched else []
    began, seen = time.monotonic(), []
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as process:
        if watched:
            threading.Thread(target=look, args=(process.stdout.readline().strip(), seen), daemon=True).start()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode == 0
    assert bool(seen) == watched
    return time.monotonic() - began, usage.ru_utime + usage.ru_stime, len(seen)


def main():
    with tempfile.TemporaryDirectory() as folder:
        ratios = []
        for number in range(ROUNDS):
            order = [False, True] if number % 2 else [True, False]
            done = {watched: run(folder, watched) for watched in order}
            ratios.append(done[False][1] / done[True][1])
            print(json.dumps({"alone": round(done[False][1], 2), "watched": round(done[True][1], 2),
                              "pictures": done[True][2], "ratio": round(ratios[-1], 3)}), flush=True)
        print(json.dumps({"median ratio": round(statistics.median(ratios), 3), "rounds": ROUNDS}))


if __name__ == "__main__":
    main()
