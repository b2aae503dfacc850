"""Finds the versioned input files (designs, scenes, rigs, detector profiles) by name or by path.

The wheel carries them in `magicsim/_presets/`; a checkout has them at its top level.
"""

from pathlib import Path

from magicsim.errors import PresetError, unknown_choice

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

_PACKAGE = Path(__file__).resolve().parent


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
        path = Path(text).expanduser()
        if not path.is_file():
            msg = f"{kind} file '{text}' does not exist; give a TOML file or one of: {', '.join(preset_names(kind))}"
            raise PresetError(msg)
        return path
    path = preset_root() / FOLDERS[kind] / f"{text}.toml"
    if not path.is_file():
        raise PresetError(unknown_choice(kind, text, preset_names(kind)))
    return path
