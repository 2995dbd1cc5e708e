"""Makes HTML of the docstrings and of these pages: build.py FOLDER. The package must be importable."""

from __future__ import annotations

import shutil
import sys
import tempfile
from pathlib import Path

import pdoc
import pdoc.render

import sppm

HERE = Path(__file__).parent
PAGES = ("scenes", "particles", "renders", "images", "rays")


def main(folder: Path) -> None:
    """Writes the pages into ``folder``."""
    text = [HERE.parent.joinpath("README.md").read_text(), *((HERE / f"{page}.md").read_text() for page in PAGES)]
    whole = "\n\n".join(text)
    for page in PAGES:
        whole = whole.replace(f"(docs/{page}.md)", f"(#{page})").replace(f"({page}.md)", f"(#{page})")
    sppm.__doc__ = whole
    pdoc.render.configure(docformat="restructuredtext", search=False, show_source=False)
    with tempfile.TemporaryDirectory() as beside:
        pdoc.pdoc("sppm", output_directory=Path(beside))
        shutil.copytree(beside, folder, dirs_exist_ok=True)
    print(f"wrote {folder / 'sppm.html'}")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
