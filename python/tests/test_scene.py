"""Scenes are loaded, built, edited, saved and exported."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import sppm


def test_built_in_scenes_are_read_back() -> None:
    names = sppm.builtin_scenes()
    assert {"cornell", "mirror", "motion"} <= set(names) and all(names.values())
    for name in names:
        scene = sppm.Scene.load(name)
        scene.check()
        again = sppm.Scene.parse(scene.to_toml())
        assert again == scene and again.settings == scene.settings and again.camera == scene.camera
        assert again.materials == scene.materials and np.array_equal(again.centers, scene.centers)


def test_a_sky_is_no_sphere(tmp_path: Path) -> None:
    scene = sppm.Scene(sppm.Camera(), background=[0.5, 0.6, 0.7])
    assert len(scene) == 0 and scene.materials == ()
    scene.add_spheres([0, 0, -5], 1, sppm.Diffuse(0.8))
    scene.check()
    scene.save(tmp_path / "sky.toml")
    again = sppm.Scene.load(tmp_path / "sky.toml")
    assert len(again) == 1 and again == scene and again.background == (0.5, 0.6, 0.7)
    assert len(again.materials) == 1
    hits = sppm.trace(scene, [0, 0, 0], [[0, 0, -1], [0, 1, 0]])
    assert hits.sphere.tolist() == [0, 1]
    # It is around every camera that the scene is given.
    far = [0.0, 0.0, 1e6]
    scene.camera = sppm.Camera(far, [0, 0, -1])
    assert sppm.trace(scene, far, [[0, 1, 0], [0, 0, 1]]).sphere.tolist() == [1, 1]
    again.background = [0, 0, 0]
    with pytest.raises(sppm.SceneError, match="there is no light"):
        again.check()


def test_a_lamp_that_lights_nothing_is_told(tmp_path: Path) -> None:
    scene = sppm.Scene(sppm.Camera(), background=[0.5, 0.6, 0.7])
    scene.add_spheres([[0, 0, -5]], 1, sppm.Diffuse(0.8), emission=[1, 1, 1])
    scene.add_spheres([[0, 0, -5]], 2, sppm.Diffuse(0.8))
    scene.save(tmp_path / "sealed.toml")
    with pytest.warns(sppm.SceneWarning, match=r"sealed\.toml:\d+:\d+: sphere 1 lights nothing") as caught:
        sppm.Scene.load(tmp_path / "sealed.toml")
    assert caught[0].filename == __file__


def test_numbers_stay_as_they_are_written() -> None:
    camera = sppm.Camera([0.1, 0.2, 0.3], [0, 0, -0.7], vertical_fov_degrees=33.3)
    assert camera.eye == (0.1, 0.2, 0.3) and camera.vertical_fov_degrees == 33.3
    scene = sppm.Scene(camera)
    assert scene.camera == camera and repr(scene.camera) == repr(camera)
    kinds = [sppm.Diffuse([0.1, 0.2, 0.3]), sppm.Specular([0.4, 0.5, 0.6]), sppm.Dielectric([0.7, 0.8, 0.9], ior=1.33)]
    scene.add_spheres([[-2, 0, 0], [0, 0, 0], [2, 0, 0]], 0.9, kinds)
    assert scene.materials == tuple(kinds)
    assert sppm.Diffuse([0.8, 0.3, 0.2]).albedo == (0.8, 0.3, 0.2)
    assert sppm.Diffuse(np.float32([0.8, 0.3, 0.2])) == sppm.Diffuse([0.8, 0.3, 0.2])
    assert sppm.Diffuse(0.5) == sppm.Diffuse([0.5] * 3) and hash(sppm.Diffuse(0.5)) == hash(sppm.Diffuse([0.5] * 3))
    assert sppm.Diffuse(0.5) != sppm.Specular(0.5)
    assert sppm.Settings(initial_radius=0.1).initial_radius == 0.1


def test_a_camera_looks_where_a_scene_file_says() -> None:
    text = """
        [camera]
        eye = [1.1, 2.3, 9.7]
        target = [0.3, -0.1, 0.2]
        vertical_fov_degrees = 40
        aperture_radius = 0.1
        [[sphere]]
        center = [0, 0, 0]
        radius = 1
        material = { type = "diffuse", albedo = [0, 0, 0] }
        emission = [1, 1, 1]
    """
    camera = sppm.Camera.look_at([1.1, 2.3, 9.7], [0.3, -0.1, 0.2], aperture_radius=0.1)
    assert sppm.Scene.parse(text).camera == camera
    # And all that a camera has can be given here as well.
    given = dict(up=(0, 0, 1), vertical_fov_degrees=33, aperture_radius=0.25, focus_distance=7, shutter=(1, 2))
    assert sppm.Camera.look_at([1, 2, 3], [1, 5, 3], **given) == sppm.Camera([1, 2, 3], [0, 3, 0], **given)


def test_spheres_are_removed() -> None:
    def scene() -> sppm.Scene:
        made = sppm.Scene()
        made.add_spheres(np.arange(30).reshape(10, 3), np.arange(1, 11), sppm.Diffuse(0.5))
        return made

    for which, left in [
        ([0, 9, 0], [2, 3, 4, 5, 6, 7, 8, 9]),
        (np.arange(10) % 2 == 0, [2, 4, 6, 8, 10]),
        (slice(None, 8), [9, 10]),
        (slice(None), []),
        ([], list(range(1, 11))),
        (3, [1, 2, 3, 5, 6, 7, 8, 9, 10]),
    ]:
        changed = scene()
        changed.remove_spheres(which)
        assert changed.radii.tolist() == left


def test_parts_are_replaced(cornell) -> None:
    cornell.set_material(1, sppm.Dielectric())
    assert cornell.materials[1] == sppm.Dielectric() and len(cornell.materials) == 6
    cornell.emissions = cornell.emissions * 2
    cornell.settings = cornell.settings.replace(seed=9, width=None)
    assert cornell.settings.seed == 9 and cornell.settings.width == 40
    cornell.name = 'a "name" – é'
    assert sppm.Scene.parse(cornell.to_toml()).name == cornell.name
    assert "9 spheres" in repr(cornell)
    assert cornell != sppm.Scene.load("cornell") and cornell != 3


def test_scenes_are_exported(cornell) -> None:
    for format, begin in [("mitsuba", "<"), ("pbrt", "#")]:
        exported = cornell.export(format, samples=7)
        assert exported.text.lstrip().startswith(begin) and "7" in exported.text
        assert isinstance(exported.notes, tuple)
    motion = sppm.Scene.load("motion")
    # Comments tell the time too.
    early, late = ([line for line in motion.export("pbrt", time=time).text.splitlines() if line[:1] != "#"] for time in (0.25, 0.75))
    assert early != late
    # A shutter that opens for no time leaves one instant, which need not be told.
    motion.camera = motion.camera.replace(shutter=(0.25, 0.25))
    assert motion.export("pbrt").text == motion.export("pbrt", time=0.25).text
