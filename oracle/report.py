"""Writes the report: all evidence of sppm's correctness on one HTML page with embedded images."""

from __future__ import annotations

import base64
import io
import json
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import cv2
import jinja2
import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from oracle import contacts, embree, images, judge, metrics, series, sppm, truth, ztest
from oracle.judge import Effort
from oracle.metrics import Metrics
from oracle.sppm import Render
from oracle.ztest import Verdict

# The share of pixels whose difference is within the scale of a difference image. The others have its full colour.
COVERED = 98
# Line styles of the two engines in figure 8; the paper's stages are thin lines.
FIGURE_STYLES = {
    "reference": {"color": "black", "linewidth": 2.5},
    "fast": {"color": "white", "linewidth": 0, "marker": "o", "markersize": 4, "markeredgecolor": "black"},
}


@dataclass(frozen=True)
class Depth:
    """How much to measure for a report."""

    effort: Effort
    path: Effort
    rays: int
    most_iterations: int


FULL = Depth(Effort(), Effort(iterations=32), 1_000_000, 2048)
QUICK = Depth(Effort(seeds=8, iterations=16, photons=20_000), Effort(seeds=8, iterations=16), 20_000, 16)


@dataclass(frozen=True)
class Picture:
    """An image embedded in the page, as a data URL."""

    title: str
    data: str


@dataclass(frozen=True)
class SceneReport:
    """The results for a scene."""

    name: str
    pictures: list[Picture]
    metrics: Metrics
    fast: Verdict
    path: Verdict
    identical: bool


def write(output: Path, *, quick: bool, most: int | None = None) -> None:
    """Makes all measurements, with figure 8 up to `most` iterations, and writes the page."""
    depth = QUICK if quick else FULL
    depth = depth if most is None else replace(depth, most_iterations=most)
    scenes = [_scene(name, depth) for name in sppm.SCENES]
    outcomes = [embree.compare(name, depth.rays, kind) for name in sppm.SCENES for kind in embree.KINDS]
    text = _template().render(
        date=datetime.now(UTC).date().isoformat(),
        version=sppm.run("--version").split()[-1],
        quick=quick,
        significance=ztest.SIGNIFICANCE,
        scenes=scenes,
        intersections=outcomes,
        most=depth.most_iterations,
        figure=_figure(depth.most_iterations),
        suites=_suites(),
        mutants=_mutants(),
    )
    beside = output.with_name(f".{output.name}.part")
    beside.write_text(text)
    beside.replace(output)


def _template() -> jinja2.Template:
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(Path(__file__).parent),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
    )
    return environment.get_template("report.html")


def _scene(name: str, depth: Depth) -> SceneReport:
    expected = truth.load(name)
    height, width = expected.mean.shape[:2]
    wanted = Render(name, width=width, height=height)
    fast = judge.renders(wanted, depth.effort)
    path, path_verdict = judge.scene(name, "path", depth.path)
    difference, scale = _difference(fast, expected)
    # The image that a user gets, without extrapolation. Few iterations, because the slow reference renders it too.
    one = Render(name, width=width, height=height, iterations=depth.effort.iterations, photons=depth.effort.photons)
    image, reference = one.image(), replace(one, engine="reference").image()
    pictures = [
        Picture("reference", _png(reference)),
        Picture("fast", _png(image)),
        Picture("truth (Mitsuba 3)", _png(expected.mean)),
        Picture(
            f"difference of green from truth: red brighter, blue darker, full colour at {scale:.2g} standard errors, "
            f"which {COVERED} % do not exceed",
            difference,
        ),
    ]
    verdict = judge.verdict(fast, expected, contacts.mask(name, width, height))
    identical = image.tobytes() == reference.tobytes()
    return SceneReport(name, pictures, metrics.compare(image, expected.mean), verdict, path_verdict, identical)


def _inline(png: bytes) -> str:
    return "data:image/png;base64," + base64.b64encode(png).decode()


def _png(linear: np.ndarray) -> str:
    eight_bits = np.rint(images.to_srgb(linear) * 255).astype(np.uint8)
    return _inline(cv2.imencode(".png", eight_bits[..., ::-1])[1].tobytes())


def _difference(ours: judge.Renders, expected: truth.Truth) -> tuple[str, float]:
    """The difference in the green channel, and its scale in standard errors.

    It also shows pixels whose own noise is not known well enough for a verdict: after few iterations that is all of them.
    """
    everything = np.ones_like(expected.mean)
    mine = ztest.of_renders(ours.images, 1, everything)
    theirs = ztest.of_pixels(expected.mean, expected.stderr, expected.batches - 1, 1, everything)
    t = ztest.welch(mine, theirs)[0][..., 1]
    colours, scale = two_colours(t)
    eight_bits = np.rint(colours * 255).astype(np.uint8)
    return _inline(cv2.imencode(".png", eight_bits[..., ::-1])[1].tobytes()), scale


def two_colours(values: np.ndarray) -> tuple[np.ndarray, float]:
    """RGB in [0, 1]: red where positive, blue where negative, black at 0; and the value with full colour.

    The scale follows the values, so that there is something to see whatever their size: it is what COVERED percent of
    those that are not 0 do not exceed.
    """
    sizes = np.abs(values[values != 0])
    scale = float(np.percentile(sizes, COVERED)) if sizes.size else 1.0
    red, blue = np.clip(values / scale, 0, 1), np.clip(-values / scale, 0, 1)
    return np.stack([red, np.zeros_like(values), blue], axis=-1), scale


def _figure(most: int) -> str:
    """Figure 8, one panel per scene: the reference as a line, the fast engine as dots, the paper's stages."""
    mpl.rcParams["svg.hashsalt"] = "sppm"
    figure = Figure(figsize=(11, 6), layout="constrained")
    panels = figure.subplots(2, 3, sharex=True, sharey=True).flat
    measured = series.measure_all(sppm.PAPER_SCENES, most)
    for scene, points, axes in zip(sppm.PAPER_SCENES, measured, panels, strict=False):
        for what in dict.fromkeys(point.what for point in points):
            some = [(point.iterations, point.ssim) for point in points if point.what == what]
            axes.plot(*zip(*some, strict=True), label=what, **FIGURE_STYLES.get(what, {"linewidth": 1}))
        axes.set_xscale("log", base=2)
        axes.set_title(scene, fontsize="medium")
        axes.grid(alpha=0.3)
    handles, labels = axes.get_legend_handles_labels()
    last = figure.axes[-1]
    last.set_axis_off()
    last.legend(handles, labels, loc="center")
    figure.supxlabel("iterations")
    figure.supylabel("SSIM")
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110)
    return _inline(buffer.getvalue())


def _suites() -> dict[str, Any] | None:
    path = sppm.ROOT / "target" / "suites.json"
    return json.loads(path.read_text()) if path.exists() else None


def _mutants() -> list[dict[str, Any]]:
    """The counts of cargo-mutants in target/mutants."""
    rows = []
    for folder in sorted((sppm.ROOT / "target" / "mutants").glob("*/mutants.out")):
        count = {kind: _lines(folder / f"{kind}.txt") for kind in ("caught", "missed", "timeout", "unviable")}
        viable = count["caught"] + count["missed"] + count["timeout"]
        if viable:
            score = 100 * (viable - count["missed"]) / viable
            rows.append({"crate": folder.parent.name, "score": score, **count})
    return rows


def _lines(path: Path) -> int:
    return len(path.read_text().splitlines()) if path.exists() else 0
