"""Every example of the documentation runs, and the pages can be built."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import sppm

ROOT = Path(__file__).parents[1]
PAGES = [ROOT.parent / "README.md", ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
EXAMPLE = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)


def test_pages_have_examples() -> None:
    assert [page.name for page in PAGES] == [
        "README.md",
        "README.md",
        "images.md",
        "particles.md",
        "rays.md",
        "renders.md",
        "scenes.md",
    ]
    assert all(len(EXAMPLE.findall(page.read_text())) >= 1 for page in PAGES)


@pytest.mark.parametrize("page", PAGES, ids=lambda page: f"{page.parent.name}-{page.name}")
def test_examples_run(page: Path, tmp_path: Path, monkeypatch) -> None:
    """The examples of a page are one program."""
    text = page.read_text()
    if "from ase" in text:
        pytest.importorskip("ase")
    monkeypatch.chdir(tmp_path)
    names: dict[str, object] = {}
    for example in EXAMPLE.finditer(text):
        # So that errors show the line of the page.
        lines = "\n" * text.count("\n", 0, example.start(1))
        exec(compile(lines + example.group(1), page, "exec"), names)


def test_links_lead_somewhere() -> None:
    for page in PAGES:
        for link in re.findall(r"\]\(([^)#]+)\)", page.read_text()):
            if not link.startswith("https://"):
                assert (page.parent / link).exists(), f"{page.name}: {link}"


def test_pages_are_built(tmp_path: Path) -> None:
    pytest.importorskip("pdoc")
    build = [sys.executable, str(ROOT / "docs/build.py"), str(tmp_path / "html")]
    done = subprocess.run(build, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "Warn" not in done.stderr
    page = (tmp_path / "html/sppm.html").read_text()
    for name in sppm.__all__:
        assert f'id="{name}"' in page, name
    for member in ("Scene.add_spheres", "Film.radiance", "Render.films", "Settings.width"):
        assert f'id="{member}"' in page
    for text in ("Photon mapping from Python", "Ctrl-C, or the button of a notebook", "Whether all engines agree"):
        assert text in page
    assert ":func:" not in page and ":class:" not in page
