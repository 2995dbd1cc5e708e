"""How similar two images are."""

from __future__ import annotations

import json
import os
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import numpy.typing as npt

from . import _arrays, _sppm
from ._errors import InputError
from ._film import Film, new_film

ImageLike: TypeAlias = Film | npt.ArrayLike | str | os.PathLike[str]
"""A film, an array of shape (height, width, 3), or the path of an image."""


@dataclass(frozen=True)
class Channels:
    """A figure for each channel, and for all together."""

    red: float
    """The first channel."""
    green: float
    """The second channel."""
    blue: float
    """The third channel."""
    all: float
    """All three channels."""


@dataclass(frozen=True)
class LargestDifference:
    """The largest difference of any channel of any pixel."""

    value: float
    """The absolute difference."""
    channel: str
    """``"red"``, ``"green"`` or ``"blue"``."""
    x: int
    """Column of the pixel, from the left, from 0."""
    y: int
    """Row of the pixel, from the top, from 0."""


@dataclass(frozen=True)
class Metrics:
    """The metrics of an image, judged against one that is right. Errors are of linear radiance unless told otherwise."""

    width: int
    """Pixels in a row."""
    height: int
    """Rows."""
    identical: bool
    """Whether every bit of every pixel is the same."""
    differing_pixels: int
    """The number of pixels that differ in any bit."""
    largest_difference: LargestDifference
    """The first of the largest differences."""
    mean_a: Channels
    """Mean of the image that is judged."""
    mean_b: Channels
    """Mean of the image that is right."""
    rmse: Channels
    """Root of the mean of the squared differences."""
    relative_mse: Channels
    """Mean of ``(a - b)**2 / (b**2 + 0.01)``."""
    block_relative_mse: Channels
    """The relative MSE of the means over blocks of 8x8 pixels; it shows noise that neighbours share."""
    psnr: float
    """Peak signal-to-noise ratio of the sRGB images, in dB; infinite if they are equal."""
    ssim: Channels
    """Mean index of structural similarity of the sRGB images; 1 if they are equal."""
    flip: float
    """Mean LDR-FLIP error of the sRGB images, from 0 (alike) to 1."""
    hdr_flip: float | None
    """Mean HDR-FLIP error of the radiance; ``None`` unless it is asked for, and if the right image is black."""


def compare(a: ImageLike, b: ImageLike, *, hdr_flip: bool = True) -> Metrics:
    """Judges image ``a`` against ``b``, the image that is right. ``hdr_flip=False`` leaves out what takes longest. Of films
    with alpha, ``radiance`` is compared, as it is over black.

    Raises InputError if the images differ in size or have pixels that are not finite, FileError if a file cannot be
    read, and TypeError for anything but images.
    """
    values: dict[str, Any] = json.loads(_sppm.compare(_picture(a, "a"), _picture(b, "b"), bool(hdr_flip)))
    channels = ("mean_a", "mean_b", "rmse", "relative_mse", "block_relative_mse", "ssim")
    values.update({name: Channels(**values[name]) for name in channels})
    values["largest_difference"] = LargestDifference(**values["largest_difference"])
    # JSON has no infinity.
    values["psnr"] = float("inf") if values["psnr"] is None else values["psnr"]
    return Metrics(**values)


def difference_image(a: ImageLike, b: ImageLike) -> tuple[Film, float]:
    """Where two images differ: a picture in false colours, from black (equal) to pale yellow, and the difference that
    its brightest colour stands for.

    Raises what :func:`compare` raises.
    """
    radiance, scale = _sppm.difference_image(_picture(a, "a"), _picture(b, "b"))
    return new_film(radiance), scale


def _picture(image: ImageLike, name: str) -> npt.NDArray[np.float32]:
    if isinstance(image, Film):
        return image.radiance
    if isinstance(image, (str, os.PathLike)):
        return Film.load(image).radiance
    return _arrays.picture(image, name, InputError)
