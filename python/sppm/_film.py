"""Images, in memory and in files."""

from __future__ import annotations

import json
import os
import tempfile
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _arrays, _sppm
from ._errors import FileError, InputError
from ._numbers import positive, single
from ._scene import Scene, Source

Tone: TypeAlias = Literal["clamp"] | Literal["reinhard"] | Literal["aces"] | Literal["agx"]
"""How a picture shows bright light."""
Floats = npt.NDArray[np.float32]
"""An array of 32-bit floats."""
_Shown: TypeAlias = tuple[
    tuple[Floats, Floats | None], str | None, float | None, tuple[str, float] | None, tuple[str, float] | None
]


class Film:
    """An image: linear radiance, alpha if the background is transparent, and where it was rendered, radii, photon counts,
    and how it was made.

    A film does not change: its arrays are read-only. It is independent of the render that made it. A notebook shows it
    as a picture. NumPy takes a film as the array ``radiance``.
    """

    radiance: Floats
    """Linear RGB radiance, in W sr^-1 m^-2 per channel: shape (height, width, 3), rows from the top. With ``alpha`` it is
    what the pixel adds to whatever is behind it ("associated" with alpha, or premultiplied, as in EXR files)."""
    alpha: Floats | None
    """The share of every pixel that is covered: shape (height, width). ``None`` unless the background is transparent. It
    goes from 0 to 1; filters with negative weights leave this range a little."""
    radius: Floats | None
    """The search radius of every pixel, in scene units: shape (height, width). ``None`` without photons."""
    count: Floats | None
    """The photons counted in every pixel, weighted by alpha (2/3): shape (height, width). ``None`` without photons."""

    __slots__ = ("__weakref__", "_note", "_tone", "alpha", "count", "radiance", "radius")

    def __init__(
        self,
        radiance: npt.ArrayLike,
        *,
        alpha: npt.ArrayLike | None = None,
        radius: npt.ArrayLike | None = None,
        count: npt.ArrayLike | None = None,
    ) -> None:
        """A film of your own: ``radiance`` has shape (height, width, 3), ``alpha``, ``radius`` and ``count`` (height, width).

        Raises InputError for other shapes, and TypeError for anything but real numbers.
        """
        pixels = _arrays.picture(radiance, "radiance", InputError)
        # A copy if it is not one yet, as the given array may be changed later.
        self.radiance = _owned(pixels, radiance)
        planes: list[Floats | None] = []
        for name, values in (("alpha", alpha), ("radius", radius), ("count", count)):
            if values is None:
                planes.append(None)
            else:
                planes.append(_owned(_arrays.plane(values, pixels.shape[:2], name, InputError), values))
        self.alpha, self.radius, self.count = planes
        self._note: str | None = None
        self._tone: Tone | None = None

    @classmethod
    def _of(
        cls,
        radiance: Floats,
        alpha: Floats | None = None,
        radius: Floats | None = None,
        count: Floats | None = None,
        note: str | None = None,
        tone: Tone | None = None,
    ) -> Film:
        """A film of read-only arrays, without a copy, which is shown by ``tone`` if no other is asked for."""
        film = cls.__new__(cls)
        film.radiance, film.alpha, film.radius, film.count = radiance, alpha, radius, count
        film._note, film._tone = note, tone
        return film

    @classmethod
    def load(cls, path: Source, *, layer: str | None = None) -> Film:
        """Reads an image: PNG, JPEG, EXR, PFM, HDR, TIFF, WebP or QOI; ``layer`` is that of an EXR file with layers.

        Integers are decoded from sRGB. Alpha is not read. Raises FileError if the file cannot be read.
        """
        radiance, note = _sppm.read_image(os.fspath(path), layer)
        return cls._of(radiance, note=note)

    @property
    def width(self) -> int:
        """Width in pixels."""
        return int(self.radiance.shape[1])

    @property
    def height(self) -> int:
        """Height in pixels."""
        return int(self.radiance.shape[0])

    @property
    def rgba(self) -> Floats:
        """``radiance`` and ``alpha`` in one array: shape (height, width, 4), as the channels R, G, B and A of EXR files hold
        them, colours premultiplied. Alpha is 1 in films without. The array is new each time."""
        alpha = np.ones(self.radiance.shape[:2], np.float32) if self.alpha is None else self.alpha
        return np.dstack((self.radiance, alpha))

    @property
    def metadata(self) -> dict[str, Any]:
        """How the image was made: version, scene and its digest, settings, method, engine, photons.

        It is the same as ``sppm info`` tells of image files; empty if it is not known.
        """
        return {} if self._note is None else json.loads(self._note)

    @property
    def iterations(self) -> int:
        """Iterations in the image; 0 if that is not known."""
        return int(self.metadata.get("settings", {}).get("iterations", 0))

    @property
    def scene(self) -> Scene | None:
        """The scene that was rendered, with the settings of the render.

        ``None`` if that is not known, or if its text is longer than a mebibyte. Images of the command may name files of
        particles, which are searched in the current folder; raises SceneError if they are not there.
        """
        text = self.metadata.get("scene_file")
        return None if text is None else Scene.parse(text)

    def save(
        self,
        path: Source,
        *,
        exposure: float | None = None,
        tone: Tone | None = None,
        white: float | None = None,
    ) -> None:
        """Writes the image, whole or not at all: ``.png`` or ``.jpg`` (sRGB), ``.exr``, ``.pfm``, ``.hdr`` or ``.tif``
        (linear radiance). PNG and EXR hold the metadata. Of these, ``.png``, ``.exr`` and ``.tif`` can hold ``alpha``.

        Of a PNG or JPEG, ``exposure`` is the brightness in stops, and ``tone`` the curve by which it shows bright light:
        ``"agx"`` and ``"aces"`` as film does, ``"reinhard"`` with its colours (``white`` is the least luminance that is
        white, 4 if not given), ``"clamp"`` not at all. If none is given it is ``"agx"``, and ``"clamp"`` for scenes of
        :func:`sppm.load_particles`, so that the background has the colour that was asked for.

        Raises FileError if the file cannot be written, and InputError for exposure or tone of linear radiance, and for
        alpha in a format that has none.
        """
        _sppm.write_image(os.fspath(path), *self._shown(exposure, tone, white))

    def _shown(self, exposure: float | None, tone: Tone | None, white: float | None) -> _Shown:
        """What the extension module needs to show the film."""
        # An exposure of 0 is none.
        stops = None if exposure is None else _exposure(exposure) or None
        usual = None if self._tone is None else _curve(self._tone, None)
        return (self.radiance, self.alpha), self._note, stops, _curve(tone, white), usual

    def save_radius(self, path: Source) -> None:
        """Writes the search radii as an image, in the formats of :meth:`save`; in PNG, the largest is white.

        Raises FileError if it cannot be written, and InputError if there are no radii.
        """
        self._save_plane(path, self.radius, "radius")

    def save_count(self, path: Source) -> None:
        """Writes the photon counts as an image; see :meth:`save_radius`."""
        self._save_plane(path, self.count, "count")

    def _save_plane(self, path: Source, values: Floats | None, name: str) -> None:
        if values is None:
            raise InputError(f"the film has no {name}; films of photon mapping have one, those of files have none")
        _sppm.write_plane(os.fspath(path), values, name, self._note)

    def to_png(self, *, exposure: float = 0.0, tone: Tone | None = None, white: float | None = None) -> bytes:
        """The bytes of a PNG file. The arguments are those of :meth:`save`."""
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "film.png")
            self.save(path, exposure=exposure, tone=tone, white=white)
            try:
                return path.read_bytes()
            except OSError as error:
                raise FileError(f"{path} cannot be read: {error.strerror}") from None

    def to_srgb(
        self, *, exposure: float = 0.0, tone: Tone | None = None, white: float | None = None
    ) -> npt.NDArray[np.uint8]:
        """The picture that a screen shows, as PNG files hold it: shape (height, width, 3), 8 bits of sRGB. With ``alpha`` the
        shape is (height, width, 4), and colours are straight, not premultiplied.

        The arguments are those of :meth:`save`.
        """
        return _sppm.codes(*self._shown(exposure, tone, white))

    def _repr_png_(self) -> bytes:
        """The picture that a notebook shows."""
        return self.to_png()

    def __array__(self, dtype: npt.DTypeLike | None = None, copy: bool | None = None) -> npt.NDArray[Any]:
        """The array ``radiance``, for NumPy. Raises ValueError for another type without a copy."""
        if copy:
            return np.array(self.radiance, dtype=dtype)
        if copy is False and dtype is not None and np.dtype(dtype) != self.radiance.dtype:
            raise ValueError(f"radiance is {self.radiance.dtype}; as {np.dtype(dtype)} it must be copied")
        return np.asarray(self.radiance, dtype=dtype)

    def __eq__(self, other: object) -> bool:
        """Whether every bit of image, alpha, radii and counts is the same."""
        if not isinstance(other, Film):
            return NotImplemented
        pairs = ((getattr(self, name), getattr(other, name)) for name in ("radiance", "alpha", "radius", "count"))
        return all(_same(a, b) for a, b in pairs)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        """Size and iterations."""
        after = f" after {self.iterations} iterations" if self.iterations else ""
        return f"<sppm.Film: {self.width} x {self.height} pixels{after}>"

    def __copy__(self) -> Film:
        """The film itself, as it does not change."""
        return self

    def __deepcopy__(self, memo: dict[int, Any]) -> Film:
        """The film itself, as it does not change."""
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        """For ``pickle``."""
        return _restored, (self.radiance, (self.alpha, self.radius, self.count), self._note, self._tone)


def _restored(
    radiance: Floats, planes: tuple[Floats | None, ...], note: str | None, tone: Tone | None
) -> Film:
    """The film that was pickled."""
    alpha, radius, count = (None if plane is None else _arrays.frozen(plane) for plane in planes)
    return new_film(_arrays.frozen(radiance), alpha, radius, count, note, tone)


new_film = Film._of  # pyright: ignore[reportPrivateUsage]
"""The film of arrays that the extension module gives."""


def _owned(converted: Floats, given: object) -> Floats:
    """A read-only array that nobody else can change."""
    array = converted.copy() if np.may_share_memory(converted, np.asarray(given)) else converted
    array.flags.writeable = False
    return array


def info(path: Source) -> dict[str, Any]:
    """What made an image, ``.png`` or ``.exr``, or what a checkpoint holds: ``kind`` (``"image"`` or ``"checkpoint"``),
    version, scene and its digest, settings, iterations done, photons, method, engine.

    It is what ``sppm info --json`` prints. Raises FileError if the file cannot be read, or does not say what made it.
    """
    return json.loads(_sppm.info(os.fspath(path)))


def _curve(tone: object, white: float | None) -> tuple[str, float] | None:
    """The tone curve, if one is given."""
    if not (tone is None or isinstance(tone, str)):
        raise TypeError(f"tone must be a name, not {type(tone).__name__}")
    if white is not None and tone != "reinhard":
        raise InputError('white: only the curve reinhard has a white; ask for it by tone="reinhard"')
    if tone is None:
        return None
    return tone, 4.0 if white is None else positive(white, "white", InputError)


def _exposure(exposure: float) -> float:
    stops = single(exposure, "exposure")
    if not -100.0 <= stops <= 100.0:
        raise InputError(f"exposure is {stops}; it must be from -100 to 100 stops")
    return stops


def _same(a: Floats | None, b: Floats | None) -> bool:
    if a is None or b is None:
        return a is b
    return a.shape == b.shape and bool(np.array_equal(a.view(np.uint32), b.view(np.uint32)))
