"""Finds the versioned input files (designs, scenes, rigs, detector profiles) by name or by path, and lists them.

The wheel carries them in `magicsim/_presets/`; a checkout has them at its top level. Other distributions add
commands, schemas, presets and kinds of presets by their entry points.
"""

import os
import re
import textwrap
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path

from magicsim.errors import NAME_LENGTH, PresetError, shortened, unknown_choice

COMMANDS, PRESETS, SCHEMAS = "magicsim.commands", "magicsim.presets", "magicsim.schemas"
"""Groups of entry points: a function or an `App` for each command, a folder (`pathlib.Path`) for each kind of preset,
and a function that returns a JSON Schema for each kind of file."""
EXPERIMENTS = frozenset({"study", "studies", "item", "items", "estimate", "task"})
"""Words that `magicsim-experiments` adds."""


@cache
def extensions(group: str) -> dict[str, EntryPoint]:
    """What other distributions add to a group, by name."""
    return {point.name: point for point in entry_points(group=group)}


def missing_experiments(word: str) -> str:
    """The line about a word of `EXPERIMENTS` where `magicsim-experiments` is not installed."""
    return f"'{word}' comes with magicsim-experiments, which is not installed: pip install ./benchmarks/experiments"


FOLDERS = {
    "design": "geometry",
    "object": "geometry/objects",
    "scene": "scenes",
    "rig": "scenes/rigs",
    "recipe": "scenes/recipes",
    "profile": "detectors",
    "suite": "detectors/suites",
    "sweep": "geometry/sweeps",
}
"""Folder of each kind of preset, below the packaged copy or the checkout."""

PATHS_START = "paths start beside the TOML file, or in the current folder"
"""What is said where a file that a TOML file names is not there."""
_PACKAGE = Path(__file__).resolve().parents[1]


def preset_root() -> Path:
    """Folder that holds `geometry/`, `scenes/` and `detectors/`: packaged copy first, then the checkout."""
    packaged = _PACKAGE / "_presets"
    return packaged if packaged.is_dir() else _PACKAGE.parent


def preset_kinds() -> list[str]:
    """Kinds of presets: the keys of `FOLDERS`, then those that other distributions add."""
    return list(dict.fromkeys([*FOLDERS, *extensions(PRESETS)]))


def preset_names(kind: str) -> list[str]:
    """Names of the presets of one kind (one of `preset_kinds`), sorted."""
    return sorted(_files(kind))


def _files(kind: str) -> dict[str, Path]:
    folders: list[Path] = [extensions(PRESETS)[kind].load()] if kind in extensions(PRESETS) else []
    folders += [preset_root() / FOLDERS[kind]] if kind in FOLDERS else []
    if not folders and kind in EXPERIMENTS:
        raise PresetError(missing_experiments(kind))
    return {path.stem: path for folder in folders for path in folder.glob("*.toml")}


def find_preset(kind: str, name: str | Path) -> Path:
    """Path of a preset by its kind and shipped name, or of the user's own file by path; else a `PresetError`."""
    text = str(name)
    if text.endswith(".toml") or "/" in text or "\\" in text:
        path = expanded(text)
        if not is_file(path):
            raise PresetError(
                f"{kind} file '{shortened(text, 2 * NAME_LENGTH)}' does not exist; give a TOML file or one of: "
                f"{', '.join(preset_names(kind))}"
            )
        return path
    files = _files(kind)
    if text not in files:
        raise PresetError(unknown_choice(kind, text, sorted(files)))
    return files[text]


def is_file(path: Path) -> bool:
    """Whether there is such a file; not where the name is none, is too long or leads through links in a circle."""
    return os.path.isfile(path)


def is_folder(path: Path) -> bool:
    """Whether there is such a folder; not where the name is none, is too long or leads through links in a circle."""
    return os.path.isdir(path)


def expanded(path: str | Path) -> Path:
    """The path with `~` replaced by the home folder, where there is one."""
    return Path(os.path.expanduser(path))


_SENTENCE_END = re.compile(r"(?<=[.!?])\s+(?=[A-Z0-9])")
LONG = 110
"""Longest account of a preset [characters]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Entry:
    """One preset."""

    kind: str
    """One of `preset_kinds`."""
    name: str
    """What commands and files call it."""
    description: str
    """First sentence of the comment at the top of its file."""
    file: str
    """Where it is, to be copied and changed."""


def plurals() -> dict[str, str]:
    """Kinds of presets by the word for many of them."""
    return {f"{kind[:-1]}ies" if kind.endswith("y") else f"{kind}s": kind for kind in preset_kinds()}


def entries(plural: str) -> list[Entry]:
    """The presets of one kind, a key of `plurals()`, sorted by name; `PresetError` for another."""
    kinds = plurals()
    if plural not in kinds:
        is_added = plural in EXPERIMENTS
        raise PresetError(missing_experiments(plural) if is_added else unknown_choice("kind of preset", plural, kinds))
    kind = kinds[plural]
    paths = {name: find_preset(kind, name) for name in preset_names(kind)}
    return [
        Entry(kind=kind, name=name, description=first_sentence(path), file=str(path)) for name, path in paths.items()
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
