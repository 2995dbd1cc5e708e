"""Measures how quickly pictures come, in the page and in a client without one. Prints a JSON object for each.

The scene is cornell at 512x384 on two threads: the time from an input of the camera to the first picture of it, pictures per
second while the camera turns, and the time from the release to a picture of full resolution.
"""

import json
import sys
import time

import websocket
from page import Page, served

INPUTS = 100
ARGUMENTS = ["view", sys.argv[1] if len(sys.argv) > 1 else "cornell", "--width", "512", "--height", "384", "--threads", "2"]

SCRIPT = """
const done = arguments[arguments.length - 1];
(async () => {
  const stage = document.getElementById('stage');
  const sleep = (ms) => new Promise((resolve) => setTimeout(resolve, ms));
  const next = (kind) => new Promise((resolve) => addEventListener(kind, resolve, {once: true}));
  const rect = stage.getBoundingClientRect();
  const point = (type, x) => stage.dispatchEvent(new PointerEvent(type, {
    pointerId: 1, button: 0, clientX: rect.left + rect.width / 2 + x, clientY: rect.top + 100, bubbles: true}));
  stage.setPointerCapture = () => {};
  const way = (i) => 40 * Math.sin(i / 15);
  point('pointerdown', 0);
  const latencies = [];
  let now = performance.now();
  for (let i = 0; i < arguments[0]; i++) {
    const taken = next('taken');
    const began = performance.now();
    point('pointermove', 10 + way(i));
    const {version} = (await taken).detail;
    for (;;) {
      const found = window.seen.find((p) => p.version >= version);
      if (found) { latencies.push(found.at - began); break; }
      await next('picture');
    }
    await sleep(20 + 7 * (i % 10));
  }
  const from = window.seen.length, start = performance.now();
  for (let i = 0; performance.now() < start + 3000; i++) {
    point('pointermove', 10 + way(i));
    await new Promise(requestAnimationFrame);
  }
  const pictures = (window.seen.length - from) / ((performance.now() - start) / 1000);
  const released = performance.now(), last = next('taken');
  point('pointerup', 10);
  const {version} = (await last).detail;
  let whole;
  while (!(whole = window.seen.find((p) => p.version >= version && !p.reduced))) await next('picture');
  latencies.sort((a, b) => a - b);
  const versions = window.seen.map((p) => p.version);
  done({latencies, pictures, whole: whole.at - released, sorted: versions.every((v, i) => i === 0 || v >= versions[i - 1])});
})();
"""


def told(where, latencies, pictures, whole, is_sorted):
    latencies = sorted(latencies)
    result = {
        "where": where,
        "ms to the first picture, median": round(latencies[len(latencies) // 2]),
        "ms to the first picture, 95 %": round(latencies[int(0.95 * len(latencies))]),
        "pictures per second while turning": round(pictures, 1),
        "ms to full resolution": round(whole),
        "never an older camera after a newer": is_sorted,
    }
    print(json.dumps(result), flush=True)


def in_page(address, webgl):
    with Page(webgl=webgl) as page:
        page.browser.set_script_timeout(120)
        page.open(address)
        page.settled(0)
        result = page.browser.execute_async_script(SCRIPT, INPUTS)
        told("page, " + ("WebGL" if webgl else "canvas"), result["latencies"], result["pictures"], result["whole"], result["sorted"])


class Client:
    """A client that draws nothing."""

    def __init__(self, address):
        self.socket = websocket.create_connection(address.replace("http", "ws") + "socket", suppress_origin=True)
        self.pictures, self.camera, self.taken = [], None, {}

    def read(self):
        message = self.socket.recv()
        if isinstance(message, bytes):
            word = lambda at: int.from_bytes(message[at : at + 4], "little")
            self.pictures.append((time.monotonic(), word(4), word(36) & 1))
            self.socket.send(json.dumps({"type": "ack"}))
            return
        text = json.loads(message)
        if text["type"] == "setup":
            self.camera = self.camera or text["camera"]
        if text["type"] == "taken":
            self.taken[text["id"]] = text["version"]

    def move(self, number, moving=True):
        camera = {**self.camera, "eye": [self.camera["eye"][0] + 0.01 * number, *self.camera["eye"][1:]]}
        self.socket.send(json.dumps({"type": "camera", "id": number, "camera": camera, "moving": moving}))
        return time.monotonic()

    def first(self, number, is_whole=False):
        """When the first picture of an input came."""
        while True:
            version = self.taken.get(number)
            if version:
                for at, shown, reduced in self.pictures:
                    if shown >= version and not (is_whole and reduced):
                        return at
            self.read()


def without_page(address):
    client = Client(address)
    while client.camera is None or not client.pictures:
        client.read()
    latencies = []
    for number in range(1, INPUTS + 1):
        began = client.move(number)
        latencies.append(1000 * (client.first(number) - began))
        time.sleep(0.02 + 0.007 * (number % 10))
    # Inputs at 60 a second; what comes meanwhile is read.
    client.socket.settimeout(0.001)
    begun, start = len(client.pictures), time.monotonic()
    number = INPUTS
    while time.monotonic() < start + 3:
        number += 1
        due = client.move(number) + 1 / 60
        while time.monotonic() < due:
            try:
                client.read()
            except websocket.WebSocketTimeoutException:
                pass
    rate = (len(client.pictures) - begun) / (time.monotonic() - start)
    client.socket.settimeout(30)
    released = client.move(number + 1, moving=False)
    whole = 1000 * (client.first(number + 1, is_whole=True) - released)
    versions = [version for _, version, _ in client.pictures]
    told("client without a page", latencies, rate, whole, versions == sorted(versions))


if __name__ == "__main__":
    with served(*ARGUMENTS) as (_, address):
        without_page(address)
    for webgl in (True, False):
        with served(*ARGUMENTS) as (_, address):
            in_page(address, webgl)
