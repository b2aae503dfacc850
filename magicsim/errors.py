"""Every error that magicsim raises on purpose, each one line that names what is wrong and what is allowed."""

import difflib
from collections.abc import Iterable

from magicsim.errors import NAME_LENGTH, one_line, shortened


class MagicsimError(ValueError):
    """Base of all deliberate errors; the command line prints it as one line and exits with 2.

    Whatever a message quotes, it is one printable line of bounded length (`magicsim.errors.one_line`).
    """

    def __init__(self, message: str = "") -> None:
        """Takes the message."""
        super().__init__(one_line(message))


class ConfigError(MagicsimError):
    """A configuration file, an override or an option is not acceptable."""


class PresetError(MagicsimError):
    """A preset or file that was asked for by name does not exist."""


class GeometryError(MagicsimError):
    """A design or an object cannot be built; the message names the limit that failed."""


class ConvergenceError(MagicsimError):
    """A deformation is not valid: not converged, folded, penetrating or out of balance; figures inside."""

    def __init__(self, message: str, history: tuple[object, ...] = ()) -> None:
        """Takes the message and, where there were any, the figures of every iteration."""
        super().__init__(message)
        self.history = history


class RenderError(MagicsimError):
    """A scene cannot be rendered to a trustworthy image."""


class FrameError(MagicsimError):
    """An image cannot be used by the detectors: wrong shape, type or content."""


class OutputError(MagicsimError):
    """A result cannot be written where it was asked for."""


def unknown_choice(what: str, value: str, choices: Iterable[str]) -> str:
    """One line for a name that does not exist: what was asked for, the nearest name, all choices.

    Args:
        what: The kind of thing, such as `design` or `object kind`.
        value: The name that does not exist.
        choices: The names that do.
    """
    names = sorted(choices)
    asked = shortened(value, NAME_LENGTH)
    near = difflib.get_close_matches(asked, names, n=1)
    hint = f" (did you mean '{near[0]}'?)" if near else ""
    return f"unknown {what} '{asked}'{hint}; available: {', '.join(names) or 'none'}"
