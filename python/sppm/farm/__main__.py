"""The command ``sppm farm``, or ``python -m sppm.farm``."""

from __future__ import annotations

import argparse
import importlib
import sys
from pathlib import Path

import sppm

EPILOG = """examples:
  sppm farm cornell -n 4096 -o cornell.exr                       one worker per core of this machine
  sppm farm cornell -n 4096 -o cornell.exr --scheduler tcp://head:8786
  sppm farm scenes/ -n 64 -o images/                             all scene files of a folder
  sppm farm cornell --sweep radius=0.5,1,2 --sweep seed=1,2 -o sweep/

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
    settings = parser.add_argument_group("settings, each by default the scene's own")
    settings.add_argument("-n", "--iterations", type=int, metavar="N")
    settings.add_argument("--width", type=int, metavar="W")
    settings.add_argument("--height", type=int, metavar="H")
    settings.add_argument("--photons", type=int, dest="photons_per_iteration", metavar="L")
    settings.add_argument("--depth", type=int, dest="max_depth", metavar="D")
    settings.add_argument("--radius", type=float, dest="initial_radius", metavar="R")
    settings.add_argument("--seed", type=int, metavar="S")
    settings.add_argument("--filter", metavar="FILTER")
    farm = parser.add_argument_group("workers")
    farm.add_argument("--workers", type=int, metavar="N", help="workers on this machine, of one thread each [one per core]")
    farm.add_argument("--scheduler", metavar="ADDRESS", help="a Dask scheduler, such as tcp://head:8786")
    farm.add_argument("--threads", type=int, default=1, metavar="T", help="threads that a block is rendered on [1]")
    farm.add_argument("--block", type=int, metavar="B", help="iterations of a block [as many as take 10 seconds]")
    farm.add_argument("--every", type=float, default=10.0, metavar="S", help="seconds between two images [10]")
    tls = parser.add_argument_group("TLS, for a scheduler at tls://, or between local workers")
    tls.add_argument("--tls-ca", type=Path, metavar="PEM", help="the authority that signs certificates")
    tls.add_argument("--tls-cert", type=Path, metavar="PEM", help="the certificate of this side")
    tls.add_argument("--tls-key", type=Path, metavar="PEM", help="its key")
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
    for name in ("tls_ca", "tls_cert", "tls_key"):
        file = getattr(arguments, name)
        if file is not None and not file.is_file():
            raise sppm.FileError(f"{file}: there is no such file (--{name.replace('_', '-')})")


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
    names = "iterations width height photons_per_iteration max_depth initial_radius seed filter".split()
    try:
        _check(arguments)
        settings = {name: getattr(arguments, name) for name in names}
        jobs = jobs_of(arguments.scenes, arguments.output, settings, arguments.sweep)
        tls = {"ca": arguments.tls_ca, "certificate": arguments.tls_cert, "key": arguments.tls_key}
        with client_of(arguments.workers, arguments.scheduler, **tls) as client:
            driver = Driver(client, threads=arguments.threads, block=arguments.block, every=arguments.every,
                            tell=line.tell, show=line.show)
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
