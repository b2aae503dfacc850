"""Finds the versioned input files (designs, scenes, rigs, detector profiles) by name or by path.

The wheel carries them in `magicsim/_presets/`; a checkout has them at its top level.
"""

from pathlib import Path

from magicsim.errors import PresetError, unknown_choice
from magicsim.wording import NAME_LENGTH, shortened

FOLDERS = {
    "design": "geometry",
    "object": "geometry/objects",
    "scene": "scenes",
    "rig": "scenes/rigs",
    "recipe": "scenes/recipes",
    "profile": "detectors",
    "suite": "detectors/suites",
    "sweep": "geometry/sweeps",
    "study": "scenes/studies",
    "item": "scenes/items",
}
"""Folder of each kind of preset, below the packaged copy or the checkout."""

PATHS_START = "paths start beside the TOML file, or in the current folder"
"""What is said where a file that a TOML file names is not there."""
_PACKAGE = Path(__file__).resolve().parents[1]


def preset_root() -> Path:
    """Folder that holds `geometry/`, `scenes/` and `detectors/`: packaged copy first, then the checkout."""
    packaged = _PACKAGE / "_presets"
    return packaged if packaged.is_dir() else _PACKAGE.parent


def preset_names(kind: str) -> list[str]:
    """Names of the shipped presets of one kind (a key of `FOLDERS`), sorted."""
    return sorted(path.stem for path in (preset_root() / FOLDERS[kind]).glob("*.toml"))


def find_preset(kind: str, name: str | Path) -> Path:
    """Path of a preset by name, or of the user's own file by path.

    Args:
        kind: A key of `FOLDERS`.
        name: A shipped name such as `mini-magictac`, or a path to a TOML file.

    Raises:
        PresetError: Neither a shipped name nor a readable file.
    """
    text = str(name)
    if text.endswith(".toml") or "/" in text or "\\" in text:
        path = expanded(text)
        if not is_file(path):
            msg = (
                f"{kind} file '{shortened(text, 2 * NAME_LENGTH)}' does not exist; give a TOML file or one of: "
                f"{', '.join(preset_names(kind))}"
            )
            raise PresetError(msg)
        return path
    if text not in preset_names(kind):
        raise PresetError(unknown_choice(kind, text, preset_names(kind)))
    return preset_root() / FOLDERS[kind] / f"{text}.toml"


def is_file(path: Path) -> bool:
    """Whether there is such a file; not where the name is none, is too long or leads through links in a circle."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def is_folder(path: Path) -> bool:
    """Whether there is such a folder; not where the name is none, is too long or leads through links in a circle."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def expanded(path: str | Path) -> Path:
    """The path with `~` replaced by the home folder, where there is one."""
    try:
        return Path(path).expanduser()
    except RuntimeError:  # no such user
        return Path(path)
