"""Parts of a render: some of its iterations, in a file, and the sum of such files."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass

from . import _numbers, _sppm
from ._errors import InputError
from ._options import Engine, Lanes, options
from ._render import Render
from ._scene import Scene, Source, native


@dataclass(frozen=True)
class Merged:
    """What parts hold together. Ranges of iterations are ``(start, stop)``, from 0, without ``stop``."""

    iterations: list[tuple[int, int]]
    """The iterations in the parts."""
    missing: list[tuple[int, int]]
    """The iterations of the render that are in no part."""
    repeated: list[str]
    """The files that were not needed, as their iterations are in others too."""


def render_part(
    scene: Scene,
    start: int,
    stop: int,
    file: Source,
    *,
    engine: Engine = "fast",
    lanes: Lanes | None = None,
    threads: int | None = None,
    memory_limit: int | None = None,
) -> None:
    """Renders the iterations from ``start`` to before ``stop``, counted from 0, into the checkpoint ``file``.

    ``scene.settings.radius_schedule`` must be ``"global"``. If ``file`` holds some of the same part, the render goes on
    from there. :func:`merge` adds parts up, whoever rendered them, to the bits of the whole render.

    Raises InputError if there are no such iterations, and what :func:`sppm.render` raises.
    """
    most = _sppm.MAX_ITERATIONS
    numbers = [_numbers.whole(value, name, 0, most, InputError) for value, name in ((start, "start"), (stop, "stop"))]
    checked = options(
        settings=scene.settings,
        engine=engine,
        lanes=lanes,
        threads=threads,
        memory_limit=memory_limit,
        checkpoint=file,
        range=(numbers[0], numbers[1]),
    )
    with Render.adopt(_sppm.Render.start(native(scene), checked), False) as render:
        render.result(progress=False)


def merge(parts: Iterable[Source], output: Source | None = None) -> Merged:
    """Adds up parts of one render, in any order, and writes the sum to ``output``: a checkpoint, ``.sppm``, or an image.

    Iterations that are in several parts are counted once. Without ``output``, it tells what the parts hold.

    Raises InputError if a part is damaged or of another render, or if parts overlap and cannot be told apart.
    """
    paths = [os.fspath(part) for part in parts]
    return Merged(*_sppm.merge(paths, None if output is None else os.fspath(output)))
