"""Films are saved, loaded and shown."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import sppm


def test_every_format_is_written_and_read(cornell, tmp_path: Path) -> None:
    film = sppm.render(cornell)
    for extension in ("exr", "pfm", "tif"):
        film.save(tmp_path / f"a.{extension}")
        assert np.array_equal(sppm.Film.load(tmp_path / f"a.{extension}").radiance, film.radiance)
    for extension in ("png", "jpg", "hdr"):
        film.save(tmp_path / f"a.{extension}", tone=None if extension == "hdr" else "clamp")
        read = sppm.Film.load(str(tmp_path / f"a.{extension}"))
        # The lamps are brighter than white.
        assert np.abs(np.clip(read.radiance, 0, 1) - np.clip(film.radiance, 0, 1)).mean() < 0.05


def test_a_layer_is_read_by_its_name(cornell, tmp_path: Path) -> None:
    film = sppm.render(cornell)
    film.save_radius(tmp_path / "radius.exr")
    read = sppm.Film.load(tmp_path / "radius.exr", layer="radius")
    assert film.radius is not None and np.array_equal(read.radiance[..., 0], film.radius)
    with pytest.raises(sppm.FileError, match=r"radius\.exr: has no layer `count`"):
        sppm.Film.load(tmp_path / "radius.exr", layer="count")


def test_metadata_are_kept(cornell, tmp_path: Path) -> None:
    film = sppm.render(cornell, seed=11)
    assert film.metadata["settings"]["seed"] == 11 and film.metadata["photons"] == 8000
    assert film.iterations == 2 and film.scene == cornell
    for extension in ("png", "exr"):
        film.save(tmp_path / f"a.{extension}")
        read = sppm.Film.load(tmp_path / f"a.{extension}")
        shown = {"tone": "agx"} if extension == "png" else {}
        assert read.metadata == {**film.metadata, **shown} and read.scene == cornell
    film.save(tmp_path / "b.png", exposure=2, tone="reinhard", white=3)
    exposed = sppm.Film.load(tmp_path / "b.png")
    assert exposed.metadata == {**film.metadata, "exposure": 2.0, "tone": {"reinhard": {"white": 3.0}}}
    exposed.save(tmp_path / "b.exr")
    assert sppm.Film.load(tmp_path / "b.exr").metadata == film.metadata
    film.save(tmp_path / "c.pfm")
    unknown = sppm.Film.load(tmp_path / "c.pfm")
    assert unknown.metadata == {} and unknown.iterations == 0 and unknown.scene is None


def test_codes_are_those_of_the_file_dithered_by_the_seed(cornell, tmp_path: Path) -> None:
    film = sppm.render(cornell, seed=5)
    film.save(tmp_path / "a.png", tone="agx")
    linear = sppm.Film.load(tmp_path / "a.png").radiance.astype(float)
    shown = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)
    assert np.array_equal(film.to_srgb(tone="agx"), np.round(255 * shown).astype(np.uint8))
    # A film that was not rendered has seed 0.
    assert not np.array_equal(sppm.Film(film.radiance).to_srgb(tone="agx"), film.to_srgb(tone="agx"))


def test_notebooks_show_a_picture(cornell, tmp_path: Path) -> None:
    film = sppm.render(cornell)
    film.save(tmp_path / "a.png")
    assert film._repr_png_() == film.to_png() == (tmp_path / "a.png").read_bytes()
    assert film.to_png(exposure=1) != film.to_png()
    shown = film.to_srgb()
    assert shown.shape == (30, 40, 3) and shown.dtype == np.uint8
    linear = np.float32([0, 0.0031308, 0.18, 0.5, 1, 9]).repeat(3).reshape(1, 6, 3)
    codes = sppm.Film(linear).to_srgb(tone="clamp")[0, :, 0]
    assert codes.tolist() == [0, 10, 118, 188, 255, 255]
    assert sppm.Film(linear).to_srgb(exposure=-1, tone="clamp")[0, 4, 0] == 188
    pictures = {film.to_png(tone=tone) for tone in ("clamp", "reinhard", "aces", "agx")}
    assert len(pictures) == 4 and film.to_png(tone="agx") == film.to_png()
    assert film.to_png(tone="reinhard", white=4) == film.to_png(tone="reinhard") != film.to_png(tone="reinhard", white=9)


def test_films_of_your_own(tmp_path: Path) -> None:
    ours = np.random.default_rng(0).random((5, 7, 3))
    film = sppm.Film(ours)
    assert (film.width, film.height) == (7, 5) and film.radius is None and "7 x 5" in repr(film)
    assert np.array_equal(film.radiance, ours.astype("f4"))
    film.save(tmp_path / "mine.exr")
    assert sppm.Film.load(tmp_path / "mine.exr") == film
    assert film == sppm.Film(ours) and film != sppm.Film(ours[::-1]) and film != 3
    assert sppm.Film([[[np.nan, 0.0, -0.0]]]) == sppm.Film([[[np.nan, 0.0, -0.0]]]) != sppm.Film([[[np.nan, 0.0, 0.0]]])
    with pytest.raises(ValueError, match="radiance is float32; as float64 it must be copied"):
        film.__array__(np.float64, copy=False)
    assert float(np.asarray(film, np.float64).sum()) == pytest.approx(ours.sum(), rel=1e-6)


VIEWS: dict[str, Any] = {
    "itself": lambda a: a,
    "mapped": lambda a: a.view(np.memmap),
    "a buffer": memoryview,
    "strided": lambda a: np.lib.stride_tricks.as_strided(a, a.shape, a.strides),
    "masked": np.ma.masked_array,
    "an interface": lambda a: SimpleNamespace(__array_interface__=a.__array_interface__, owner=a),
}


@pytest.mark.parametrize("view", VIEWS)
def test_a_film_of_your_own_stays_when_its_arrays_change(view: str) -> None:
    """However their memory is given."""
    arrays = [np.zeros(shape, np.float32) for shape in ((4, 5, 3), (4, 5), (4, 5), (4, 5))]
    radiance, alpha, radius, count = map(VIEWS[view], arrays)
    film = sppm.Film(radiance, alpha=alpha, radius=radius, count=count)
    for array in arrays:
        array[:] = 1.0
    for kept in (film.radiance, film.alpha, film.radius, film.count):
        assert not kept.any() and not kept.flags.writeable


def test_where_images_differ(cornell) -> None:
    film = sppm.render(cornell)
    other = film.radiance.copy()
    other[3, 5] += 0.5
    picture, scale = sppm.difference_image(other, film)
    assert picture.radiance.shape == film.radiance.shape and scale > 0
    assert np.argwhere(picture.radiance.sum(2) == picture.radiance.sum(2).max()).tolist() == [[3, 5]]
    metrics = sppm.compare(other, film, hdr_flip=False)
    assert metrics.hdr_flip is None and metrics.differing_pixels == 1
    assert (metrics.largest_difference.x, metrics.largest_difference.y) == (5, 3)
