"""The module gives the same bits as the command: files are equal byte by byte, metadata included."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

import sppm
from sppm._verify import _differences

BASE = {"width": 40, "height": 30, "iterations": 2, "photons_per_iteration": 4000}
OPTIONS = {"photons_per_iteration": "photons", "max_depth": "depth", "initial_radius": "radius"}

CASES: list[tuple[str, dict[str, object]]] = [
    *((name, {}) for name in sppm.builtin_scenes()),
    ("cornell", {"seed": 2**64 - 1}),
    ("cornell", {"max_depth": 12, "initial_radius": 0.1}),
    ("cornell", {"filter": "gaussian"}),
    ("mirror", {"filter": "mitchell", "iterations": 5}),
    ("random", {"width": 33, "height": 17}),
    ("surgery", {"width": 1, "height": 1}),
    ("large", {"engine": "reference"}),
    ("cornell", {"method": "path", "iterations": 3}),
    ("motion", {"method": "path", "engine": "reference"}),
    ("terrace", {"method": "hybrid", "iterations": 3}),
    ("motion", {"method": "hybrid", "engine": "reference"}),
    ("focus", {"lanes": "emulated", "threads": 1}),
    ("mirror", {"lanes": "emulated", "threads": 3, "photons_per_iteration": 1}),
    ("surgery", {"memory_limit": 1 << 30, "seed": 7}),
]


@pytest.mark.parametrize(("name", "settings"), CASES, ids=str)
def test_files_are_equal(name, settings, tmp_path: Path, command) -> None:
    # All of them: the command chooses what a scene does not state, and the package only if it is asked for a quality.
    own = sppm.Scene.load(name).settings
    options = {"max_depth": own.max_depth, "initial_radius": own.initial_radius, **BASE, **settings}
    arguments = [f"--{OPTIONS.get(key, key).replace('_', '-')}={value}" for key, value in options.items()]
    planes = ["radius", "count"] if settings.get("method") != "path" else []
    written = [f"--{plane}-image={tmp_path / plane}.exr" for plane in planes]
    command("render", name, "-o", tmp_path / "image.exr", *written, *arguments, "--quiet")
    film = sppm.render(sppm.Scene.load(name), **options)
    film.save(tmp_path / "ours.exr")
    assert (tmp_path / "ours.exr").read_bytes() == (tmp_path / "image.exr").read_bytes()
    for plane in planes:
        getattr(film, f"save_{plane}")(tmp_path / "ours.exr")
        assert (tmp_path / "ours.exr").read_bytes() == (tmp_path / f"{plane}.exr").read_bytes(), plane
    assert (film.radius is None) == (not planes)


def test_a_scene_from_arrays_is_the_scene_that_it_saves(tmp_path: Path, command) -> None:
    random = np.random.default_rng(3)
    scene = sppm.Scene(
        sppm.Camera.look_at([0, 1, 9.1], [0.3, 0, 0], aperture_radius=0.1, shutter=[0, 1]),
        name='a "name"',
        background=[0.1, 0.2, 0.3],
        settings=sppm.Settings(**BASE, initial_radius=0.2),
    )
    scene.add_spheres(
        random.normal(size=(50, 3)),
        random.uniform(0.05, 0.2, 50),
        [sppm.Diffuse(random.random(3)) if i % 3 else sppm.Dielectric(ior=1.33) for i in range(50)],
        velocity=random.normal(size=(50, 3)) * 0.1,
    )
    scene.add_spheres([0, 3, 0], 0.5, sppm.Specular(0.5), emission=[9, 8, 7])
    scene.save(tmp_path / "scene.toml")
    assert sppm.Scene.load(tmp_path / "scene.toml") == scene
    for extension, shown in [
        ("exr", {}),
        ("pfm", {}),
        ("tif", {}),
        ("png", {}),
        ("png", {"exposure": 1.5, "tone": "aces"}),
        ("png", {"tone": "reinhard", "white": 2.5}),
        ("jpg", {"exposure": -1, "tone": "clamp"}),
    ]:
        image = tmp_path / f"image.{extension}"
        options = [f"--{name}={value}" for name, value in shown.items()]
        command("render", tmp_path / "scene.toml", "-o", image, *options, "--quiet")
        sppm.render(scene).save(tmp_path / f"ours.{extension}", **shown)
        assert (tmp_path / f"ours.{extension}").read_bytes() == image.read_bytes(), (extension, shown)


def test_the_method_is_chosen_alike(tmp_path: Path, command) -> None:
    """Under an open sky by paths, unless something else is said: a method, or what only photons have."""
    scene = sppm.Scene(sppm.Camera(eye=(0, 3, 9), direction=(0, -2, -9)), background=(0.5, 0.6, 0.8))
    scene.add_spheres([[0, -1e4, 0], [0, 1, 0]], [1e4, 1], sppm.Diffuse(0.7))
    scene.save(tmp_path / "scene.toml")
    command("render", tmp_path / "scene.toml", "--quality=draft", "--quiet", "-o", tmp_path / "image.exr")
    film = sppm.render(scene, quality="draft")
    assert film.metadata["method"] == "path"
    assert sppm.compare(film, tmp_path / "image.exr").identical
    few = {"quality": "draft", "width": 16, "height": 12, "iterations": 1}
    for given, method in [({"method": "sppm"}, "sppm"), ({"method": "hybrid"}, "hybrid"), ({"initial_radius": 0.1}, "sppm")]:
        assert sppm.render(scene, **few, **given).metadata["method"] == method, given
    assert sppm.render(scene, width=16, height=12, iterations=1, photons_per_iteration=10).metadata["method"] == "sppm"


@pytest.mark.parametrize("quality", ["paper", "draft", "good"])
def test_settings_are_chosen_alike(quality, tmp_path: Path, command) -> None:
    options = ["--width=40", "--height=30", "--quiet"]
    command("render", "cornell", f"--quality={quality}", "-o", tmp_path / "image.exr", *options)
    film = sppm.render(sppm.Scene.load("cornell"), quality=quality, width=40, height=30)
    assert sppm.compare(film, tmp_path / "image.exr").identical
    chosen = film.metadata["settings"]
    assert (chosen["iterations"] == 6) == (quality == "paper")
    given = sppm.render(sppm.Scene.load("cornell"), quality=quality, width=40, height=30, iterations=2, max_depth=3)
    settings = given.metadata["settings"]
    assert (settings["iterations"], settings["max_depth"]) == (2, 3)


@pytest.mark.parametrize(
    ("given", "option"),
    [
        ({"iterations": 3}, "-n3"),
        ({"photons_per_iteration": 5000}, "--photons=5000"),
        ({"max_depth": 4}, "--depth=4"),
        ({"initial_radius": 0.75}, "--radius=0.75"),
        ({"radius_pilots": 2}, "--radius-pilots=2"),
        ({"radius_clearance": 0.5}, "--radius-clearance=0.5"),
        ({"glint_samples": 3}, "--glint-samples=3"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_what_is_given_is_not_chosen(given, option: str, tmp_path: Path, command) -> None:
    """What follows from it neither: pilots make no radius where one is given."""
    options = ["--width=40", "--height=30", "--quality=good", "--quiet", "-o", tmp_path / "image.exr"]
    few = {} if "iterations" in given else {"iterations": 1}
    command("render", "cornell", *options, option, *(["-n1"] if few else []))
    film = sppm.render(sppm.Scene.load("cornell"), quality="good", width=40, height=30, **given, **few)
    settings = film.metadata["settings"]
    assert settings == json.loads(command("info", tmp_path / "image.exr", "--json"))["settings"]
    assert all(settings[name] == value for name, value in given.items())


def test_a_quality_has_a_name() -> None:
    scene = sppm.Scene.load("cornell")
    with pytest.raises(sppm.InputError, match="best"):
        sppm.render(scene, quality="best", width=8, height=6)
    with pytest.raises(TypeError, match="quality must be a name"):
        sppm.render(scene, quality=3, width=8, height=6)


def test_a_checkpoint_goes_both_ways(tmp_path: Path, command) -> None:
    whole = sppm.render(sppm.Scene.load("cornell"), **{**BASE, "iterations": 6})
    options = ["--width=40", "--height=30", "--quality=paper", "--photons=4000", "--quiet"]
    command("render", "cornell", "-n3", "-o", tmp_path / "a.png", "--checkpoint", tmp_path / "a.sppm", *options)
    with sppm.Render.resume(tmp_path / "a.sppm", iterations=6) as render:
        assert render.result() == whole
        assert render.report["resumed_after"] == 3
    sppm.render(sppm.Scene.load("cornell"), **{**BASE, "iterations": 4}, checkpoint=tmp_path / "b.sppm")
    command("resume", tmp_path / "b.sppm", "-n6", "-o", tmp_path / "b.exr", "--quiet")
    assert sppm.compare(whole, tmp_path / "b.exr").identical


def test_a_render_is_repeated_from_its_image(tmp_path: Path, cornell, command) -> None:
    film = sppm.render(cornell, seed=5, method="path")
    film.save(tmp_path / "a.exr")
    assert sppm.Render.like(tmp_path / "a.exr").result() == film
    command("render", "--like", tmp_path / "a.exr", "-o", tmp_path / "b.exr", "--quiet")
    assert (tmp_path / "a.exr").read_bytes() == (tmp_path / "b.exr").read_bytes()
    with pytest.raises(sppm.FileError, match="another than the one that made it"):
        sppm.Render.like(tmp_path / "a.exr", sppm.Scene.load("mirror"))


def test_what_made_a_file(tmp_path: Path, cornell, command) -> None:
    film = sppm.render(cornell, checkpoint=tmp_path / "a.sppm", method="path", until_error=1e9)
    film.save(tmp_path / "a.png", exposure=1)
    for name, kind in (("a.sppm", "checkpoint"), ("a.png", "image")):
        told = sppm.info(tmp_path / name)
        assert told == json.loads(command("info", tmp_path / name, "--json"))
        assert told["kind"] == kind and told["iterations"] == 2 and told["method"] == "path"
    # By a light transport that is not the one of this program.
    earlier = Path(__file__).parents[2] / "fixtures/checkpoints/version-1.sppm"
    told = sppm.info(earlier)
    assert told == json.loads(command("info", earlier, "--json")) and told["transport"] == 1


def test_rays_hit_what_the_command_says(tmp_path: Path, command) -> None:
    random = np.random.default_rng(1)
    rays = np.float32(np.c_[random.uniform(5, 80, (500, 3)), random.normal(size=(500, 3))])
    np.save(tmp_path / "rays.npy", rays)
    command("trace", "motion", "--rays", tmp_path / "rays.npy", "--hits", tmp_path / "hits.npy", "--time", "0.5")
    right = np.load(tmp_path / "hits.npy")
    for options in ({}, {"engine": "reference"}, {"lanes": "emulated", "threads": 1}):
        hits = sppm.trace(sppm.Scene.load("motion"), rays[:, :3], rays[:, 3:], time=0.5, **options)
        for name, array in hits._asdict().items():
            assert array.tobytes() == np.ascontiguousarray(right[name]).tobytes(), name
    assert (right["sphere"] >= 0).mean() > 0.5


def test_metrics_are_those_of_the_command(tmp_path: Path, cornell, command) -> None:
    films = [sppm.render(cornell, seed=seed) for seed in (1, 2)]
    for film, name in zip(films, "ab", strict=True):
        film.save(tmp_path / f"{name}.exr")
    right = json.loads(command("compare", tmp_path / "a.exr", tmp_path / "b.exr", "--json"))
    metrics = sppm.compare(*films)
    assert metrics.hdr_flip == right["hdr_flip"] and metrics.hdr_flip is not None
    assert metrics.rmse.all == right["rmse"]["all"] > 0
    assert metrics.ssim.green == right["ssim"]["green"]
    assert vars(metrics.largest_difference) == right["largest_difference"]
    assert sppm.compare(films[0], films[0]).psnr == float("inf")


def test_all_engines_agree(cornell) -> None:
    for method in ("sppm", "path"):
        verified = sppm.verify(cornell, method=method, threads=2)
        assert verified and verified.difference is None
        assert any("emulated lanes and 2 threads" in name for name in verified.variants)


def test_the_first_difference_is_told_with_its_place(cornell) -> None:
    film = sppm.render(cornell, iterations=1)
    arrays = {name: getattr(film, name).copy() for name in ("radiance", "radius", "count")}
    for name, array in arrays.items():
        changed = {**arrays, name: array.copy()}
        # Column 5 of row 3: that of a difference further down and to the left is not told.
        for place in ((3, 5), (4, 2)):
            changed[name][place] = 0.25
        other = sppm.Film(changed.pop("radiance"), **changed)
        (told,) = _differences(other, film)
        right = np.ravel(array[3, 5])[0]
        assert told == f"{name} of pixel (5, 3) is 0.25 instead of {right}"
    assert list(_differences(film, sppm.Film(film.radiance, radius=film.radius, count=film.count))) == []
