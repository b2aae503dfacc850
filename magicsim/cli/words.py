"""How a word of the command line becomes a value, for the options of every command."""

from collections.abc import Sequence
from typing import Any

from cyclopts import Token, convert


def read_words(kind: type[Any], tokens: Sequence[Token]) -> Any:  # noqa: ANN401 - whatever the option takes
    """Reads words as cyclopts does, but for fractions where a whole number is taken, which it would round.

    Args:
        kind: What the option takes.
        tokens: Its words.

    Raises:
        ValueError: With what is wrong, in one line; cyclopts reports it.
    """
    for token in tokens if kind is int else ():
        if "." in token.value and not _is_whole(token.value):
            msg = f"{token.value} is not allowed: must be a whole number"
            raise ValueError(msg)
    return convert(kind, tokens)


def _is_whole(text: str) -> bool:
    try:
        return float(text).is_integer()
    except ValueError:
        return False
