"""The one `App` of the command line, the options that every command shares, and how a result is printed.

For people a result is lines: one a value, and a table for a list of alike things.
"""

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import App, Parameter, Token, convert

import magicsim
from magicsim.errors import ConfigError, visible

WIDE = 3
"""Keys of a thing above which a list of such things becomes a table with a head."""


def lines_of(values: Mapping[str, Any]) -> Iterator[str]:
    """Lines of a result."""
    for key, value in values.items():
        if isinstance(value, (list, tuple)) and value and all(isinstance(each, dict) for each in value):
            yield f"{key}:"
            yield from ("  " + line for line in _rows(value))
        else:
            yield f"{key}: {_cell(value)}"


def _rows(things: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    head = list(things[0])
    if len(head) <= WIDE or any(list(each) != head for each in things):
        return (": ".join(_cell(part) for part in each.values()) for each in things)
    table = [head, *([_cell(each[key]) for key in head] for each in things)]
    widths = [max(len(row[column]) for row in table) for column in range(len(head))]
    return ("  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in table)


def _cell(value: object) -> str:
    match value:
        case None:
            return "-"
        case bool():
            return "yes" if value else "no"
        case float():
            return f"{value:.6g}"
        case dict():
            return ", ".join(f"{key} {_cell(each)}" for key, each in value.items()) or "none"
        case list() | tuple():
            return (
                ", ".join(f"({_cell(each)})" if isinstance(each, (list, tuple)) else _cell(each) for each in value)
                or "none"
            )
        case _:
            return visible(str(value))


def read_words(kind: type[Any], tokens: Sequence[Token]) -> Any:  # noqa: ANN401 - whatever the option takes
    """Reads words as cyclopts does, but for fractions where a whole number is taken, which it would round.

    `ValueError` with what is wrong, in one line, which cyclopts reports.
    """
    for token in tokens if kind is int else ():
        if "." in token.value and not _is_whole(token.value):
            raise ValueError(f"{token.value} is not allowed: must be a whole number")
    return convert(kind, tokens)


def _is_whole(text: str) -> bool:
    try:
        return float(text).is_integer()
    except ValueError:
        return False


app = App(
    name="magicsim",
    version=magicsim.__version__,
    help="Simulator of the mini-MagicTac see-through touch sensor. Every command takes --variant too: llvm_ad_rgb,\n"
    "cuda_ad_rgb (an NVIDIA GPU) or scalar_rgb."
    + ("" if __doc__ else "\n\nWithout descriptions, which Python leaves out where it runs with -OO."),
    suppress_keyboard_interrupt=False,
    default_parameter=Parameter(converter=read_words),
)

MAX_THREADS = 1024

Json = Annotated[bool, Parameter(name="--json", negative="", help="Print one JSON object on stdout.")]
Settings = Annotated[
    list[str] | None,
    Parameter(name="--set", negative="", help="Override a setting: dotted.key=value; repeatable."),
]
Seed = Annotated[int | None, Parameter(name="--seed", help="Seed of everything random.")]
"""Every command takes it, also those in which nothing is random."""
Threads = Annotated[
    int | None, Parameter(name="--threads", help="Rendering threads; the result does not depend on it.")
]
Tier = Annotated[
    Literal["true", "fast"] | None,
    Parameter(name="--tier", help="fast: pictures of touches by a distilled model; sets render.tier."),
]
Out = Annotated[Path, Parameter(name="--out", help="Where the result goes.")]


def limit_threads(threads: int | None) -> None:
    """Bounds the threads of the renderer; None leaves them alone."""
    if threads is None:
        return
    if not 1 <= threads <= MAX_THREADS:
        raise ConfigError(f"threads = {threads} is not allowed: must be 1 to {MAX_THREADS}")
    from magicsim.light.backend import dr

    dr.set_thread_count(threads)


def with_tier(settings: list[str] | None, tier: str | None) -> list[str]:
    """Settings, with the tier among them where one is asked for."""
    return [*(settings or []), *([f"render.tier={tier}"] if tier is not None else [])]


def refuse_settings(settings: list[str] | None, command: str, why: str = "") -> None:
    """Refuses (`ConfigError`) `--set` with a command in which there is nothing to set."""
    if settings:
        raise ConfigError(f"--set {settings[0]} is not allowed with {command}{why}")


def fields_of(result: object) -> dict[str, Any]:
    """A result as the keys and values that are printed."""
    return asdict(result)  # type: ignore[call-overload, no-any-return]


def print_object(values: dict[str, Any], *, on_one_line: bool) -> None:
    """Writes a JSON object."""
    sys.stdout.write(json.dumps(values, allow_nan=False, indent=None if on_one_line else 2) + "\n")


def print_result(result: object, *, as_json: bool) -> None:
    """Writes a result, a dictionary or a data class, as one JSON object, or as lines for people."""
    values = result if isinstance(result, dict) else fields_of(result)
    if as_json:
        print_object(values, on_one_line=True)
        return
    sys.stdout.writelines(f"{line}\n" for line in lines_of(values))
