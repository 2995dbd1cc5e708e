"""Misuse gets an exception that says what is wrong, in one line, and changes nothing."""

from __future__ import annotations

import re
from collections.abc import Callable
from datetime import timedelta
from pathlib import Path

import numpy as np
import pytest
from conftest import ENDLESS, SMALL

import sppm

Misuse = Callable[[sppm.Scene], object]
GREY = sppm.Diffuse(0.5)
NAN, INF = float("nan"), float("inf")
HEAP = Path(__file__).parents[2] / "fixtures/particles/heap.csv"


def add(centers=((1.0, 2.0, 3.0),), radii=1.0, material=GREY, **more) -> Misuse:
    return lambda scene: scene.add_spheres(centers, radii, material, **more)


def render(**settings) -> Misuse:
    return lambda scene: sppm.render(scene, **{**SMALL, **settings})


def assign(name: str, value: object) -> Misuse:
    return lambda scene: setattr(scene, name, value)


def show(**arguments) -> Misuse:
    return lambda scene: sppm.load_particles(HEAP, **arguments)


def particles(positions=((0, 0, 0), (1, 1, 1)), **columns) -> Misuse:
    return lambda scene: sppm.Particles(positions, **columns)


def closed(use: Callable[[sppm.Render], object]) -> Misuse:
    def misuse(scene: sppm.Scene) -> object:
        with sppm.Render(scene, paused=True) as render:
            render.iterate()
        return use(render)

    return misuse


def running(use: Callable[[sppm.Render], object]) -> Misuse:
    def misuse(scene: sppm.Scene) -> object:
        with sppm.Render(scene, **ENDLESS) as render:
            return use(render)

    return misuse


def paused(use: Callable[[sppm.Render], object]) -> Misuse:
    def misuse(scene: sppm.Scene) -> object:
        with sppm.Render(scene, paused=True) as render:
            return use(render)

    return misuse


FILM = sppm.Film(np.ones((4, 5, 3)))
S, I, T, F, R = sppm.SceneError, sppm.InputError, TypeError, sppm.FileError, sppm.RenderError

MISUSES: list[tuple[Misuse, type[Exception], str]] = [
    # Spheres: shapes.
    (add([[1, 2]]), S, "centers has shape (1, 2); it must be (n, 3), or (3,) for one"),
    (add(np.zeros((2, 3, 3))), S, "centers has shape (2, 3, 3)"),
    (add(5.0), S, "centers has shape ()"),
    (add([[1, 2, 3], [1, 2]]), S, "centers is a ragged sequence"),
    (add(np.zeros((4, 3)), [1, 2, 3]), S, "radii has shape (3,); it must be one number for all or (4,) for each"),
    (add(np.zeros((4, 3)), np.ones((4, 1))), S, "radii has shape (4, 1)"),
    (add(emission=np.ones((2, 3))), S, "emission has shape (2, 3); it must be (3,) for all or (1, 3) for each"),
    (add(velocity=[1, 2]), S, "velocity has shape (2,)"),
    (add(np.zeros((4, 3)), 1, [GREY, GREY]), S, "material has 2 materials for 4 spheres"),
    (add(np.zeros((4, 3)), 1, np.zeros(3, int)), S, "material has shape (3,)"),
    # Spheres: numbers.
    (add([[0, 0, 0], [0, NAN, 0]], 1), S, "center of sphere [1] must be finite numbers"),
    (add([[0, 0, 1e300]]), S, "center of sphere [0] must be finite numbers from -1e15 to 1e15"),
    (add(np.zeros((70000, 3)), np.r_[np.ones(69999), -1]), S, "radius of sphere [69999] must be above 0"),
    (add(radii=0), S, "radius of sphere [0] must be above 0"),
    (add(radii=NAN), S, "radius of sphere [0]"),
    (add(emission=-1), S, "emission of sphere [0] is outside [0, 1e15]"),
    (add(emission=[0, INF, 0]), S, "emission of sphere [0]"),
    (add(velocity=[NAN, 0, 0]), S, "velocity of sphere [0]"),
    (add(np.ma.masked_equal([[1.0, 2.0, 3.0]], 2.0)), S, "centers has masked elements"),
    (add(material=99), S, "there is no material [99]; the scene has 6"),
    (add(material=-1), S, "there is no material [-1]"),
    # Spheres: types.
    (add("here"), T, "centers is an array of <U4; give real numbers"),
    (add([[1, 2, 3j]]), T, "centers is an array of complex128"),
    (add([[1, None, 3]]), T, "centers is an array of object"),
    (add([[True, False, True]]), T, "centers is an array of bool"),
    (add(material="red"), T, "material must be a material, or indices"),
    (add(material=1.5), T, "material must be a material, or indices"),
    (add(material=None), T, "material must be a material"),
    # Materials and cameras.
    (lambda _: sppm.Diffuse(1.5), S, "albedo of Diffuse is outside [0, 1]"),
    (lambda _: sppm.Diffuse([0.1, 0.2]), S, "albedo of Diffuse must be 3 numbers; it has shape (2,)"),
    (lambda _: sppm.Specular([0, 0, NAN]), S, "albedo of Specular is outside [0, 1]"),
    (lambda _: sppm.Diffuse("red"), T, "albedo of Diffuse must be 3 numbers, not str"),
    (lambda _: sppm.Dielectric(ior=0.5), S, "ior of Dielectric must be a number from 1 to 100; glass has 1.5"),
    (lambda _: sppm.Dielectric(ior="1.5"), T, "ior of Dielectric must be a number, not str"),
    (lambda _: sppm.Camera(direction=[0, 0, 0]), S, "direction of the camera must be finite numbers, not all zero"),
    (lambda _: sppm.Camera(up=[0, 0, 2]), S, "up of the camera is parallel to the viewing direction"),
    (lambda _: sppm.Camera(vertical_fov_degrees=180), S, "vertical_fov_degrees of the camera is outside (0, 180)"),
    (lambda _: sppm.Camera(shutter=[1, 0]), S, "shutter of the camera"),
    (lambda _: sppm.Camera(eye=[0, 0]), S, "eye must be 3 numbers; it has shape (2,)"),
    (lambda _: sppm.Camera.look_at([1, 2, 3], [1, 2, 3]), S, "target of the camera is where eye is"),
    (lambda _: sppm.Camera().replace(eyes=[0, 0, 0]), T, "unexpected keyword argument 'eyes'"),
    # Scenes.
    (lambda _: sppm.Scene.load("cornel"), S, 'there is no scene "cornel" (did you mean cornell?)'),
    (lambda _: sppm.Scene.load("/nowhere/a.toml"), S, "/nowhere/a.toml: there is no such file"),
    (lambda _: sppm.Scene.load(3), T, "expected str, bytes or os.PathLike object, not int"),  # type: ignore[arg-type]
    (lambda _: sppm.Scene.parse("x = 1", "mine.toml"), S, "mine.toml:1:1: "),
    (lambda _: sppm.Scene.parse(3), T, "text must be a str, not int"),  # type: ignore[arg-type]
    (lambda _: sppm.Scene(name=3), T, "name must be a str, not int"),  # type: ignore[arg-type]
    (lambda _: sppm.render(sppm.Scene()), S, "there is no light"),
    (lambda _: sppm.Scene().check(), S, "there is no light"),
    (lambda scene: scene.save("/nowhere/a.toml"), F, "/nowhere/a.toml"),
    (lambda scene: scene.save("a.png"), I, "a scene file ends in .toml"),
    (assign("camera", "front"), T, "camera must be a sppm.Camera, not str"),
    (assign("settings", {"width": 3}), T, "settings must be sppm.Settings, not dict"),
    (assign("background", [0, -1, 0]), S, "background of the scene is outside [0, 1e15]"),
    (assign("centers", np.zeros((3, 3))), S, "centers has shape (3, 3); it must be (3,) for all or (9, 3) for each"),
    (assign("radii", -np.ones(9)), S, "radius of sphere [0] must be above 0"),
    (assign("radii", "big"), T, "radii is an array of <U3"),
    (assign("material_indices", [9] * 9), S, "there is no material [9]; the scene has 6"),
    (lambda scene: scene.centers.__setitem__(0, 0), ValueError, "assignment destination is read-only"),
    (lambda scene: scene.remove_spheres([9]), S, "there is no sphere [9]; the scene has 9"),
    (lambda scene: scene.remove_spheres(np.ones(3, bool)), S, "the mask has shape (3,); it must be (9,)"),
    (lambda scene: scene.remove_spheres([0.5]), T, "which is an array of float64; give whole numbers"),
    (lambda scene: scene.set_material(6, GREY), S, "there is no material [6]; the scene has 6"),
    (lambda scene: scene.set_material(0, "red"), T, "material must be a sppm.Diffuse, Specular or Dielectric"),
    (lambda scene: scene.export("povray"), I, 'format "povray": there is no such'),
    (lambda _: sppm.Scene.load("motion").export("pbrt"), I, "time: spheres move; choose an instant from 0.0 to 1.0"),
    (lambda _: sppm.Scene.load("motion").export("pbrt", time=2), I, "time: 2.0 is not while the shutter is open, 0.0 to 1.0"),
    (lambda scene: scene.export("pbrt", samples=0), I, "samples is 0; it must be at least 1"),
    (lambda _: sppm.Scene().export("mitsuba"), S, "there is no light"),
    # Settings.
    (render(width=0), I, "width is 0; it must be at least 1"),
    (render(height=-3), I, "height is -3; it must be at least 1"),
    (render(width=1 << 20, height=1 << 20), I, "pixels are rendered"),
    (render(iterations=1 << 40), I, "iterations is 1099511627776; it must be at most"),
    (render(iterations=2.5), T, "iterations must be a whole number, not float"),
    (render(iterations="many"), T, "iterations must be a whole number, not str"),
    (render(photons_per_iteration=True), T, "photons_per_iteration must be a whole number, not a bool"),
    (render(max_depth=1 << 13), I, "max_depth is 8192; it must be at most 4096"),
    (render(initial_radius=NAN), I, "initial_radius is NaN"),
    (render(initial_radius=[1]), T, "initial_radius must be a number, not list"),
    (render(seed=-1), I, "seed is -1; it must be at least 0"),
    (render(seed=1 << 64), I, "seed is 18446744073709551616; it must be at most"),
    (render(filter="sharp"), I, 'filter "sharp": there is no such; it is one of "box", "gaussian", "mitchell"'),
    (render(filter=3), T, "filter must be a name, not int"),
    (render(depth=3), T, "unexpected keyword argument 'depth'"),
    (lambda _: sppm.Settings().replace(depth=3), T, "there is no setting 'depth'; settings are width, height"),
    # Options.
    (render(engine="gpu"), I, 'engine "gpu": there is no such; it is one of "fast", "reference"'),
    (render(method=1), T, "method must be a name, not int"),
    (render(engine="reference", lanes="avx2"), I, "lanes: engine reference has no lanes"),
    (render(threads=0), I, "threads is 0; it must be at least 1"),
    (render(threads=1 << 20), I, "threads is 1048576; it must be at most 1024"),
    (render(memory_limit=1), I, "memory_limit: the render needs up to"),
    (render(time=0), I, "time is 0.0; it must be a finite number above 0"),
    (render(time="1m"), T, "time must be a number, not str"),
    (render(until_error=-1), I, "until_error is -1.0"),
    (render(every=3), I, "every says how often a checkpoint is written"),
    (render(every=timedelta(0), checkpoint="/nowhere/a.sppm"), I, "every is 0.0"),
    (render(checkpoint="/nowhere/a.sppm"), I, "checkpoint: /nowhere/a.sppm"),
    (render(profile="/nowhere/p.toml"), I, "/nowhere/p.toml"),
    (render(progress="yes"), T, "progress must be True, False, None or a function, not str"),
    (render(interrupt="ignore"), I, "interrupt 'ignore': there is no such"),
    (lambda _: sppm.render("cornell"), T, "scene must be a sppm.Scene, not str; sppm.Scene.load reads one"),  # type: ignore[arg-type]
    (lambda _: sppm.Render.resume("/nowhere/a.sppm"), F, "/nowhere/a.sppm: there is no such file"),
    (lambda _: sppm.Render.like("/nowhere/a.png"), F, "/nowhere/a.png: there is no such file"),
    # Renders.
    (closed(lambda render: render.iterate()), R, "the render is over"),
    (running(lambda render: render.iterate()), R, "the render is not paused"),
    (paused(lambda render: render.result()), R, "the render is paused, so this would wait for ever"),
    (paused(lambda render: next(iter(render))), R, "the render is paused"),
    (paused(lambda render: render.report), R, "the render is paused"),
    (running(lambda render: render.wait("long")), T, "timeout must be a number, not str"),  # type: ignore[arg-type]
    (running(lambda render: render.wait(-1)), I, "timeout is -1; it must be at least 0 seconds"),
    (running(lambda render: next(render.films(0))), I, "every is 0; it must be at least 1"),
    (running(lambda render: __import__("copy").copy(render)), T, "cannot be pickled or copied"),
    # Films.
    (lambda _: sppm.Film(np.ones((4, 5))), I, "radiance has shape (4, 5); an image is (height, width, 3)"),
    (lambda _: sppm.Film(np.ones((0, 5, 3))), I, "radiance has shape (0, 5, 3)"),
    (lambda _: sppm.Film(np.ones((4, 5, 3)), radius=np.ones((5, 4))), I, "radius has shape (5, 4)"),
    (lambda _: sppm.Film("a.png"), T, "radiance is an array of <U5"),
    (lambda _: sppm.Film.load("/nowhere/a.exr"), F, "/nowhere/a.exr: there is no such file"),
    (lambda _: sppm.info("/nowhere/a.exr"), F, "/nowhere/a.exr: there is no such file"),
    (lambda _: sppm.info(__file__), F, "test_misuse.py"),
    (lambda _: FILM.save("/nowhere/a.exr"), F, "/nowhere/a.exr"),
    (lambda _: FILM.save("a.gif"), F, "a.gif"),
    (lambda _: FILM.save("a.exr", exposure=1), I, "exposure: a.exr holds linear radiance"),
    (lambda _: FILM.save("a.pfm", tone="aces"), I, "tone: a.pfm holds linear radiance"),
    (lambda _: FILM.to_png(tone="filmic"), I, 'tone "filmic": there is no such; it is one of "clamp", "reinhard"'),
    (lambda _: FILM.to_png(tone=3), T, "tone must be a name, not int"),
    (lambda _: FILM.to_png(white=3), I, "white: only the curve reinhard has a white"),
    (lambda _: FILM.to_png(tone="reinhard", white=0), I, "white is 0.0; it must be a finite number above 0"),
    (lambda _: FILM.to_png(exposure=1e9), I, "exposure is 1000000000.0; it must be from -100 to 100 stops"),
    (lambda _: FILM.save_radius("a.exr"), I, "the film has no radius"),
    (lambda _: FILM.radiance.__setitem__(0, 0), ValueError, "assignment destination is read-only"),
    # Particles: files and styles.
    (lambda _: sppm.load_particles("/nowhere/a.xyz"), F, "/nowhere/a.xyz: there is no such file"),
    (lambda _: sppm.load_particles(17), T, "int holds no atoms; give Atoms of ASE"),
    (show(frame=-1), I, "frame is -1; it must be at least 0"),
    (show(frame=99), F, "has no frame 99; it has one frame, number 0"),
    (show(frame="first"), I, "frame 'first': it must be the number of a frame, from 0, or \"last\""),
    (show(color="radios"), I, "color: there is no column `radios` (did you mean radius?)"),
    (show(color="jmol"), I, "color: the file has no elements"),
    (show(color=3), T, "color must be a str, not int"),
    (show(color="x", map="jet"), I, "map: there is no map `jet`; the maps are viridis"),
    (show(color="x", range=(3, 1)), I, "range: `3.0..1.0` must be two numbers or percentiles, the lower first"),
    (show(color="x", range=(3,)), T, "range must be two numbers, or percentiles"),
    (show(radius=NAN), I, "radius: `nan` must be a number from"),
    (show(material="wood"), I, "material: there is no material `wood`"),
    (show(style="color"), I, "style [0]: `color` is no KEY=VALUE"),
    (show(radius=1, style=["x > 0: hide", "q > 1: hide"]), I, "style [1]: where: "),
    (show(style=["x > 0: hide", "q > 1: hide"]), I, "style [1]: where: "),
    (lambda scene: scene.add_particles(HEAP, style="q > 1: hide"), I, "style [0]: where: "),
    (lambda scene: scene.add_particles(HEAP, radius=1, style=["x > 0: hide", "q > 1: hide"]), I, "style [1]: where: "),
    (show(style=[{"colour": "red"}]), I, "style: there is no key 'colour'; the keys are where"),
    (show(style={"hide": "yes"}), T, "hide must be True or False, not str"),
    (show(cut="x >"), I, "cut: column 4: "),
    (show(bonds="all"), I, "bonds: `all` must be file"),
    (show(cell=True), I, "cell: the file has no cell"),
    (show(view="side"), I, 'view "side": there is no such; it is one of "front"'),
    (show(zoom=0), I, "zoom is 0.0; it must be from 0.1 to 1000"),
    (show(light="overcast", background="black"), I, "overcast light is that of the background"),
    (show(background="puce"), I, "background: `puce` must be transparent, #rrggbb or one of white"),
    (show(memory_limit=10), F, "allow more memory"),
    (lambda scene: scene.add_particles(HEAP, memory_limit=10), F, "allow more memory"),
    (lambda _: sppm.Particles.load(HEAP, memory_limit=10), F, "allow more memory"),
    (lambda scene: scene.add_particles(HEAP, origin=(0, 0)), I, "origin must be 3 numbers; it has shape (2,)"),
    (lambda scene: scene.add_particles(HEAP, radius=1e20), I, "a radius is 1e20"),
    # Particles: columns.
    (particles([[0, 0, INF]]), I, "positions [0] must be finite"),
    (particles(elements=["Xq"] * 2), I, 'elements: "Xq" is no symbol of an element'),
    (particles(elements=[6, 200]), I, "elements [1] is 200; it must be from 0 to 118"),
    (particles(radii=[1, -1]), I, "radii [1] is -1; it must be finite, and not negative"),
    (particles(names=[1.5, 2]), T, "names is an array of float64; give texts"),
    (particles(bonds=[[0, 2]]), I, "bonds [0] joins 0 and 2; it must join two of 2 particles"),
    (particles(cell=np.zeros((3, 3))), I, "the vectors of cell must be finite and linearly independent"),
    (particles(properties={"q": [1.0]}), I, 'properties["q"] has 1 values for 2 particles'),
    (particles(ids=[1, -1]), I, "ids has numbers from -1 to 1"),
    (particles(unit="foot"), I, 'unit "foot": there is no such'),
    (lambda _: sppm.Particles([0, 0, 0]).replace(colour=1), T, "there is no column 'colour'"),
    (lambda _: sppm.Particles.of("water.pdb"), T, "str holds no atoms"),
    (lambda _: sppm.frame_count("/nowhere/a.xyz"), F, "/nowhere/a.xyz"),
    # Comparisons and rays.
    (lambda _: sppm.compare(FILM, np.ones((5, 4, 3))), I, "image A is 5 x 4 pixels and image B 4 x 5"),
    (lambda _: sppm.compare(FILM, np.full((4, 5, 3), NAN)), I, "image B has 20 pixels with a NaN"),
    (lambda _: sppm.compare(FILM, None), T, "b is an array of object"),  # type: ignore[arg-type]
    (lambda _: sppm.compare(FILM, "/nowhere/a.png"), F, "/nowhere/a.png"),
    (lambda scene: sppm.trace(scene, [0, 0, 0], [0, 0, 0]), I, "ray [0] has a direction of length 0"),
    (lambda scene: sppm.trace(scene, [0, NAN, 0], [0, 0, 1]), I, "ray [0] is not finite"),
    (lambda scene: sppm.trace(scene, np.ones((3, 3)), np.ones((2, 3))), I, "directions has 2 rows; there are 3 rays"),
    (lambda scene: sppm.trace(scene, np.ones(6), np.ones(3)), I, "origins has shape (6,)"),
    (lambda scene: sppm.trace(scene, [0, 0, 0], [0, 0, 1], time=2), I, "time: 2 is not while the shutter is open"),
    (lambda scene: sppm.trace(scene, [0, 0, 0], [0, 0, 1], engine="path"), I, 'engine "path"'),
    (lambda scene: sppm.verify(scene, method="magic", **SMALL), I, 'method "magic": there is no such'),  # type: ignore[arg-type]
]


def test_there_are_enough() -> None:
    assert len(MISUSES) >= 60


@pytest.mark.parametrize(("misuse", "kind", "said"), MISUSES, ids=[said[:50] for _, _, said in MISUSES])
def test_misuse(misuse: Misuse, kind: type[Exception], said: str, cornell: sppm.Scene) -> None:
    before = cornell.digest, len(cornell.materials)
    with pytest.raises(kind, match=re.escape(said)) as caught:
        misuse(cornell)
    message = str(caught.value)
    assert "\n" not in message and len(message) > 10
    assert type(caught.value) is kind
    assert (cornell.digest, len(cornell.materials)) == before


def test_no_panic_reaches_python() -> None:
    from sppm import _sppm

    break_down = getattr(_sppm, "break_down", None)
    if break_down is None:
        pytest.skip("only builds for tests break down on purpose")
    with pytest.raises(sppm.RenderError, match="sppm broke down; this is a fault of sppm"):
        break_down()


def test_errors_are_what_python_programs_expect() -> None:
    assert issubclass(sppm.SceneError, sppm.InputError) and issubclass(sppm.InputError, ValueError)
    assert issubclass(sppm.Interrupted, KeyboardInterrupt) and not issubclass(sppm.Interrupted, Exception)
    for name in ("SceneError", "InputError", "FileError", "RenderError"):
        kind = getattr(sppm, name)
        assert issubclass(kind, sppm.Error) and kind.__module__ == "sppm"
