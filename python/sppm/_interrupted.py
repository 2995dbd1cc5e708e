"""The exception of a render that was interrupted, which keeps its image."""

from __future__ import annotations

from ._film import Film


class Interrupted(KeyboardInterrupt):
    """A render was interrupted by Ctrl-C, or by the button of a notebook.

    It is a ``KeyboardInterrupt``, so that a loop over renders ends with it unless it is caught. What was rendered is
    not lost: ``film`` is the image after the last complete iteration, or ``None`` before the first.
    """

    def __init__(self, film: Film | None = None) -> None:
        """An interruption that keeps ``film``."""
        done = "before its first iteration" if film is None else f"after {film.iterations} iterations"
        super().__init__(f"the render was interrupted {done}; its image is the attribute film")
        self._film = film

    @property
    def film(self) -> Film | None:
        """The image after the last complete iteration; ``None`` before the first."""
        return self._film

    def __reduce__(self) -> tuple[type[Interrupted], tuple[Film | None]]:
        """For ``pickle``."""
        return Interrupted, (self.film,)


Interrupted.__module__ = "sppm"
