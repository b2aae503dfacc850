"""What comes with the program, by kind: the name of each preset and what its file says it is."""

import re
import textwrap
from dataclasses import dataclass
from pathlib import Path

from magicsim.config.presets import FOLDERS, find_preset, preset_names
from magicsim.errors import PresetError, unknown_choice

PLURALS = {f"{kind[:-1]}ies" if kind.endswith("y") else f"{kind}s": kind for kind in FOLDERS}
"""Kinds of presets as people name many of them."""
_SENTENCE_END = re.compile(r"(?<=[.!?])\s+(?=[A-Z0-9])")
LONG = 110
"""Longest account of a preset [characters]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One preset."""

    kind: str
    """A key of `magicsim.config.presets.FOLDERS`."""
    name: str
    """What commands and files call it."""
    description: str
    """First sentence of the comment at the top of its file."""
    file: str
    """Where it is, to be copied and changed."""


def entries(plural: str) -> list[Entry]:
    """The presets of one kind, sorted by name.

    Args:
        plural: A key of `PLURALS`, such as `designs`.

    Raises:
        PresetError: No such kind.
    """
    if plural not in PLURALS:
        raise PresetError(unknown_choice("kind of preset", plural, PLURALS))
    kind = PLURALS[plural]
    found = {name: find_preset(kind, name) for name in preset_names(kind)}
    return [
        Entry(kind=kind, name=name, description=first_sentence(path), file=str(path)) for name, path in found.items()
    ]


def first_sentence(path: Path) -> str:
    """The sentence that begins the comment at the top of a TOML file, at most `LONG` characters; empty without one."""
    lines = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.startswith("#"):
            break
        lines.append(line.lstrip("# ").rstrip())
    sentence = _SENTENCE_END.split(" ".join(lines), maxsplit=1)[0].rstrip(".")
    return textwrap.shorten(sentence, LONG, placeholder=" ...")
