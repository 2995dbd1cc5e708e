"""The ground truth of a scene: renders by Mitsuba 3, stored as a mean image and its standard error."""

from __future__ import annotations

import glob
import io
import json
import os
import tempfile
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from oracle import sppm, ztest

FOLDER = sppm.ROOT / "fixtures" / "truth"
WIDTH, HEIGHT = 128, 96
# Number of instants for a scene in motion. Each batch renders all of them, shifted by its own random offset.
INSTANTS = 32


@dataclass(frozen=True)
class Truth:
    """An image with its uncertainty: `mean` and `stderr` (height, width, 3), from `batches` independent renders."""

    mean: np.ndarray
    stderr: np.ndarray
    batches: int


@dataclass(frozen=True)
class Plan:
    """How much to render."""

    batches: int
    samples_per_batch: int
    seed: int = 1


def reduced(truth: Truth, factor: int) -> Truth:
    """The same truth at a lower resolution: each pixel is the mean of factor x factor pixels."""
    count = factor * factor
    mean = ztest.block_sums(truth.mean, factor) / count
    stderr = np.sqrt(ztest.block_sums(truth.stderr**2, factor)) / count
    return Truth(mean, stderr, truth.batches)


def path(scene: str) -> Path:
    """The file of a scene's truth; its provenance is in the .json file next to it."""
    return FOLDER / f"{scene}.npz"


def load(scene: str) -> Truth:
    """The truth of a built-in scene."""
    if not path(scene).exists():
        raise sppm.OracleError(f"there is no truth of {scene}; scripts/truth {scene} makes it")
    with np.load(path(scene)) as arrays:
        return Truth(arrays["mean"].astype(np.float64), arrays["stderr"].astype(np.float64), int(arrays["batches"]))


def save(scene: str, truth: Truth, provenance: dict[str, Any]) -> None:
    """Writes a truth and its provenance, each atomically."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    # Rounding the mean to float32 is negligible against its standard error, for which three digits are enough.
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        mean=truth.mean.astype(np.float32),
        stderr=truth.stderr.astype(np.float16),
        batches=truth.batches,
    )
    _replace(path(scene), buffer.getvalue())
    _replace(path(scene).with_suffix(".json"), (json.dumps(provenance, indent=2) + "\n").encode())


def _replace(target: Path, content: bytes) -> None:
    beside = target.with_name(f".{target.name}.part")
    beside.write_bytes(content)
    beside.replace(target)


def from_batches(batches: np.ndarray) -> Truth:
    """Mean and standard error of independent images, along the first axis."""
    count = len(batches)
    return Truth(batches.mean(axis=0), batches.std(axis=0, ddof=1) / np.sqrt(count), count)


def mitsuba() -> Any:
    """Mitsuba with the fastest variant available: llvm_ad_rgb if there is libLLVM 19, else scalar_rgb.

    Other versions of libLLVM have been seen to abort the process, so they are not tried.
    """
    found = sorted(glob.glob("/usr/lib/*/libLLVM.so.19*") + glob.glob("/usr/lib/llvm-19/lib/libLLVM*.so*"))
    if found:
        os.environ.setdefault("DRJIT_LIBLLVM_PATH", found[0])
    import mitsuba as mi

    mi.set_variant("llvm_ad_rgb" if "DRJIT_LIBLLVM_PATH" in os.environ else "scalar_rgb")
    return mi


def shutter(scene: str) -> tuple[float, float] | None:
    """When the shutter opens and closes, if anything moves in between; else None."""
    document = sppm.scene(scene)
    if not any("velocity" in sphere for sphere in document["sphere"]):
        return None
    opens, closes = document["camera"]["shutter"]
    return (opens, closes) if opens < closes else None


def make(scene: str, plan: Plan, width: int = WIDTH, height: int = HEIGHT) -> Truth:
    """Renders the truth of a scene."""
    return from_batches(batches(scene, plan, width, height))


def batches(scene: str, plan: Plan, width: int, height: int) -> np.ndarray:
    """Independent renders by Mitsuba, (batches, height, width, 3)."""
    mi = mitsuba()
    if (interval := shutter(scene)) is None:
        loaded = _load(mi, sppm.export(scene, width, height))
        batch = lambda seed: _render(mi, loaded, seed, plan.samples_per_batch)  # noqa: E731
    else:
        batch = lambda seed: _moving_batch(mi, scene, interval, seed, plan, (width, height))  # noqa: E731
    return np.stack([batch(plan.seed * 100_003 + k) for k in range(plan.batches)])


def _load(mi: Any, xml: str) -> Any:
    # load_string of Mitsuba 3.9 rejects comments before the root element; load_file accepts them.
    with tempfile.NamedTemporaryFile("w", suffix=".xml") as file:
        file.write(xml)
        file.flush()
        return mi.load_file(file.name)


def _render(mi: Any, scene: Any, seed: int, samples: int) -> np.ndarray:
    image = np.array(mi.render(scene, spp=samples, seed=seed), dtype=np.float64)
    if not np.isfinite(image).all():
        raise sppm.OracleError("Mitsuba rendered a pixel that is not finite")
    return image


def _moving_batch(
    mi: Any,
    scene: str,
    interval: tuple[float, float],
    seed: int,
    plan: Plan,
    size: tuple[int, int],
) -> np.ndarray:
    """One batch of a scene in motion: static renders at evenly spaced times, shifted by a random offset."""
    shift = np.random.default_rng(seed).random()
    samples = max(1, plan.samples_per_batch // INSTANTS)
    total = np.zeros((size[1], size[0], 3))
    for k in range(INSTANTS):
        time = interval[0] + (interval[1] - interval[0]) * (k + shift) / INSTANTS
        loaded = _load(mi, sppm.export(scene, *size, time=float(np.float32(time))))
        total += _render(mi, loaded, seed * INSTANTS + k, samples)
    return total / INSTANTS


def provenance(scene: str, plan: Plan, truth: Truth) -> dict[str, Any]:
    """How a truth was made."""
    import mitsuba as mi

    moving = shutter(scene) is not None
    samples = plan.samples_per_batch // INSTANTS * INSTANTS if moving else plan.samples_per_batch
    return {
        "scene": scene,
        "renderer": f"Mitsuba {mi.__version__}, {mi.variant()}, integrator path of unlimited depth",
        "width": truth.mean.shape[1],
        "height": truth.mean.shape[0],
        "batches": plan.batches,
        "samples_per_pixel_and_batch": samples,
        "instants_per_batch": INSTANTS if moving else 1,
        "seeds": [plan.seed * 100_003, plan.seed * 100_003 + plan.batches - 1],
        "channel_means": truth.mean.mean(axis=(0, 1)).tolist(),
        "date": datetime.now(UTC).date().isoformat(),
        "made_by": "scripts/truth",
    }
