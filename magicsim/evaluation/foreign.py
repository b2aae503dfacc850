"""Calls of code that somebody else wrote."""

import traceback
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from magicsim.errors import ConfigError, MagicsimError

Returned = TypeVar("Returned")


def tried(call: Callable[[], Returned], problem: str) -> Returned:
    """What a call of somebody else's code returns.

    Raises:
        MagicsimError: As the call raised it.
        ConfigError: Instead of whatever else the call raises, also where it ends the program: the problem, what was
            said, and the line that said it.
    """
    try:
        return call()
    except MagicsimError:
        raise
    except (Exception, SystemExit) as error:
        said = " ".join(f"{type(error).__name__}: {error}".split()).removesuffix(":")
        raise ConfigError(f"{problem}: {said}{_place(error)}") from error


def _place(error: BaseException) -> str:
    """Where an error was raised, if not in the call itself."""
    frames = traceback.extract_tb(error.__traceback__)[2:]
    return f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno})" if frames else ""
