"""Whether all engines give the same bits."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from typing import Any

import numpy as np

from . import _sppm
from ._film import Film
from ._options import Method
from ._render import Render
from ._scene import Scene


@dataclass(frozen=True)
class Verification:
    """The outcome of :func:`sppm.verify`. It is true if all engines agree."""

    identical: bool
    """Whether every bit of image, alpha, radii and counts was the same after each iteration."""
    variants: tuple[str, ...]
    """What was compared with the reference."""
    difference: str | None
    """The first difference, in one line; ``None`` if there is none."""

    def __bool__(self) -> bool:
        """Whether all engines agree."""
        return self.identical


def verify(scene: Scene, *, method: Method = "sppm", threads: int | None = None, **settings: Any) -> Verification:
    """Renders with the reference, and with the fast engine on all lanes that this processor has, on one thread and on
    ``threads`` (by default one per core), and compares every bit of image, alpha, radii and counts after each iteration.

    Settings are given by name, as in :func:`sppm.render`. Raises what :func:`sppm.render` raises.
    """
    with ExitStack() as stack:

        def start(**options: Any) -> Render:
            return stack.enter_context(Render(scene, method=method, paused=True, **settings, **options))

        reference = start(engine="reference", threads=threads)
        most = _sppm.cores() if threads is None else threads
        variants = {
            f"fast on {lanes} lanes and {count} {'thread' if count == 1 else 'threads'}": start(
                lanes=lanes, threads=count
            )
            for lanes in _sppm.lanes()
            for count in dict.fromkeys((1, most))
        }
        names = tuple(variants)
        while not reference.is_over:
            right = reference.iterate()
            for name, variant in variants.items():
                for difference in _differences(variant.iterate(), right):
                    done = reference.progress.iteration
                    said = f"{name} differs from the reference in iteration {done}: {difference}"
                    return Verification(False, names, said)
            if reference.progress.iteration >= reference.progress.iterations:
                break
        return Verification(True, names, None)


def _differences(film: Film | None, right: Film | None) -> Iterator[str]:
    """The first differing value of each array."""
    for name in ("count", "radius", "radiance", "alpha"):
        a, b = (getattr(one, name, None) for one in (film, right))
        if a is None or b is None:
            continue
        differing = np.argwhere(a.view(np.uint32) != b.view(np.uint32))
        if len(differing) > 0:
            place = tuple(int(i) for i in differing[0])
            y, x = place[:2]
            yield f"{name} of pixel ({x}, {y}) is {a[place]} instead of {b[place]}"
