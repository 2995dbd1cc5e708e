"""Images with alpha in place of the background."""

from __future__ import annotations

import copy
import pickle
from pathlib import Path

import numpy as np
import pytest
from conftest import balls

import sppm

WATER = Path(__file__).parents[2] / "fixtures/particles/water.pdb"
ROUNDING = 1e-5
"""Of the sums of both renders, relative to the brightest pixels, which are about 1; see ``render/src/backdrop.rs``."""


@pytest.mark.parametrize("method", ["sppm", "path", "hybrid"])
@pytest.mark.parametrize("filter", ["box", "mitchell"])
def test_files_are_those_of_the_command(method, filter, tmp_path: Path, command) -> None:
    scene = balls(filter=filter)
    scene.save(tmp_path / "scene.toml")
    film = sppm.render(scene, method=method)
    for name, shown in [("a.exr", {}), ("a.tif", {}), ("a.png", {}), ("b.png", {"exposure": 1.5, "tone": "aces"})]:
        theirs = tmp_path / f"theirs-{name}"
        options = [f"--{key}={value}" for key, value in shown.items()]
        command("render", tmp_path / "scene.toml", "-o", theirs, f"--method={method}", "--quiet", *options)
        film.save(tmp_path / name, **shown)
        assert (tmp_path / name).read_bytes() == theirs.read_bytes(), name


def test_particles_are_those_of_the_command(tmp_path: Path, command) -> None:
    size = {"width": 40, "height": 30}
    scene = sppm.load_particles(WATER, background="transparent", **size)
    assert scene.transparent_background and scene.background != (0, 0, 0)
    # The command takes the same scene from its file, with the same metadata.
    scene.save(tmp_path / "scene.toml")
    options = ["--method=path", "-n3", "--quiet"]
    command("render", tmp_path / "scene.toml", "-o", tmp_path / "theirs.exr", *options)
    film = sppm.render(sppm.Scene.load(tmp_path / "scene.toml"), method="path", iterations=3)
    film.save(tmp_path / "ours.exr")
    assert (tmp_path / "ours.exr").read_bytes() == (tmp_path / "theirs.exr").read_bytes()
    assert sppm.render(scene, iterations=3) == film and film.alpha is not None
    # And from the file of particles.
    command("render", WATER, "--background=transparent", "--width=40", "--height=30", "-o", tmp_path / "w.exr", *options)
    assert sppm.compare(film, tmp_path / "w.exr").identical
    opaque = sppm.load_particles(WATER, **size)
    assert not opaque.transparent_background and sppm.render(opaque, iterations=1).alpha is None


def test_over_its_background_an_image_is_as_without_alpha() -> None:
    scene = balls()
    film = sppm.render(scene)
    assert film.alpha is not None and film.alpha.shape == (32, 48) and film.alpha.dtype == np.float32
    assert film.rgba.shape == (32, 48, 4) and film.rgba.dtype == np.float32
    assert np.array_equal(film.rgba[..., :3], film.radiance) and np.array_equal(film.rgba[..., 3], film.alpha)
    # Nothing in a corner, a matte ball, glass.
    assert not film.rgba[0, 0].any()
    assert film.alpha[16, 12] == 1 and film.radiance[16, 12].min() > 0.1 and film.alpha[16, 24] < 0.1
    scene.transparent_background = False
    whole = sppm.render(scene)
    assert whole.alpha is None and (whole.rgba[..., 3] == 1).all()
    over = film.radiance + np.float32(scene.background) * (1 - film.alpha[..., None])
    assert np.abs(over - whole.radiance).max() < ROUNDING
    assert np.array_equal(np.asarray(film), film.radiance)
    with pytest.raises(ValueError, match="read-only"):
        film.alpha[0, 0] = 1


def test_alpha_is_there_at_any_time(tmp_path: Path) -> None:
    scene = balls(iterations=4)
    whole = sppm.render(scene)
    with sppm.Render(scene, paused=True) as render:
        for iterations in (1, 2):
            assert render.iterate() == sppm.render(scene, iterations=iterations)
    with pytest.raises(sppm.Interrupted) as caught:
        sppm.render(scene, iterations=1 << 20, progress=interrupt)
    film = caught.value.film
    assert film is not None and film == sppm.render(scene, iterations=film.iterations) and film.alpha is not None
    sppm.render(scene, iterations=2, checkpoint=tmp_path / "a.sppm")
    assert sppm.Render.resume(tmp_path / "a.sppm", iterations=4).result() == whole
    whole.save(tmp_path / "a.exr")
    assert sppm.Render.like(tmp_path / "a.exr").result() == whole
    assert sppm.render(scene, engine="reference", threads=1) == whole and sppm.verify(scene, iterations=2)


def interrupt(progress: sppm.Progress) -> None:
    """Ctrl-C after the second iteration."""
    if progress.iteration >= 2:
        raise KeyboardInterrupt


def test_parts_have_alpha_together(tmp_path: Path) -> None:
    scene = balls(radius_schedule="global", iterations=5)
    whole = sppm.render(scene)
    parts = [tmp_path / "a.sppm", tmp_path / "b.sppm"]
    sppm.render_part(scene, 0, 2, parts[0])
    sppm.render_part(scene, 2, 5, parts[1])
    sppm.merge(parts, tmp_path / "all.sppm")
    with sppm.Render.resume(tmp_path / "all.sppm") as render:
        assert render.result() == whole
    sppm.merge(parts, tmp_path / "all.exr")
    assert sppm.compare(whole, tmp_path / "all.exr").identical
    with pytest.raises(sppm.InputError, match=r"all\.jpg: JPEG files have no alpha"):
        sppm.merge(parts, tmp_path / "all.jpg")


def test_copies_keep_alpha() -> None:
    scene = balls()
    for copied in (scene.copy(), copy.deepcopy(scene), pickle.loads(pickle.dumps(scene)), sppm.Scene.parse(scene.to_toml())):
        assert copied.transparent_background and copied == scene
    film = sppm.render(scene, iterations=1)
    restored = pickle.loads(pickle.dumps(film))
    assert restored == film and restored != sppm.Film(film.radiance, radius=film.radius, count=film.count)
    assert film.scene is not None and film.scene.transparent_background
    other = balls()
    other.transparent_background = False
    assert other != scene


def test_films_of_your_own(tmp_path: Path) -> None:
    colors = np.float32([[[0.25, 0.25, 0.25], [1, 0, 0], [0, 0, 0]]])
    film = sppm.Film(colors, alpha=[[0.5, 1, 0]])
    # PNG files hold what covers the pixel: 0.25 of half a pixel is a grey of 0.5, which is the code 188.
    assert film.to_srgb(tone="clamp").tolist() == [[[188, 188, 188, 128], [255, 0, 0, 255], [0, 0, 0, 0]]]
    assert film.to_png(tone="clamp")[25] == 6, "the colour type is RGB with alpha"
    assert sppm.Film(colors).to_srgb().shape == (1, 3, 3) and film != sppm.Film(colors)
    for name in ("a.jpg", "a.pfm", "a.hdr"):
        with pytest.raises(sppm.InputError, match=f"{name}: [A-Z]+ files have no alpha, and the film has; name a .png"):
            film.save(tmp_path / name)
        sppm.Film(film.radiance).save(tmp_path / name)
    film.save(tmp_path / "a.exr")
    assert np.array_equal(sppm.Film.load(tmp_path / "a.exr").radiance, colors)
    assert sppm.compare(film, sppm.Film(colors)).identical
    with pytest.raises(sppm.InputError, match=r"alpha has shape \(2,\); it must be that of the image, \(1, 3\)"):
        sppm.Film(colors, alpha=[1, 2])
    with pytest.raises(TypeError, match="transparent_background must be True or False, not str"):
        sppm.Scene(transparent_background="yes")  # type: ignore[arg-type]
