"""The command ``sppm farm``, or ``python -m sppm.farm``."""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path
from typing import Any

import sppm
from sppm import Settings, _sppm

EPILOG = """examples:
  sppm farm cornell -n 4096 -o cornell.exr                       one worker per core of this machine
  sppm farm cornell -n 4096 -o cornell.exr --scheduler tcp://head:8786
  sppm farm scenes/ -n 64 -o images/                             all scene files of a folder
  sppm farm cornell --sweep radius=0.5,1,2 --sweep seed=1,2 -o sweep/
  sppm farm cornell -n 4096 -o cornell.exr --view                watch it in the browser

Begun again, it goes on from OUT.sppm, which stays. docs/farm.md tells of Slurm, TLS and what can go wrong."""


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="sppm farm",
        description="Render on many machines, by Dask distributed, to the bits of a single one.",
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = parser.add_argument
    add("scenes", nargs="+", metavar="SCENE", help="a built-in scene, a scene file, or a folder of scene files")
    add("-o", "--output", type=Path, metavar="OUT", help="the image; of several renders, the folder of their images")
    add("--sweep", action="append", default=[], metavar="NAME=A,B,...",
        help="render once for each value of a setting; several sweeps give all combinations")
    settings = parser.add_argument_group("settings, each by default the scene's own, or chosen from it as by sppm render")
    settings.add_argument("-n", "--iterations", type=int, metavar="N")
    settings.add_argument("--width", type=int, metavar="W")
    settings.add_argument("--height", type=int, metavar="H")
    settings.add_argument("--photons", type=int, dest="photons_per_iteration", metavar="L")
    settings.add_argument("--depth", type=int, dest="max_depth", metavar="D")
    settings.add_argument("--glint-samples", type=int, dest="glint_samples", metavar="N")
    settings.add_argument("--radius", type=float, dest="initial_radius", metavar="R")
    settings.add_argument("--seed", type=int, metavar="S")
    settings.add_argument("--filter", metavar="FILTER")
    settings.add_argument("--quality", choices=["paper", "draft", "good", "final"],
        help="choose iterations, photons, radius and depth that are not given [good, for scenes that state none of them]")
    farm = parser.add_argument_group("workers")
    farm.add_argument("--workers", type=int, metavar="N", help="workers on this machine, of one thread each [one per core]")
    farm.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler, such as tcp://head:8786")
    farm.add_argument("--threads", type=int, default=1, metavar="T", help="threads that a block is rendered on [1]")
    farm.add_argument("--block", type=int, metavar="B", help="iterations of a block [as many as take 10 seconds]")
    farm.add_argument("--every", type=float, default=10.0, metavar="S", help="seconds between two images [10]")
    view = parser.add_argument_group("viewers")
    view.add_argument("--view", action="store_true", help="show the images on a page, whose address is printed; see docs/view.md")
    view.add_argument("--port", type=int, metavar="PORT", help="serve the page at this port [any that is free]")
    view.add_argument("--listen", metavar="ADDRESS", help="serve it at this address of the machine [127.0.0.1]")
    view.add_argument("--no-open", action="store_true", help="do not open the page in the browser")
    view.add_argument("--display", metavar="HOST[:PORT]", help="send the images to tev, or HDRView [port 14158]")
    tls = parser.add_argument_group("TLS, for a scheduler at tls://, or between local workers")
    tls.add_argument("--tls-ca", type=Path, metavar="PEM", help="the authority that signs certificates")
    tls.add_argument("--tls-cert", type=Path, metavar="PEM", help="the certificate of this side")
    tls.add_argument("--tls-key", type=Path, metavar="PEM", help="its key, if that is not in the same file")
    add("-q", "--quiet", action="store_true", help="say nothing unless something is wrong")
    return parser


def _check(arguments: argparse.Namespace) -> None:
    """Refuses what argparse does not."""
    for name in ("workers", "threads", "block"):
        value = getattr(arguments, name)
        if value is not None and value < 1:
            raise sppm.InputError(f"--{name} {value} must be at least 1")
    if not 0.0 < arguments.every < 1e6:
        raise sppm.InputError(f"--every {arguments.every} must be above 0 seconds")
    if arguments.workers is not None and arguments.scheduler is not None:
        raise sppm.InputError("--workers are those of this machine, and --scheduler has its own; leave out one of the two")
    for name in ("port", "listen", "no_open"):
        if getattr(arguments, name) not in (None, False) and not arguments.view:
            raise sppm.InputError(f"--{name.replace('_', '-')} is of the page; ask for it by --view")
    if arguments.port is not None and not 1 <= arguments.port <= 65535:
        raise sppm.InputError(f"--port {arguments.port} must be from 1 to 65535")
    for name in ("tls_ca", "tls_cert", "tls_key"):
        file = getattr(arguments, name)
        if file is not None and not file.is_file():
            raise sppm.FileError(f"{file}: there is no such file (--{name.replace('_', '-')})")
    if any((arguments.tls_ca, arguments.tls_cert, arguments.tls_key)) and not all((arguments.tls_ca, arguments.tls_cert)):
        raise sppm.InputError("TLS needs --tls-ca and --tls-cert, and --tls-key if the key is not in the certificate's file")


def main(words: list[str] | None = None) -> int:
    """Runs the command; returns its exit code."""
    arguments = _parser().parse_args(words)
    try:
        importlib.import_module("distributed")
    except ModuleNotFoundError as error:
        print(f"error: {error}; the farm needs Dask: pip install 'sppm[farm]'", file=sys.stderr)
        return 2
    from ._cluster import client_of
    from ._driver import Driver
    from ._jobs import jobs_of

    line = _Line(arguments.quiet)
    try:
        _check(arguments)
        # The options of settings have their names.
        settings = {name: value for name, value in vars(arguments).items() if name in Settings.__dataclass_fields__}
        jobs = jobs_of(arguments.scenes, arguments.output, settings, arguments.sweep, arguments.quality)
        viewer = _viewer(arguments, jobs[0].output.name)
        for job in jobs:
            if job.chosen:
                line.tell(f"{job.output}: chosen for {job.chosen}")
        tls = {"ca": arguments.tls_ca, "certificate": arguments.tls_cert, "key": arguments.tls_key}
        with client_of(arguments.workers, arguments.scheduler, **tls) as client:
            driver = Driver(client, threads=arguments.threads, block=arguments.block, every=arguments.every,
                            tell=line.tell, show=line.show, viewer=viewer)
            driver.run(jobs)
    except (sppm.InputError, sppm.FileError) as error:
        line.fail(str(error))
        return 2
    except (sppm.Error, OSError) as error:
        line.fail(f"{error}; what is done is kept, and the same command goes on from there")
        return 1
    except KeyboardInterrupt:
        line.fail("interrupted; what is done is kept, and the same command goes on from there")
        return 130
    finally:
        line.clear()
    return 0


def _viewer(arguments: argparse.Namespace, name: str) -> Any:
    """What shows the images while they are rendered, if it is asked for."""
    if not arguments.view and arguments.display is None:
        return None
    page = (arguments.listen, arguments.port) if arguments.view else None
    try:
        viewer = _sppm.Viewer(name, page, arguments.display)
    except sppm.InputError as error:
        raise sppm.InputError(f"--{error}") from None
    if viewer.address is not None:
        print(viewer.address, flush=True)
        if not arguments.no_open:
            viewer.open()
    return viewer


class _Line:
    """Messages on standard error, and below them, on a terminal, a line of progress."""

    def __init__(self, is_quiet: bool) -> None:
        self._is_quiet = is_quiet
        self._is_terminal = sys.stderr.isatty()
        self._shown = ""

    def tell(self, text: str) -> None:
        """A message."""
        if not self._is_quiet:
            self.clear()
            print(text, file=sys.stderr, flush=True)

    def show(self, text: str) -> None:
        """The progress."""
        if self._is_terminal and not self._is_quiet and text != self._shown:
            print(f"\r\x1b[K{text}", end="", file=sys.stderr, flush=True)
            self._shown = text

    def fail(self, text: str) -> None:
        """An error."""
        self.clear()
        print(f"error: {text}", file=sys.stderr, flush=True)

    def clear(self) -> None:
        """Takes the line of progress away."""
        if self._shown:
            print("\r\x1b[K", end="", file=sys.stderr, flush=True)
            self._shown = ""


if __name__ == "__main__":
    sys.exit(main())
