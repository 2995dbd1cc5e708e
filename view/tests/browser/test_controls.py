"""Drives every control of the page, as a person would."""

import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest

from page import SPPM, Page, served
from selenium.webdriver.common.keys import Keys

SETTINGS = ["--width", "256", "--height", "192", "--photons", "50000", "--depth", "5", "--radius", "2"]
QUICK = [*SETTINGS, "--threads", "2"]
# A difference of codes that no noise makes.
CLEAR = 25


class Studio(unittest.TestCase):
    """A scene that is edited, drawn by WebGL."""

    webgl = True

    def setUp(self):
        self.folder = self.enterContext(tempfile.TemporaryDirectory())
        self.process, self.address = self.enterContext(served("view", "cornell", *QUICK))
        self.page = self.enterContext(Page(webgl=self.webgl, downloads=self.folder))
        self.page.open(self.address)
        self.page.settled(0)

    def tearDown(self):
        self.assertEqual(self.page.errors(), [])

    def camera(self):
        return [float(self.page.value(name)) for name in ("fov", "focus")]

    def test_a_glass_ball_is_made_red_and_moved(self):
        page = self.page
        self.assertEqual(page.text("title"), "Cornell Box")
        page.press(0.66, 0.75)
        page.wait("return document.getElementById('ball').selectedOptions[0].textContent.includes('glass ball')")
        self.assertEqual(page.value("material"), "dielectric")
        version = page.last()["version"]
        page.set("albedo", "#ff2020")
        page.settled(version)
        time.sleep(1)
        red, green, _ = page.colour(0.66, 0.75)
        self.assertGreater(red - green, CLEAR)
        version, before = page.last()["version"], float(page.value("ball-x"))
        page.drag((0.66, 0.75), (-120, 0))
        page.settled(version)
        self.assertLess(float(page.value("ball-x")), before - 5)
        page.click("undo")
        page.wait("return Math.abs(document.getElementById('ball-x').value - arguments[0]) < 0.01", before)
        page.click("undo")
        page.wait("return document.getElementById('undo').disabled")
        page.chord("z", Keys.CONTROL, Keys.SHIFT)
        page.wait("return !document.getElementById('undo').disabled")
        page.click("reset")
        page.wait("return document.getElementById('reset').disabled")

    def test_the_camera_turns_moves_and_comes_closer(self):
        page = self.page
        ways = [
            lambda: page.drag((0.5, 0.3), (40, 10)),
            lambda: page.drag((0.5, 0.3), (30, 0), Keys.SHIFT),
            lambda: page.keys(Keys.ARROW_LEFT),
            lambda: page.chord(Keys.ARROW_UP, Keys.SHIFT),
            lambda: page.keys(Keys.PAGE_UP),
            lambda: page.run(
                "document.getElementById('stage').dispatchEvent(new WheelEvent('wheel', {deltaY: -120, cancelable: true}))"
            ),
        ]
        for number, way in enumerate(ways):
            with self.subTest(number):
                version = page.last()["version"]
                way()
                page.settled(version)
        versions = page.run("return seen.map((p) => p.version)")
        self.assertEqual(versions, sorted(versions))

    def test_lens_field_of_view_and_focus(self):
        page = self.page
        version = page.last()["version"]
        page.set("fov", 50)
        version = page.settled(version)["version"]
        self.assertEqual(page.text("fov-out"), "50°")
        page.set("lens", 0.5)
        page.settled(version)
        self.assertNotIn("all sharp", page.text("lens-out"))
        page.click("focus-pick")
        self.assertEqual(page.find("focus-pick").get_attribute("aria-pressed"), "true")
        page.press(0.5, 0.45)
        # The back wall is 295.6 away.
        page.wait("return Math.abs(document.getElementById('focus').value - 295.6) < 3")

    def test_lamps_settings_and_engines(self):
        page = self.page
        page.choose("ball", "7")
        page.wait("return !document.getElementById('ball-form').hidden")
        self.assertTrue(page.find("glow-row").is_displayed())
        for name, value in [
            ("glow", 0.6), ("glow-colour", "#00ff00"), ("material", "specular"), ("ball-r", 6), ("ball-y", 60),
            ("photons_per_iteration", 20000), ("initial_radius", 3), ("max_depth", 7), ("seed", "99"),
            ("width", 128), ("height", 96), ("method", "path"), ("engine", "reference"),
        ]:
            with self.subTest(name):
                version = page.last()["version"]
                page.set(name, value)
                page.settled(version)
                self.assertEqual(page.value(name), str(value))
        self.assertEqual(page.last()["wholeWidth"], 128)
        page.set("seed", "no number")
        page.wait("return !document.getElementById('notice').hidden")
        self.assertIn("Seed is not a whole number", page.text("notice"))

    def test_looks(self):
        page = self.page
        page.click("pause")
        page.wait("return document.getElementById('progress').textContent.includes('paused')")
        dark = page.colour(0.5, 0.5)
        page.set("exposure", 3)
        time.sleep(0.3)
        self.assertGreater(sum(page.colour(0.5, 0.5)), sum(dark) + CLEAR)
        page.set("exposure", 0)
        colours = {}
        for tone in ["clamp", "reinhard", "aces", "agx", "false"]:
            page.choose("tone", tone)
            time.sleep(0.3)
            colours[tone] = page.colour(0.5, 0.5)
        self.assertEqual(len(set(colours.values())), 5, colours)
        self.assertTrue(page.find("legend").is_displayed())
        page.choose("tone", "agx")
        for layer, name in enumerate(["image", "direct", "radius", "count"]):
            page.choose("layer", str(layer))
            page.wait("return seen.at(-1).layer === arguments[0]", layer)
            self.assertEqual(page.find("legend").is_displayed(), name in ("radius", "count"))
        page.pointer(0.5, 0.5).perform()
        self.assertRegex(page.text("value"), r"^\d+, \d+:  \S+$")
        page.choose("layer", "0")
        page.wait("return seen.at(-1).layer === 0")
        page.pointer(0.51, 0.5).perform()
        self.assertRegex(page.text("value"), r"^\d+, \d+:  \S+  \S+  \S+$")
        for button in ["zoom-in", "zoom-out", "zoom-one", "zoom-fit"]:
            page.click(button)
        page.keys("]", "[", "+", "-", "1", "0")
        page.keys("?")
        page.wait("return document.getElementById('help-box').open")
        page.keys(Keys.ESCAPE)

    def test_two_engines_are_compared(self):
        page = self.page
        page.click("pin")
        page.wait("return !document.getElementById('divider').hidden")
        version = page.last()["version"]
        page.choose("method", "path")
        page.settled(version)
        page.set("divider", 0.2)
        page.choose("mode", "difference")
        self.assertTrue(page.find("legend").is_displayed())
        page.choose("mode", "b")
        page.choose("other", "")
        self.assertFalse(page.find("divider").is_displayed())

    def test_saved_files_render_to_the_same_image(self):
        page = self.page
        page.press(0.66, 0.75)
        page.wait("return !document.getElementById('ball-form').hidden")
        version = page.last()["version"]
        page.set("ball-x", 60)
        page.settled(version)
        page.click("save")
        page.wait("return !document.getElementById('save-links').hidden")
        for link in page.run("return [...document.querySelectorAll('#save-links a')]"):
            link.click()
            time.sleep(0.3)
        folder = pathlib.Path(self.folder)
        names = {f"cornell.{extension}" for extension in ("png", "exr", "toml", "sppm")}
        until = time.monotonic() + 20
        while {path.name for path in folder.iterdir()} != names:
            self.assertLess(time.monotonic(), until, list(folder.iterdir()))
            time.sleep(0.1)
        text = (folder / "cornell.toml").read_text()
        self.assertIn("# The Cornell Box", text)
        self.assertIn("center = [60, 16.5, 78]", text)
        for name in ["again.exr", "again.png"]:
            render = [SPPM, "render", "cornell.toml", "-o", name, "--quiet", "--no-checkpoint"]
            program = str(pathlib.Path(SPPM).resolve())
            subprocess.run([program, *render[1:]], cwd=folder, check=True)
            saved = "cornell" + name[5:]
            judged = subprocess.run([program, "compare", saved, name, "--max-abs", "0"], cwd=folder, capture_output=True)
            self.assertEqual(judged.returncode, 0, judged)

    def test_the_page_says_when_the_server_is_gone_and_comes_back(self):
        # The same address again needs the same token and port.
        token, port = "0123456789abcdef0123", "18734"
        environment = {**os.environ, "SPPM_VIEW_TOKEN": token}
        arguments = ["view", "cornell", *QUICK, "--port", port]
        page = self.page
        with served(*arguments, env=environment) as (_, address):
            page.open(address)
        page.wait("return !document.getElementById('notice').hidden")
        self.assertIn("The program has ended, or cannot be reached", page.text("notice"))
        self.assertTrue(page.find("picture").is_displayed())
        with served(*arguments, env=environment):
            page.run("window.seen = []")
            page.wait("return document.getElementById('notice').hidden && seen.length > 0")
        # Lost connections are logged by the browser.
        page.browser.get_log("browser")

    def test_impossible_moves_are_told_and_undone(self):
        page = self.page
        for _ in range(30):
            page.chord(Keys.ARROW_RIGHT * 10, Keys.SHIFT)
            if page.run("return !document.getElementById('notice').hidden"):
                break
        self.assertRegex(page.text("notice"), "light reaches the eye|cuts through|lies on")
        page.settled(1)


class StudioWithoutWebGl(Studio):
    """The same on a plain canvas."""

    webgl = False

    def test_the_painter(self):
        self.assertEqual(self.page.run("return document.body.dataset.painter"), "canvas")


class Files(unittest.TestCase):
    """Images to look at, and renders that run."""

    def test_images_are_shown_and_compared(self):
        with tempfile.TemporaryDirectory() as folder:
            names = [str(pathlib.Path(folder) / name) for name in ("a.exr", "b.exr")]
            for seed, name in enumerate(names):
                subprocess.run([SPPM, "render", "cornell", *QUICK, "-n", "2", "-o", name, "-q", "--seed", str(seed)], check=True)
            with Page() as page:
                with served("view", names[0]) as (_, address):
                    page.open(address)
                    self.assertEqual(page.text("title"), "a.exr")
                    self.assertFalse(page.find("save").is_displayed())
                with served("compare", *names, "--view") as (_, address):
                    page.open(address)
                    page.wait("return !document.getElementById('divider').hidden")
                    page.choose("mode", "difference")
                    self.assertTrue(page.find("legend").is_displayed())

    def test_a_render_that_runs_is_watched(self):
        with tempfile.TemporaryDirectory() as folder:
            image = str(pathlib.Path(folder) / "a.png")
            arguments = ["render", "cornell", *QUICK, "-n", "100000", "-o", image, "--view"]
            with Page() as page, served(*arguments) as (process, address):
                page.open(address)
                first = page.last()["iterations"]
                page.wait("return seen.at(-1).iterations > arguments[0]", first)
                self.assertFalse(page.find("undo").is_displayed())
                process.send_signal(signal.SIGINT)
                self.assertEqual(process.wait(30), 130)
                self.assertTrue(pathlib.Path(image).exists())


class ManyBalls(unittest.TestCase):
    """A hundred thousand particles of two kinds."""

    def test_styles_and_numbers(self):
        side = 46
        with tempfile.TemporaryDirectory() as folder:
            file = pathlib.Path(folder) / "many.xyz"
            atoms = [f"{'O' if (x + y + z) % 2 else 'C'} {3 * x} {3 * y} {3 * z}"
                     for x in range(side) for y in range(side) for z in range(side + 2)]
            file.write_text("\n".join([str(len(atoms)), "", *atoms]) + "\n")
            with served("view", str(file), "--width", "256", "--height", "192", "--threads", "2") as (_, address), Page() as page:
                page.open(address)
                page.settled(0)
                self.assertGreater(page.run("return document.getElementById('style').options.length"), 2)
                # A ball that is not listed, by its number.
                page.set("ball-number", 90000)
                page.wait("return !document.getElementById('ball-form').hidden")
                self.assertEqual(page.value("ball-number"), "90000")
                own = page.value("style")
                page.click("styled")
                version = page.last()["version"]
                page.set("albedo", "#20ff20")
                began = time.monotonic()
                page.settled(version)
                print(json.dumps({"balls": len(atoms), "seconds from a style's change to the whole picture":
                                  round(time.monotonic() - began, 2)}))
                page.wait("return document.getElementById('albedo').value === '#20ff20'")
                self.assertEqual((page.value("style"), page.value("ball-number")), (own, "90000"))
                # The list stays as quick as a short one.
                self.assertLess(page.run("return document.getElementById('ball').options.length"), 2010)
                # The first ball of another style, which kept its colour.
                page.choose("style", "1" if own == "0" else "0")
                page.wait("return document.getElementById('albedo').value !== '#20ff20'")
                page.click("undo")
                page.wait("return document.getElementById('undo').disabled")
                self.assertEqual(page.errors(), [])


class Quality(unittest.TestCase):
    def test_settings_are_chosen_at_the_quality_that_is_asked_for(self):
        chosen = {}
        for quality in ("paper", "draft", "final"):
            with served("view", "cornell", "--width", "64", "--height", "48", "--quality", quality) as (_, address), Page() as page:
                page.open(address)
                chosen[quality] = [float(page.value(name)) for name in ("initial_radius", "max_depth")]
        self.assertEqual(chosen["paper"], [2, 5])
        self.assertNotEqual(chosen["draft"][0], 2)
        # Better pictures lose less light by a finite depth; the radius of a render without end is the same for both.
        self.assertGreaterEqual(chosen["final"][1], chosen["draft"][1])


class FirstSight(unittest.TestCase):
    def test_a_picture_is_on_the_screen_within_three_seconds(self):
        with Page() as page:
            page.open("about:blank", whole=False)
            began = time.monotonic()
            with served("view", "cornell", "--threads", "2") as (_, address):
                page.open(address)
                taken = time.monotonic() - began
            print(json.dumps({"seconds to the first picture": round(taken, 2)}))
            self.assertLess(taken, 3)


if __name__ == "__main__":
    unittest.main(verbosity=2)
