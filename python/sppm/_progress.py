"""The progress of a render, and the bar that shows it."""

from __future__ import annotations

import sys
from collections.abc import Callable
from dataclasses import dataclass
from importlib import import_module
from importlib.util import find_spec
from types import TracebackType
from typing import Any, TextIO, TypeAlias

from . import _sppm


@dataclass(frozen=True)
class Progress:
    """How far a render is."""

    iteration: int = 0
    """Iterations done."""
    iterations: int = 0
    """Iterations asked for."""
    seconds: float = 0.0
    """Seconds of the last iteration."""
    elapsed_seconds: float = 0.0
    """Seconds since the start, or since it was resumed."""
    photons: int = 0
    """Photons so far."""
    mean_radius: float | None = None
    """The mean search radius of all pixels, in scene units; ``None`` without photons."""
    estimated_error: float | None = None
    """The last estimate of the relative error; ``None`` unless the render has the goal ``until_error``."""
    saved: bool = False
    """Whether a checkpoint was written after this iteration."""
    share: float = 0.0
    """The share of the next iteration that is done, from 0 to 1."""


Show: TypeAlias = bool | None | Callable[[Progress], object]
"""``True`` shows a bar, ``False`` none, ``None`` one in terminals and notebooks; a function is called instead."""


class Bar:
    """Shows progress as asked."""

    def __init__(self, show: Show, iterations: int) -> None:
        """A bar over ``iterations``, if asked for, or in terminals and notebooks."""
        if not (show is None or isinstance(show, bool) or callable(show)):
            raise TypeError(f"progress must be True, False, None or a function, not {type(show).__name__}")
        self._call = show if callable(show) else None
        self._told: Progress | None = None
        self._bar: Any = None
        if show is True or (show is None and _is_watched()):
            tqdm = _tqdm()
            is_open = iterations >= _sppm.MAX_ITERATIONS
            self._bar = tqdm(total=None if is_open else iterations, unit="iteration", leave=False)

    def update(self, progress: Progress) -> None:
        """Shows ``progress``, if it is news."""
        if self._told is not None and self._told.iteration == progress.iteration:
            return
        if progress.iteration == 0:
            return
        self._told = progress
        if self._call is not None:
            self._call(progress)
        if self._bar is not None:
            self._bar.update(progress.iteration - self._bar.n)

    def __enter__(self) -> Bar:
        """The bar itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Removes the bar."""
        if self._bar is not None:
            self._bar.close()


def _is_notebook() -> bool:
    shell = sys.modules.get("IPython")
    return "ipykernel" in sys.modules and shell is not None and shell.get_ipython() is not None


def _is_watched() -> bool:
    """Whether a person watches: in a terminal or in a notebook."""
    stream: TextIO | None = sys.stderr
    return _is_notebook() or (stream is not None and stream.isatty())


def _tqdm() -> Any:
    """The bar of notebooks, where there are widgets, or else that of terminals."""
    has_widgets = _is_notebook() and find_spec("ipywidgets") is not None
    # Only here, as it takes time to import.
    return import_module("tqdm.notebook" if has_widgets else "tqdm.std").tqdm
