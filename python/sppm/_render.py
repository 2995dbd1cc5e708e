"""Renders: from start to end in one call, or watched, stopped and resumed."""

from __future__ import annotations

import json
import os
import threading
import warnings
from collections.abc import Callable, Iterator
from datetime import timedelta
from types import TracebackType
from typing import Any, Literal, TypeAlias

from . import _numbers, _sppm
from ._errors import InputError, RenderError, RenderWarning
from ._film import Film, Tone, new_film
from ._interrupted import Interrupted, interrupted
from ._options import Engine, Lanes, Method, Quality, options
from ._progress import Bar, Progress, Show
from ._scene import Scene, Source, native
from ._settings import Filter, RadiusSchedule

Interrupt: TypeAlias = Literal["raise"] | Literal["return"]
"""What Ctrl-C does."""

_TICK = 0.02
"""Seconds after which a wait looks for Ctrl-C, and for progress."""


def render(
    scene: Scene,
    *,
    quality: Quality | None = None,
    iterations: int | None = None,
    width: int | None = None,
    height: int | None = None,
    photons_per_iteration: int | None = None,
    max_depth: int | None = None,
    initial_radius: float | None = None,
    seed: int | None = None,
    filter: Filter | None = None,
    radius_schedule: RadiusSchedule | None = None,
    radius_pilots: int | None = None,
    radius_clearance: float | None = None,
    light_samples: int | None = None,
    glint_samples: int | None = None,
    method: Method | None = None,
    engine: Engine = "fast",
    lanes: Lanes | None = None,
    profile: Source | None = None,
    threads: int | None = None,
    memory_limit: int | None = None,
    time: float | timedelta | None = None,
    until_error: float | None = None,
    checkpoint: Source | None = None,
    every: int | timedelta | None = None,
    progress: Show = None,
    interrupt: Interrupt = "raise",
) -> Film:
    """Renders a scene and returns the image.

    What is not given is as in ``scene.settings``; :class:`sppm.Settings` explains the settings. The image depends on
    scene and settings alone, and not on ``engine``, ``lanes``, ``profile`` and ``threads``. Other Python threads go on
    while it renders.

    - ``quality``: chooses method, iterations, photons, depth and radius from the scene, as far as they are not given, for
      a picture that shows what is where (``"draft"``), looks finished (``"good"``) or has hardly any noise that can be
      seen (``"final"``); ``"paper"`` takes the settings of the paper. Without it they are as in ``scene.settings``.
    - ``method``: ``"sppm"``, photon mapping, ``"path"``, path tracing, or ``"hybrid"``, path tracing with photons for
      caustics. If not given, it is chosen with the quality where neither photons nor a radius are given, and else is
      ``scene.method``.
    - ``threads``: number of threads; one per core if not given.
    - ``memory_limit``: in bytes; a render that needs more is refused.
    - ``time``: a limit in seconds, or a ``timedelta``. ``until_error``: the estimated relative error to reach. With one
      of these, iterations are as many as it takes, unless they are given too.
    - ``checkpoint``: a file from which the render can be resumed. If it exists, and is of this render, the render goes
      on from there. ``every``: how often it is written: a number of iterations, or a ``timedelta``; by default a minute.
    - ``profile``: a file that ``sppm tune`` wrote.
    - ``progress``: ``True`` shows a bar, ``None`` one in terminals and notebooks; a function is called with each
      :class:`sppm.Progress`.
    - ``interrupt``: on Ctrl-C, ``"raise"`` raises :class:`sppm.Interrupted`, which has the image so far; ``"return"``
      returns the image so far, so that the program goes on. The checkpoint is written in both cases.

    Raises SceneError if the scene cannot be rendered, InputError or TypeError for wrong arguments, FileError if the
    checkpoint or profile cannot be read, and RenderError if the render fails.
    """
    _check_interrupt(interrupt)
    try:
        running = Render(
            scene,
            quality=quality,
            iterations=iterations,
            width=width,
            height=height,
            photons_per_iteration=photons_per_iteration,
            max_depth=max_depth,
            initial_radius=initial_radius,
            seed=seed,
            filter=filter,
            radius_schedule=radius_schedule,
            radius_pilots=radius_pilots,
            radius_clearance=radius_clearance,
            light_samples=light_samples,
            glint_samples=glint_samples,
            method=method,
            engine=engine,
            lanes=lanes,
            profile=profile,
            threads=threads,
            memory_limit=memory_limit,
            time=time,
            until_error=until_error,
            checkpoint=checkpoint,
            every=every,
        )
    except KeyboardInterrupt:
        raise Interrupted from None
    with running:
        return running.result(progress=progress, interrupt=interrupt)


class Render:
    """A render that runs on threads of its own, from its creation on.

    ``with sppm.Render(scene) as render:`` stops it at the end of the block. It can be asked for its image and progress
    at any time, from any thread, stopped, and resumed from a checkpoint.
    """

    def __init__(
        self,
        scene: Scene,
        *,
        quality: Quality | None = None,
        iterations: int | None = None,
        width: int | None = None,
        height: int | None = None,
        photons_per_iteration: int | None = None,
        max_depth: int | None = None,
        initial_radius: float | None = None,
        seed: int | None = None,
        filter: Filter | None = None,
        radius_schedule: RadiusSchedule | None = None,
        radius_pilots: int | None = None,
        radius_clearance: float | None = None,
        light_samples: int | None = None,
        glint_samples: int | None = None,
        method: Method | None = None,
        engine: Engine = "fast",
        lanes: Lanes | None = None,
        profile: Source | None = None,
        threads: int | None = None,
        memory_limit: int | None = None,
        time: float | timedelta | None = None,
        until_error: float | None = None,
        checkpoint: Source | None = None,
        every: int | timedelta | None = None,
        paused: bool = False,
    ) -> None:
        """Starts a render of a copy of ``scene``. The arguments are those of :func:`sppm.render`.

        With ``paused``, it does only the iterations that :meth:`iterate` asks for.

        Raises what :func:`sppm.render` raises before it starts.
        """
        scene_native = native(scene)
        if iterations is None and not (time is None and until_error is None):
            iterations = _sppm.MAX_ITERATIONS
        settings = scene.settings.replace(
            width=width,
            height=height,
            iterations=iterations,
            photons_per_iteration=photons_per_iteration,
            max_depth=max_depth,
            initial_radius=initial_radius,
            seed=seed,
            filter=filter,
            radius_schedule=radius_schedule,
            radius_pilots=radius_pilots,
            radius_clearance=radius_clearance,
            light_samples=light_samples,
            glint_samples=glint_samples,
        )
        if every is not None and checkpoint is None:
            raise InputError("every says how often a checkpoint is written; name its file by checkpoint")
        # Photon mapping is usual, so a scene that has it states nothing.
        stated = method if method is not None or scene.method == "sppm" else scene.method
        radii = (initial_radius, radius_pilots, radius_clearance)
        given = (iterations, photons_per_iteration, max_depth, *radii, glint_samples)
        checked = options(
            settings=settings,
            quality=quality,
            given=[value is not None for value in given],
            method=stated,
            engine=engine,
            lanes=lanes,
            profile=profile,
            threads=threads,
            memory_limit=memory_limit,
            time=time,
            until_error=until_error,
            checkpoint=checkpoint,
            every=every,
            paused=paused,
        )
        begun = _sppm.Render.start(scene_native, checked)
        # As the command writes pictures of particles.
        self._begin(begun, begun.iterations, paused, "clamp" if scene_native.is_stage else None)

    def _begin(self, native: _sppm.Render, iterations: int, paused: bool, tone: Tone | None) -> None:
        self._native = native
        self._iterations = iterations
        self._paused = paused
        self._film: Film | None = None
        self._tone: Tone | None = tone
        self._report: dict[str, Any] | None = None
        self._ended_by: str | None = None
        self._checkpoint: str | None = None
        self._error: Exception | None = None
        self._lock = threading.RLock()

    @classmethod
    def resume(
        cls,
        checkpoint: Source,
        *,
        iterations: int | None = None,
        method: Method | None = None,
        engine: Engine | None = None,
        lanes: Lanes | None = None,
        profile: Source | None = None,
        threads: int | None = None,
        memory_limit: int | None = None,
        time: float | timedelta | None = None,
        until_error: float | None = None,
        every: int | timedelta | None = None,
        paused: bool = False,
    ) -> Render:
        """Resumes the render that wrote ``checkpoint``, of this module or of the command ``sppm``.

        Scene and settings are those of the checkpoint. ``iterations`` are those in all; more than before continue a
        complete render. The image is the same as that of a render without a pause. If the file is damaged, the
        generation before is resumed, with a :class:`sppm.RenderWarning`.

        Raises FileError if there is no valid checkpoint, or if another render is using it.
        """
        if iterations is not None:
            iterations = _numbers.whole(iterations, "iterations", 1, _sppm.MAX_ITERATIONS, InputError)
        checked = options(
            method=method,
            engine=engine,
            lanes=lanes,
            profile=profile,
            threads=threads,
            memory_limit=memory_limit,
            time=time,
            until_error=until_error,
            every=every,
            paused=paused,
        )
        return cls.adopt(_sppm.Render.resume(os.fspath(checkpoint), iterations, checked), paused)

    @classmethod
    def like(
        cls,
        file: Source,
        scene: Scene | None = None,
        *,
        lanes: Lanes | None = None,
        threads: int | None = None,
        memory_limit: int | None = None,
        checkpoint: Source | None = None,
        every: int | timedelta | None = None,
        paused: bool = False,
    ) -> Render:
        """Repeats the render that wrote ``file``, a ``.png`` or ``.exr`` image or a checkpoint, with the same result.

        ``scene`` must be given if its text is longer than a mebibyte, and must be the same scene. Files of particles that
        an image of the command names are searched beside the image, in the current folder, and where ``scene`` comes
        from.

        Raises FileError if the file does not say what made it, or if the scene is another.
        """
        checked = options(
            lanes=lanes, threads=threads, memory_limit=memory_limit, checkpoint=checkpoint, every=every, paused=paused
        )
        own = None if scene is None else native(scene)
        return cls.adopt(_sppm.Render.like(os.fspath(file), own, checked), paused)

    @classmethod
    def adopt(cls, native: _sppm.Render, paused: bool) -> Render:
        """A render that the extension module has started; for the package alone."""
        render = cls.__new__(cls)
        render._begin(native, native.iterations, paused, None)
        return render

    # While it runs.

    @property
    def progress(self) -> Progress:
        """How far the render is."""
        step = self._native.progress()
        return Progress(iterations=self._iterations) if step is None else Progress(*step)

    @property
    def is_over(self) -> bool:
        """Whether the render has ended: it is complete, has reached a goal, was stopped or has failed."""
        return self._native.wait(0.0)

    @property
    def film(self) -> Film | None:
        """The image after the next complete iteration, for which this waits; after the end, the last image.

        ``None`` if the render was stopped before its first iteration was complete. The image of a paused render is
        that after the iterations done so far.
        """
        with self._lock:
            if self._paused and not self.is_over and self._native.wait_for_pause(0.0):
                self._take()
                return self._film
            self._native.want_image()
            self._wait(self._native.wait_for_image)
            self._take()
            if self._native.wait(0.0):
                self._end()
            return self._film

    def films(self, every: int = 1) -> Iterator[Film]:
        """The image after at least ``every`` more iterations, again and again; the last image comes last."""
        every = _numbers.whole(every, "every", 1, _sppm.MAX_ITERATIONS, InputError)
        self._check_free()
        done = 0
        while not self._wait_beyond(done + every - 1):
            film = self.film
            if film is not None and film.iterations > done and not self.is_over:
                done = film.iterations
                yield film
        last = self.film
        if last is not None and last.iterations > done:
            yield last

    def __iter__(self) -> Iterator[Progress]:
        """Progress after each iteration, until the render is over. What the loop has no time for is left out."""
        self._check_free()
        done = 0
        while True:
            is_over = self._wait_beyond(done)
            progress = self.progress
            if progress.iteration > done:
                done = progress.iteration
                yield progress
            elif is_over:
                break
        self._end()

    def iterate(self, iterations: int = 1) -> Film | None:
        """Does so many more iterations of a paused render, and returns the image after them.

        It may be fewer if the render reaches its end. Raises RenderError if the render is not paused, or is over.
        """
        iterations = _numbers.whole(iterations, "iterations", 1, _sppm.MAX_ITERATIONS, InputError)
        with self._lock:
            if not self._paused:
                raise RenderError("the render is not paused; start it with paused=True to iterate by hand")
            if self.is_over:
                raise RenderError("the render is over; its image is the attribute film")
            self._wait(self._native.wait_for_pause)
            self._native.allow(iterations)
            self._wait(self._native.wait_for_pause)
            return self.film

    def stop(self) -> None:
        """Asks the render to stop. It abandons the iteration in progress, and writes its checkpoint."""
        self._native.stop()

    def wait(self, timeout: float | None = None) -> bool:
        """Waits until the render is over, at most ``timeout`` seconds; returns whether it is.

        Raises InputError if ``timeout`` is negative.
        """
        if timeout is None:
            self._check_free()
            self._wait(self._native.wait)
            return True
        seconds = _numbers.real(timeout, "timeout")
        if not seconds >= 0.0:
            raise InputError(f"timeout is {timeout}; it must be at least 0 seconds")
        whole, rest = divmod(min(seconds, 1e9), _TICK)
        return any(self._native.wait(_TICK) for _ in range(int(whole))) or self._native.wait(rest)

    def result(self, *, progress: Show = None, interrupt: Interrupt = "raise") -> Film:
        """Waits for the end and returns the image. The arguments are those of :func:`sppm.render`.

        Raises RenderError if the render failed, or was stopped before its first iteration was complete.
        """
        _check_interrupt(interrupt)
        self._check_free()
        try:
            with Bar(progress, self._iterations) as bar:
                while not self._native.wait(_TICK):
                    bar.update(self.progress)
                bar.update(self.progress)
            self._end()
        except KeyboardInterrupt:
            self._let_go()
            if interrupt == "return":
                self._end()
            if interrupt == "raise" or self._film is None:
                raise interrupted(self._last) from None
        if self._film is None:
            raise RenderError("the render was stopped before its first iteration was complete; it has no image")
        return self._film

    # After its end.

    @property
    def report(self) -> dict[str, Any]:
        """What the render did: settings, seconds per pass and counted work, as ``--stats`` of the command.

        Waits for the end. Raises RenderError if the render failed.
        """
        self._check_free()
        self._end()
        return dict(self._report or {})

    @property
    def ended_by(self) -> str:
        """What ended the render: ``"iterations"``, ``"time"``, ``"error"`` or ``"stop"``. Waits for the end."""
        self._check_free()
        self._end()
        return self._ended_by or "stop"

    @property
    def checkpoint(self) -> str | None:
        """The path of the last checkpoint; ``None`` if there is none. Waits for the end."""
        self._check_free()
        self._end()
        return self._checkpoint

    def close(self) -> None:
        """Stops the render and waits for its end. Image and report stay. It may be called again."""
        self.stop()
        self._end()

    def __enter__(self) -> Render:
        """The render itself."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stops the render and waits for its end, but not after Ctrl-C."""
        # An error of the render must not hide that of the block.
        if error is None:
            self.close()
        elif isinstance(error, KeyboardInterrupt):
            self._let_go()
        else:
            self.stop()
            self._native.wait(1.0)

    def __repr__(self) -> str:
        """How far it is."""
        progress = self.progress
        state = "over" if self.is_over else "running"
        return f"<sppm.Render: {state}, {progress.iteration} of {self._iterations} iterations>"

    def __reduce__(self) -> tuple[Any, ...]:
        """A render cannot be pickled."""
        raise TypeError("a sppm.Render cannot be pickled or copied; its film and its checkpoint can")

    def _wait(self, until: Callable[[float], bool]) -> None:
        """Waits, looking for Ctrl-C now and then."""
        while not until(_TICK):
            pass

    def _wait_beyond(self, iteration: int) -> bool:
        """Waits until more than so many iterations are done; returns whether the render is over."""
        while not self._native.wait_beyond(iteration, _TICK):
            pass
        return self.is_over

    def _take(self) -> None:
        """Takes the newest image, and gives the warnings."""
        image = self._native.take_image()
        if image is not None:
            self._film = new_film(*image, self._tone)
        for text in self._native.warnings():
            warnings.warn(text, RenderWarning, stacklevel=4)

    def _end(self) -> None:
        """Waits for the end, and keeps what there is to know of it."""
        with self._lock:
            if self._error is not None:
                raise self._error
            if self._report is not None:
                return
            self._wait(self._native.wait)
            try:
                report, self._ended_by, checkpoint = self._native.finish()
                self._report = json.loads(report)
                self._checkpoint = None if checkpoint is None else os.fspath(checkpoint)
            except Exception as error:
                self._error = error
                raise
            finally:
                self._take()

    def _let_go(self) -> None:
        """Stops the render without waiting for its end. A checkpoint that is due is still written, if need be while the
        interpreter exits."""
        self.stop()
        if self.is_over:
            return
        # Python waits for such a thread before it exits, unless it is a daemon: then there is nothing to lose.
        has_image = self._native.progress() is not None
        threading.Thread(target=_see_out, args=(self._native,), daemon=not has_image).start()

    def _last(self) -> Film | None:
        """The last image, after the end."""
        self._end()
        return self._film

    def _check_free(self) -> None:
        """Refuses to wait for the end of a render that is paused."""
        if self._paused and not self.is_over:
            raise RenderError("the render is paused, so this would wait for ever; use iterate, or stop it first")


def _see_out(native: _sppm.Render) -> None:
    """Keeps a render until it is over."""
    while not native.wait(1.0):
        pass


def _check_interrupt(interrupt: object) -> None:
    if interrupt not in ("raise", "return"):
        raise InputError(f'interrupt {interrupt!r}: there is no such; it is "raise" or "return"')
