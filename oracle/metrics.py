"""Similarity of two images as displayed: SSIM and PSNR of their sRGB values, by OpenCV."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np

from oracle.images import to_srgb


@dataclass(frozen=True)
class Metrics:
    """SSIM (1 for equal images) and PSNR in dB (infinite for equal images) of 8-bit sRGB, and RMSE of radiance."""

    ssim: float
    psnr: float
    rmse: float

    def __str__(self) -> str:
        return f"SSIM {self.ssim:.6f}, PSNR {self.psnr:.2f} dB, RMSE of radiance {self.rmse:.4e}"


def compare(image: np.ndarray, reference: np.ndarray) -> Metrics:
    """Compares two images of linear radiance, (height, width, 3)."""
    if image.shape != reference.shape:
        raise ValueError(f"the images differ in shape: {image.shape} and {reference.shape}")
    if not (np.isfinite(image).all() and np.isfinite(reference).all()):
        raise ValueError("an image has values that are not finite")
    rmse = float(np.sqrt(np.mean((image.astype(np.float64) - reference) ** 2)))
    return Metrics(ssim(image, reference), psnr(image, reference), rmse)


def ssim(image: np.ndarray, reference: np.ndarray) -> float:
    """Mean SSIM index (Wang et al. 2004) over the three channels.

    OpenCV's constants assume values of 0..255; for images in [0, 1] it silently returns values near 1.
    """
    per_channel, _ = cv2.quality.QualitySSIM_compute(_shown(reference), _shown(image))
    # OpenCV returns four values; the fourth belongs to no channel.
    return float(np.mean(per_channel[:3]))


def psnr(image: np.ndarray, reference: np.ndarray) -> float:
    """Peak signal-to-noise ratio in dB."""
    a, b = _shown(reference), _shown(image)
    if np.array_equal(a, b):
        return float("inf")
    per_channel, _ = cv2.quality.QualityPSNR_compute(a, b, maxPixelValue=255.0)
    return float(np.mean(per_channel[:3]))


def _shown(image: np.ndarray) -> np.ndarray:
    return (to_srgb(image) * 255).astype(np.float32)
