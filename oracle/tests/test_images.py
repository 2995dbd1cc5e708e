"""Tests of reading and writing images, and of the metrics."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oracle import images, metrics, series, sppm

TINY = ["--width=24", "--height=16", "--iterations=2", "--photons=2000", "--quiet"]


@pytest.fixture(scope="module")
def rendered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("rendered")
    # The clamped curve is the one that measures.
    for extension, curve in (("pfm", ()), ("exr", ()), ("png", ("--tone", "clamp"))):
        sppm.run("render", "cornell", "-o", folder / f"image.{extension}", *curve, *TINY)
    return folder


def test_exr_and_pfm_hold_the_same_floats(rendered: Path) -> None:
    pfm, exr = images.read(rendered / "image.pfm"), images.read(rendered / "image.exr")
    assert pfm.shape == (16, 24, 3) and pfm.dtype == np.float32
    np.testing.assert_array_equal(pfm, exr)


def test_rows_and_channels_are_in_order(rendered: Path) -> None:
    image = images.read(rendered / "image.pfm")
    # The red wall is on the left, the blue one on the right, the ceiling with its lamps above.
    assert image[4:12, :3, 0].mean() > 1.5 * image[4:12, :3, 2].mean()
    assert image[4:12, -3:, 2].mean() > 1.5 * image[4:12, -3:, 0].mean()
    assert image[2:5].max() > image[-3:].max()


def test_png_is_what_a_screen_shows(rendered: Path) -> None:
    png, exact = images.read(rendered / "image.png"), images.read(rendered / "image.exr")
    # Half a step of 8 bits, plus rounding to float32.
    assert np.abs(images.to_srgb(png) - images.to_srgb(exact)).max() <= 0.5 / 255 + 1e-6


def test_a_written_image_is_read_back(tmp_path: Path) -> None:
    image = np.random.default_rng(1).random((5, 7, 3))
    images.write_png(tmp_path / "a.png", image)
    assert np.abs(images.to_srgb(images.read(tmp_path / "a.png")) - images.to_srgb(image)).max() <= 0.5 / 255 + 1e-6


def test_srgb_inverts() -> None:
    values = np.linspace(0, 1, 1001)
    np.testing.assert_allclose(images.from_srgb(images.to_srgb(values)), values, atol=1e-7)


def test_bad_files_are_refused(tmp_path: Path) -> None:
    (tmp_path / "note.png").write_text("no image")
    (tmp_path / "note.txt").write_text("no image")
    for name in ("note.png", "note.txt", "missing.exr"):
        with pytest.raises(ValueError, match=name):
            images.read(tmp_path / name)


def test_ssim_of_equals_is_one_and_falls_with_noise() -> None:
    random = np.random.default_rng(2)
    image = images.from_srgb(np.kron(random.random((8, 8, 3)), np.ones((8, 8, 1))))
    assert metrics.ssim(image, image) == pytest.approx(1.0, abs=1e-6)
    assert metrics.psnr(image, image) == np.inf
    found = [metrics.ssim(image + scale * random.normal(size=image.shape), image) for scale in (0.01, 0.05, 0.2)]
    assert 1 > found[0] > found[1] > found[2] > 0
    # On [0, 1] instead of 0..255 even the last would be above 0.99.
    assert found[2] < 0.8


def test_psnr_is_its_definition() -> None:
    image = images.from_srgb(np.full((16, 16, 3), 0.5))
    other = images.from_srgb(np.full((16, 16, 3), 0.6))
    assert metrics.psnr(other, image) == pytest.approx(20.0, abs=1e-3)


def test_ours_agrees_with_sppm_compare(rendered: Path) -> None:
    """Our PSNR is close to that of `sppm compare`."""
    import json

    a, b = rendered / "image.exr", rendered / "image.png"
    theirs = json.loads(sppm.run("compare", b, a, "--json"))
    assert metrics.compare(images.read(b), images.read(a)).psnr == pytest.approx(theirs["psnr"], abs=0.5)


def test_the_series_has_both_engines_alike_and_every_stage() -> None:
    points = list(series.measure("cornell", 4))
    of = {what: [p.ssim for p in points if p.what == what] for what in {p.what for p in points}}
    assert sorted(of) == ["fast", "reference", *(f"stage {k}" for k in range(7))]
    assert of["fast"] == of["reference"]
    # SSIM grows with the iterations. The stages have other random numbers, hence other values.
    assert all(0 < first < second < 1 for first, second in of.values())
    assert len({second for _, second in of.values()}) > 3
