"""How text from outside is shown: on one line, of bounded length, with every character that hides spelt out."""

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
    """The text, or its head and tail with a note of how much lies between.

    Args:
        text: Of any length.
        length: Longest result [characters].
    """
    if len(text) <= length:
        return text
    kept = max(2, length - len(f" [... {len(text)} characters ...] "))
    head = round(kept * HEAD_SHARE)
    return f"{text[:head]} [... {len(text) - kept} characters ...] {text[len(text) - (kept - head) :]}"


def one_line(text: str, length: int = LINE_LENGTH) -> str:
    """The text as one printable line of bounded length; a line that is one already stays as it is."""
    return shortened(visible(shortened(text, 4 * length)), length)
