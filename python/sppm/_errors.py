"""The exceptions of the package."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from ._film import Film


class Error(Exception):
    """Any error of sppm, with a message of one line that says what is wrong and what would be right."""


class InputError(Error, ValueError):
    """An argument or a setting has a value that it cannot have. The message names it."""


class SceneError(InputError):
    """A scene, or a scene file, is not one that can be rendered. The message names the part at fault.

    Indices in square brackets, as in ``sphere [3]``, count from 0. Messages about scene files give line and column.
    """


class FileError(Error):
    """A file cannot be read or written. The message begins with its path."""


class RenderError(Error, RuntimeError):
    """A render failed, or was used after its end."""


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


class RenderWarning(UserWarning):
    """Something went wrong that does not end a render, such as a checkpoint that could not be written."""


for _public in (Error, InputError, SceneError, FileError, RenderError, Interrupted, RenderWarning):
    _public.__module__ = "sppm"
