"""The exceptions of the package."""


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


class RenderWarning(UserWarning):
    """Something went wrong that does not end a render, such as a checkpoint that could not be written."""


class SceneWarning(UserWarning):
    """Something that one should know of a scene file, such as a lamp that is sealed off and lights nothing."""


class ParticleWarning(UserWarning):
    """Something that one should know of a scene of particles, such as that some have no radius and are left out."""


for _public in (Error, InputError, SceneError, FileError, RenderError, RenderWarning, SceneWarning, ParticleWarning):
    _public.__module__ = "sppm"
