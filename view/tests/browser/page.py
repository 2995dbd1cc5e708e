"""The page in headless Chromium, and the program that serves it."""

import contextlib
import os
import shutil
import signal
import subprocess
import time

from selenium import webdriver
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.support.ui import Select

SPPM = os.environ.get("SPPM", "target/debug/sppm")
# What takes longer is taken to be lost.
PATIENCE = 30

# A shell starts what runs in the background with SIGINT ignored, and programs that are started from here would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@contextlib.contextmanager
def served(*arguments, **options):
    """Runs `sppm view` with these arguments; gives the process and the page's address."""
    command = [SPPM, *arguments, "--no-open"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)
    try:
        address = process.stdout.readline().strip()
        assert address.startswith("http://"), process.stderr.read()
        yield process, address
    finally:
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
            process.wait(PATIENCE)
        process.stdout.close()
        process.stderr.close()


class Page:
    """A page in a browser of its own."""

    def __init__(self, size=(1280, 800), dark=True, webgl=True, downloads=None):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for option in ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--enable-unsafe-swiftshader"]:
            options.add_argument(option)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        if downloads:
            options.add_experimental_option("prefs", {"download.default_directory": str(downloads)})
        self.browser = webdriver.Chrome(options=options, service=Service(shutil.which("chromedriver")))
        scheme = [{"name": "prefers-color-scheme", "value": "dark" if dark else "light"}]
        self.browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": scheme})
        width, height = size
        metrics = {"width": width, "height": height, "deviceScaleFactor": 1, "mobile": False}
        self.browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
        self.webgl = webgl

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.browser.quit()

    def open(self, address, whole=True):
        self.browser.get(address + ("?webgl" if self.webgl else "?canvas"))
        self.run("window.seen = []; addEventListener('picture', ({detail}) => seen.push({...detail, words: null, at: performance.now()}))")
        if whole:
            self.wait("return document.getElementById('empty').hidden")
        return self

    def run(self, script, *arguments):
        return self.browser.execute_script(script, *arguments)

    def wait(self, script, *arguments, seconds=PATIENCE):
        """Waits until the script returns something true, and returns it."""
        until = time.monotonic() + seconds
        while True:
            result = self.run(script, *arguments)
            if result:
                return result
            assert time.monotonic() < until, f"it does not come true: {script}"
            time.sleep(0.03)

    def find(self, name):
        return self.browser.find_element(By.ID, name)

    def text(self, name):
        return self.run("return document.getElementById(arguments[0]).textContent", name)

    def value(self, name):
        return self.run("return document.getElementById(arguments[0]).value", name)

    def set(self, name, value):
        """Sets a control as a person does who types or drags and then lets go."""
        self.run(
            "const control = document.getElementById(arguments[0]); control.closest('details')?.setAttribute('open', '');"
            "control.value = arguments[1]; control.dispatchEvent(new Event('input', {bubbles: true}));"
            "control.dispatchEvent(new Event('change', {bubbles: true}))",
            name,
            str(value),
        )

    def choose(self, name, value):
        self.run("document.getElementById(arguments[0]).closest('details')?.setAttribute('open', '')", name)
        Select(self.find(name)).select_by_value(value)

    def click(self, name):
        self.run("document.getElementById(arguments[0]).closest('details')?.setAttribute('open', '')", name)
        self.find(name).click()

    def place(self, x, y):
        """The point of the stage, from its middle, where the image's x and y (0 to 1) are, with the whole image shown."""
        width, height = self.run("const s = document.getElementById('stage'); return [s.clientWidth, s.clientHeight]")
        picture = self.last()
        scale = min(width / picture["wholeWidth"], height / picture["wholeHeight"])
        return (x - 0.5) * picture["wholeWidth"] * scale, (y - 0.5) * picture["wholeHeight"] * scale

    def pointer(self, x, y):
        across, down = self.place(x, y)
        return ActionChains(self.browser, duration=0).move_to_element_with_offset(self.find("stage"), across, down)

    def press(self, x, y):
        self.pointer(x, y).click().perform()

    def drag(self, start, way, key=None, steps=8):
        """Drags from a place of the image by a way in CSS pixels."""
        chain = self.pointer(*start)
        if key:
            chain.key_down(key)
        chain.click_and_hold()
        for _ in range(steps):
            chain.move_by_offset(way[0] / steps, way[1] / steps).pause(0.03)
        chain.release()
        if key:
            chain.key_up(key)
        chain.perform()

    def keys(self, *keys):
        self.run("document.getElementById('stage').focus()")
        chain = ActionChains(self.browser)
        for key in keys:
            chain.send_keys(key)
        chain.perform()

    def chord(self, keys, *held):
        """Presses keys while others are held."""
        self.run("document.getElementById('stage').focus()")
        chain = ActionChains(self.browser)
        for key in held:
            chain.key_down(key)
        chain.send_keys(keys)
        for key in held:
            chain.key_up(key)
        chain.perform()

    def last(self):
        return self.wait("return window.seen.at(-1)")

    def settled(self, version):
        """Waits for a whole picture of a version after `version`, and returns it."""
        return self.wait(
            "return window.seen.findLast((p) => p.version > arguments[0] && !p.reduced)", version
        )

    def colour(self, x, y):
        """The colour on the screen at a place of the image: red, green and blue from 0 to 255."""
        import io
        import struct
        import zlib

        across, down = self.place(x, y)
        left, top, width, height = self.run(
            "const r = document.getElementById('stage').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]"
        )
        clip = {"x": left + width / 2 + across - 1, "y": top + height / 2 + down - 1, "width": 2, "height": 2, "scale": 1}
        shot = self.browser.execute_cdp_cmd("Page.captureScreenshot", {"format": "png", "clip": clip})
        import base64

        data = io.BytesIO(base64.b64decode(shot["data"]))
        data.read(8)
        chunks = b""
        while header := data.read(8):
            length, kind = struct.unpack(">I4s", header)
            body = data.read(length)
            data.read(4)
            if kind == b"IHDR":
                channels = {2: 3, 6: 4}[body[9]]
            if kind == b"IDAT":
                chunks += body
        # The first pixel of the first row is the same under all filters that look to the left and above.
        return tuple(zlib.decompress(chunks)[1 : 1 + channels][:3])

    def errors(self):
        """What the browser complained of, but for the speed of drawing without a graphics card."""
        logs = [log["message"] for log in self.browser.get_log("browser") if log["level"] in ("SEVERE", "WARNING")]
        return [log for log in logs if "GL Driver Message" not in log and "software WebGL" not in log]
