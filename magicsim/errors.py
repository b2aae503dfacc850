"""Every error that magicsim raises on purpose, one line that names what is wrong and what is allowed."""

import difflib
from collections.abc import Iterable
from unicodedata import category

SPACE = "Zs"
"""Category of spaces, of which those that do not break are not printable for Python."""
LINE_LENGTH = 480
"""Longest message [characters]: with the name of the program before it, a line stays below 500."""
NAME_LENGTH = 80
"""Longest part of a name that a message quotes [characters]."""
HEAD_SHARE = 0.55
"""Part of what is kept that comes from the beginning; the rest is the end, which says what is allowed."""


def visible(text: str) -> str:
    r"""The text with control, bidirectional and other invisible characters spelt out, such as `\x1b` or `\u202e`."""
    if text.isprintable():
        return text
    return "".join(
        each if each.isprintable() or category(each) == SPACE else each.encode("unicode_escape").decode()
        for each in text
    )


def shortened(text: str, length: int) -> str:
    """The text, or its head and tail with a note of how much lies between."""
    if len(text) <= length:
        return text
    kept = max(2, length - len(f" [... {len(text)} characters ...] "))
    head = round(kept * HEAD_SHARE)
    return f"{text[:head]} [... {len(text) - kept} characters ...] {text[len(text) - (kept - head) :]}"


def one_line(text: str, length: int = LINE_LENGTH) -> str:
    """The text as one printable line of bounded length; a line that is one already stays as it is."""
    return shortened(visible(shortened(text, 4 * length)), length)


class MagicsimError(ValueError):
    """Base of all deliberate errors; the command line prints it as one line and exits with 2.

    Whatever a message quotes, it is one printable line of bounded length (`one_line`).
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(one_line(message))


class ConfigError(MagicsimError):
    """A configuration file, an override or an option is not acceptable."""


class PresetError(MagicsimError):
    """A preset or file that was asked for by name does not exist."""


class GeometryError(MagicsimError):
    """A design or an object cannot be built; the message names the limit that failed."""


class ConvergenceError(MagicsimError):
    """A deformation is not valid: not converged, folded, penetrating or out of balance; the message has the figures."""


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
