"""The exception of a render that was interrupted, which keeps its image."""

from __future__ import annotations

from collections.abc import Callable

from ._film import Film


class Interrupted(KeyboardInterrupt):
    """A render was interrupted by Ctrl-C, or by the button of a notebook.

    It is a ``KeyboardInterrupt``, so that a loop over renders ends with it unless it is caught. What was rendered is
    not lost: ``film`` is the image after the last complete iteration, or ``None`` before the first.
    """

    def __init__(self, film: Film | None = None) -> None:
        """An interruption that keeps ``film``."""
        super().__init__()
        self._film = film
        self._find: Callable[[], Film | None] | None = None

    @classmethod
    def _of(cls, find: Callable[[], Film | None]) -> Interrupted:
        """An interruption whose film is what ``find`` gives, when it is asked for."""
        interrupted = cls()
        interrupted._find = find
        return interrupted

    @property
    def film(self) -> Film | None:
        """The image after the last complete iteration; ``None`` before the first.

        A large one may not be developed yet when the exception is raised; then this waits for it.
        """
        if self._find is not None:
            self._film = self._find()
            self._find = None
        return self._film

    def __str__(self) -> str:
        """What happened."""
        if self._find is not None:
            return "the render was interrupted; its image so far, if there is one, is the attribute film"
        if self._film is None:
            return "the render was interrupted before its first iteration; it has no image"
        return f"the render was interrupted after {self._film.iterations} iterations; its image is the attribute film"

    def __reduce__(self) -> tuple[type[Interrupted], tuple[Film | None]]:
        """For ``pickle``."""
        return Interrupted, (self.film,)


Interrupted.__module__ = "sppm"


def interrupted(find: Callable[[], Film | None]) -> Interrupted:
    """An interruption whose film is what ``find`` gives, when it is asked for."""
    return Interrupted._of(find)  # pyright: ignore[reportPrivateUsage]
