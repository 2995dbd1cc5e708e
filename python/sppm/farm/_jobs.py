"""The renders that a farm is asked for: scenes, folders of scenes, sweeps of settings."""

from __future__ import annotations

import hashlib
import itertools
import os
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import sppm
from sppm import InputError, Scene, _sppm
from sppm._scene import native
from sppm._settings import of_tuple, to_tuple

_WHOLE = ("width", "height", "iterations", "photons_per_iteration", "max_depth", "seed", "glint_samples")
_SHORT = {"radius": "initial_radius", "photons": "photons_per_iteration", "depth": "max_depth"}

_CHOSEN = {"iterations": "-n", "photons_per_iteration": "--photons", "max_depth": "--depth", "initial_radius": "--radius",
           "glint_samples": "--glint-samples"}
"""Settings that may be chosen, with the options that state them, in the order of the extension module."""

Range = tuple[int, int]
"""Iterations, from the first, counted from 0, to before the second."""


@dataclass
class Job:
    """One image: a scene with its settings, and the files that it is rendered to."""

    scene: Scene
    output: Path
    """The image."""
    done: list[Range] = field(default_factory=list[Range])
    """The iterations in the state file."""
    chosen: str = ""
    """The settings that were chosen, as options that repeat the choice."""

    def __post_init__(self) -> None:
        """Radii are global, and alike in all pixels, as parts of others cannot be merged."""
        self.scene.settings = self.scene.settings.replace(
            radius_schedule="global", radius_pilots=0, radius_clearance=0)

    def choose(self, source: str, quality: str | None, given: set[str]) -> None:
        """Chooses the settings that are not ``given``, at this quality or, without one, as far as ``source``, the scene's file,
        leaves them open. The choice is recorded in the state file, as all settings are.
        """
        usual, left = _sppm.left_open(source)
        if "initial_radius" in given:
            given = given | {"glint_samples"}  # whoever gives a radius chooses by hand
        names = [name for name, is_open in zip(_CHOSEN, left, strict=True)
                 if name not in given and (is_open or quality is not None)]
        if not names:
            return
        quality = quality or usual
        flags = [name not in names for name in _CHOSEN]
        chosen = _sppm.choose_settings(native(self.scene), to_tuple(self.scene.settings), quality, flags)
        self.scene.settings = of_tuple(chosen)
        if quality != "paper":
            options = [f"{_CHOSEN[name]} {getattr(self.scene.settings, name):.9g}" for name in names]
            self.chosen = f"quality {quality}: {' '.join(options)}"

    @property
    def state(self) -> Path:
        """The checkpoint that the farm keeps of it: beside the image, or the output itself if that is one."""
        return self.output if self.output.suffix == ".sppm" else self.output.with_name(self.output.name + ".sppm")

    @property
    def iterations(self) -> int:
        """How many are asked for."""
        return self.scene.settings.iterations

    @property
    def name(self) -> str:
        """A name for all that its image depends on."""
        text = f"{self.scene.digest} {self.scene.settings} {_sppm.TRANSPORT}"
        return hashlib.sha256(text.encode()).hexdigest()[:24]

    def load(self) -> None:
        """Finds what an earlier run has done.

        Raises InputError if the state file is damaged, or of another render.
        """
        if not self.state.exists():
            return
        merged = sppm.merge([self.state])
        info = sppm.info(self.state)
        theirs, ours = dict(info["settings"]), _plain(self.scene)
        theirs.pop("iterations")
        if info["scene_digest"] != self.scene.digest or theirs != ours:
            raise InputError(f"{self.state} is of another render; remove it, or name another output")
        if merged.iterations and (last := merged.iterations[-1][1]) > self.iterations:
            raise InputError(f"{self.state} holds iterations up to {last}, not {self.iterations}; ask for as many, or more")
        self.done = merged.iterations


def _plain(scene: Scene) -> dict[str, Any]:
    """The settings of a scene as its files name them, but for the number of iterations."""
    settings = scene.settings
    # Files do not name pilots and clearance where there are none, and a farm has none; nor a single sample of glints.
    left_out = {"iterations", "radius_pilots", "radius_clearance"}
    if settings.glint_samples == 1:
        left_out.add("glint_samples")
    names = [name for name in settings.__dataclass_fields__ if name not in left_out]
    return {name: getattr(settings, name) for name in names}


def jobs_of(
    scenes: list[str], output: Path | None, settings: dict[str, Any], sweeps: list[str], quality: str | None = None
) -> list[Job]:
    """The jobs for ``scenes``, which are names, files or folders of files, each with all values of ``sweeps``.

    Settings that neither ``settings`` nor a sweep gives are chosen at this ``quality``; without one, those that the scene's
    file leaves open.

    ``output`` is the image of a single job, or the folder of several. Raises InputError if a sweep is not one, or if two
    jobs would write one file.
    """
    axes = [_axis(sweep) for sweep in sweeps]
    names = [name for scene in scenes for name in _files(scene)]
    combinations = list(itertools.product(*axes)) if axes else [()]
    jobs: list[Job] = []
    is_one = len(names) * len(combinations) == 1
    for name, combination in itertools.product(names, combinations):
        scene = Scene.load(name)
        stated = {**settings, **{key: value for key, value, _ in combination}}
        scene.settings = scene.settings.replace(**stated)
        stem = "-".join([Path(name).stem, *(f"{key}-{text}" for key, _, text in combination)])
        default = Path(f"{stem}.png")
        if is_one:
            path = default if output is None else output
        else:
            path = default if output is None else output / default
        job = Job(scene, path)
        job.choose(name, quality, {key for key, value in stated.items() if value is not None})
        jobs.append(job)
    seen: set[str] = set()
    for job in jobs:
        whole = os.path.abspath(job.output)
        if whole in seen:
            raise InputError(f"{job.output} would be the image of two renders; rename one of the scenes")
        seen.add(whole)
    if output is not None and not is_one:
        output.mkdir(parents=True, exist_ok=True)
    return jobs


def _files(scene: str) -> list[str]:
    """The scene, or the scene files of the folder."""
    if not Path(scene).is_dir():
        return [scene]
    files = sorted(str(file) for file in Path(scene).iterdir() if file.suffix == ".toml")
    if not files:
        raise InputError(f"{scene}: there is no scene file (.toml) in this folder")
    return files


def _axis(sweep: str) -> list[tuple[str, Any, str]]:
    """The values of a sweep such as ``radius=0.5,1,2``: name, value and text of each."""
    name, equals, texts = sweep.partition("=")
    name = name.strip().replace("-", "_")
    name = _SHORT.get(name, name)
    known = [*_WHOLE, "initial_radius", "filter"]
    if not equals or name not in known:
        raise InputError(f"--sweep {sweep}: name a setting and its values, as radius=0.5,1,2; settings are "
                         f"{', '.join(known)}")
    kind = int if name in _WHOLE else float if name == "initial_radius" else str
    values: list[tuple[str, Any, str]] = []
    for text in (text.strip() for text in texts.split(",")):
        try:
            values.append((name, kind(text), text))
        except ValueError:
            raise InputError(f"--sweep {sweep}: {text!r} is not a value of {name}") from None
    return values
