"""Reads image files as linear RGB, and converts to and from sRGB."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np


def read(path: str | Path) -> np.ndarray:
    """Linear RGB of a .pfm, .exr or .png file: (height, width, 3) of float32, rows from the top.

    A grey image becomes three equal channels.

    OpenCV reads PFM only with IMREAD_UNCHANGED, and as blue, green, red. Its wheel is built without OpenEXR, so Mitsuba
    reads .exr files. The pixels of .png files are decoded from sRGB.
    """
    path = Path(path)
    if not path.is_file():
        raise ValueError(f"{path} is no file")
    readers = {".pfm": _opencv, ".png": _png, ".exr": _exr}
    if path.suffix not in readers:
        raise ValueError(f"{path} is none of {', '.join(readers)}")
    image = readers[path.suffix](path)
    if image.ndim == 2:
        image = np.repeat(image[..., None], 3, axis=2)
    if image.ndim != 3 or image.shape[2] != 3:
        raise ValueError(f"{path} is not red, green and blue: it has the shape {image.shape}")
    return np.ascontiguousarray(image, dtype=np.float32)


def _opencv(path: Path) -> np.ndarray:
    image = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    if image is None:
        raise ValueError(f"{path} cannot be read as an image")
    return image[..., ::-1] if image.ndim == 3 else image


def _png(path: Path) -> np.ndarray:
    image = _opencv(path)
    return from_srgb(image / np.iinfo(image.dtype).max)


def _exr(path: Path) -> np.ndarray:
    import mitsuba as mi

    if mi.variant() is None:
        mi.set_variant("scalar_rgb")
    bitmap = mi.Bitmap(str(path))
    return np.array(bitmap.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, srgb_gamma=False))


def to_srgb(linear: np.ndarray) -> np.ndarray:
    """Encodes linear light as sRGB (IEC 61966-2-1), clipped to [0, 1]."""
    clipped = np.clip(np.asarray(linear, dtype=np.float64), 0.0, 1.0)
    return np.where(clipped <= 0.0031308, 12.92 * clipped, 1.055 * clipped ** (1 / 2.4) - 0.055)


def from_srgb(encoded: np.ndarray) -> np.ndarray:
    """The inverse of `to_srgb` on [0, 1]."""
    encoded = np.asarray(encoded, dtype=np.float64)
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def write_png(path: str | Path, linear: np.ndarray) -> None:
    """Writes an 8-bit sRGB image."""
    eight_bits = np.rint(to_srgb(linear) * 255).astype(np.uint8)
    if not cv2.imwrite(str(path), eight_bits[..., ::-1]):
        raise ValueError(f"{path} cannot be written")
