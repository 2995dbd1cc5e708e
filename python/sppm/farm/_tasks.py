"""What runs on the workers: functions of plain values and bytes, each of which can be run again anywhere.

A part is the content of a checkpoint file. It is checked by its checksums, and against the render it is to be of,
whenever it is read; nothing in it is executed or unpickled.
"""

from __future__ import annotations

import tempfile
import zlib
from collections import OrderedDict
from pathlib import Path

import sppm
from sppm import _sppm
from sppm._errors import RenderError

_SCENES_KEPT = 4
_scenes: OrderedDict[str, sppm.Scene] = OrderedDict()


def versions() -> tuple[str, int]:
    """Versions of the package and of the light transport on this worker."""
    return sppm.__version__, _sppm.TRANSPORT


def hand_on(packed: bytes) -> bytes:
    """The scene, as a task: workers get it from each other, and the scheduler can make it again."""
    return packed


def pack(scene: sppm.Scene) -> bytes:
    """The scene with its settings, as bytes."""
    return zlib.compress(scene.to_toml().encode())


def _unpack(packed: bytes, name: str) -> sppm.Scene:
    """The scene; those used last are kept."""
    scene = _scenes.get(name)
    if scene is None:
        scene = _scenes[name] = sppm.Scene.parse(zlib.decompress(packed).decode())
        while len(_scenes) > _SCENES_KEPT:
            _scenes.popitem(last=False)
    return scene


def render_block(
    packed: bytes, name: str, start: int, stop: int, threads: int | None, transport: int
) -> bytes:
    """The part with the iterations from ``start`` to before ``stop`` of the scene called ``name``."""
    if transport != _sppm.TRANSPORT:
        raise RenderError(f"this worker computes version {_sppm.TRANSPORT} of the light transport, not {transport}")
    with tempfile.TemporaryDirectory(prefix="sppm-farm-") as folder:
        file = Path(folder, "part.sppm")
        sppm.render_part(_unpack(packed, name), start, stop, file, threads=threads)
        return file.read_bytes()


def add_parts(parts: list[bytes]) -> bytes:
    """The sum of parts, which is a part again."""
    if len(parts) == 1:
        return parts[0]
    with tempfile.TemporaryDirectory(prefix="sppm-farm-") as folder:
        files = [Path(folder, f"{number}.sppm") for number in range(len(parts))]
        for file, part in zip(files, parts, strict=True):
            file.write_bytes(part)
        total = Path(folder, "sum.sppm")
        sppm.merge(files, total)
        return total.read_bytes()

