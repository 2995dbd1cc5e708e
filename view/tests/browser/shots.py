"""Makes pictures of the page, to be looked at: wide and narrow, dark and light, with WebGL and without."""

import pathlib
import sys
import time

from page import Page, served

folder = pathlib.Path(sys.argv[1] if len(sys.argv) > 1 else "out")
folder.mkdir(parents=True, exist_ok=True)


def shoot(page, name):
    time.sleep(1)
    page.browser.save_screenshot(str(folder / f"{name}.png"))


with served("view", "cornell", "--threads", "2") as (_, address):
    with Page() as page:
        page.open(address)
        page.wait("return seen.at(-1).iterations > 20")
        shoot(page, "dark")
        page.press(0.66, 0.75)
        page.wait("return !document.getElementById('ball-form').hidden")
        shoot(page, "ball")
        page.run("document.getElementById('panel').scrollTo(0, 10000)")
        shoot(page, "statistics")
        page.choose("tone", "false")
        page.click("pin")
        shoot(page, "compare")
        page.click("save")
        page.wait("return !document.getElementById('save-links').hidden")
        shoot(page, "save")
    with Page(dark=False, webgl=False) as page:
        page.open(address)
        page.choose("layer", "2")
        page.wait("return seen.at(-1).layer === 2")
        shoot(page, "light")
        page.run("document.getElementById('help').click()")
        shoot(page, "help")
    for dark in (True, False):
        with Page(size=(390, 844), dark=dark, webgl=dark) as page:
            page.open(address)
            shoot(page, "phone-dark" if dark else "phone-light")
            page.press(0.66, 0.75)
            page.wait("return !document.getElementById('ball-form').hidden")
            page.run("document.getElementById('panel').scrollTo(0, 120)")
            shoot(page, "phone-ball-dark" if dark else "phone-ball-light")
with Page() as page:
    with served("view", "heap", "--threads", "2") as (_, address):
        page.open(address)
        shoot(page, "heap")
    page.wait("return !document.getElementById('notice').hidden")
    shoot(page, "gone")
