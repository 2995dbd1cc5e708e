"""Exports as Mitsuba's own parser reads them: where its rays start and go, and what they meet."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from oracle import sppm, truth

EYE, DIRECTION, UP = (1.0, 2.5, 3.0), (0.6, -0.4, -4.0), (0.2, 1.0, 0.3)
FOV, APERTURE, FOCUS = 35.0, 0.25, 4.5
TINT, INDEX = (0.9, 0.8, 0.7), 1.7
ROOM, LAMP = (0.125, 0.25, 0.5), (30.0, 20.0, 10.0)

SCENE = f"""
[camera]
eye = {list(EYE)}
direction = {list(DIRECTION)}
up = {list(UP)}
vertical_fov_degrees = {FOV}
aperture_radius = {APERTURE}
focus_distance = {FOCUS}
[materials.room]
type = "diffuse"
albedo = [0.7, 0.6, 0.5]
[materials.glass]
type = "dielectric"
albedo = {list(TINT)}
ior = {INDEX}
[[sphere]]
center = [0.5, 0.25, -1.0]
radius = 5000.0
material = "room"
emission = {list(ROOM)}
[[sphere]]
center = [1.0, 2.0, -3.0]
radius = 1.25
material = "glass"
[[sphere]]
center = [0.0, 6.0, -2.0]
radius = 0.5
material = "room"
emission = {list(LAMP)}
"""

# Coordinates are written as float32, and Mitsuba computes in float32.
PRECISION = 2e-5


@pytest.fixture(scope="module")
def exported(tmp_path_factory: pytest.TempPathFactory) -> tuple:
    """Mitsuba, and per size of the image the scene as it has read it and how far that was moved along z."""
    mi = truth.mitsuba()
    path = tmp_path_factory.mktemp("exports") / "scene.toml"
    Path(path).write_text(SCENE)
    loaded = {}
    for size in ((60, 30), (30, 60)):
        xml = sppm.export(str(path), *size)
        shift = float(xml.split("moved by ")[1].split()[0]) if "moved by " in xml else 0.0
        loaded[size] = truth._load(mi, xml), np.array([0.0, 0.0, shift])
    return mi, loaded


def frame() -> np.ndarray:
    """To the right of the image, to its top, and ahead."""
    ahead = np.array(DIRECTION) / np.linalg.norm(DIRECTION)
    right = np.cross(ahead, UP)
    right /= np.linalg.norm(right)
    return np.stack([right, np.cross(right, ahead), ahead])


@pytest.mark.parametrize("size", [(60, 30), (30, 60)])
@pytest.mark.parametrize("place", [(0.5, 0.5), (0.0, 0.5), (0.9, 0.1), (0.25, 1.0)])
def test_rays_leave_the_lens_where_ours_do(exported: tuple, size: tuple, place: tuple) -> None:
    """Rays of one place in the image, from the middle of the lens and from its rim, meet where that is in focus."""
    mi, loaded = exported
    scene, shift = loaded[size]
    half = np.tan(np.radians(FOV / 2))
    along = (2 * place[0] - 1) * half * size[0] / size[1], (1 - 2 * place[1]) * half, 1.0
    focus = np.array(EYE) + shift + FOCUS * np.array(along) @ frame()
    offsets = []
    for lens in ((0.5, 0.5), (0.99, 0.5), (0.5, 0.02), (0.2, 0.3)):
        ray, _ = scene.sensors()[0].sample_ray(0.0, 0.5, mi.Point2f(*place), mi.Point2f(*lens))
        origin, direction = (np.array(v, dtype=np.float64).reshape(3) for v in (ray.o, ray.d))
        # The near plane clips the first thousandth of the smallest sphere's radius.
        line = focus - origin
        miss = np.linalg.norm(np.cross(line, direction)) / np.linalg.norm(line)
        assert miss < PRECISION and line @ direction > 0
        offsets.append(np.linalg.norm((origin - np.array(EYE) - shift) @ frame()[:2].T))
    assert offsets[0] < 0.01 and APERTURE * 0.9 < max(offsets) < APERTURE * 1.001


def test_rays_meet_the_lamps_and_the_glass(exported: tuple) -> None:
    mi, loaded = exported
    scene, shift = loaded[(60, 30)]
    eye = np.array(EYE) + shift

    def met(target: tuple) -> tuple:
        direction = np.array(target) + shift - eye
        # Plain floats: the variants for arrays take no numbers of NumPy.
        unit = direction / np.linalg.norm(direction)
        ray = mi.Ray3f(mi.Point3f(*eye.tolist()), mi.Vector3f(*unit.tolist()))
        found = scene.ray_intersect(ray)
        return found, ray

    def emitted(found: object) -> np.ndarray:
        return np.array(found.emitter(scene).eval(found), dtype=np.float64).reshape(3)

    lamp, _ = met((0.0, 6.0, -2.0))
    np.testing.assert_allclose(emitted(lamp), LAMP, rtol=PRECISION)
    # The room is lit, and seen, from inside.
    room, _ = met((0.0, 40.0, 90.0))
    np.testing.assert_allclose(emitted(room), ROOM, rtol=PRECISION)
    glass, _ = met((1.0, 2.0, -3.0))
    context, found = mi.BSDFContext(), glass
    index = INDEX
    r = ((index - 1) / (index + 1)) ** 2
    bsdf = found.bsdf()
    for number, share, direction in ((0.0, r, 1), (0.999, 1 - r, -1)):
        sample, weight = bsdf.sample(context, found, number, mi.Point2f(0.5, 0.5))
        # Reflected back, or straight on; radiance that enters glass is scaled by the squared index.
        cosine = float(np.array(sample.wo, dtype=np.float64).reshape(3)[2])
        assert np.sign(cosine) == direction * np.sign(float(np.array(found.wi).reshape(3)[2]))
        np.testing.assert_allclose(float(np.array(sample.pdf).reshape(-1)[0]), share, rtol=1e-2)
        scale = 1.0 if direction == 1 else 1 / index**2
        np.testing.assert_allclose(np.array(weight, dtype=np.float64).reshape(3), np.array(TINT) * scale, rtol=1e-2)
