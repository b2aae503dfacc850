"""Files that a TOML file names: a relative path starts in the folder of the file that it stands in.

What is not there is looked for from the current folder, as paths on the command line are.
"""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from magicsim.config.documents import read_toml
from magicsim.config.presets import expanded, is_file, is_folder

FILE_KEYS = {"mesh": ("path", "folder"), "picture": ("file",), "height_map": ("file",)}
"""Keys that name a file or a folder, by the `kind` of their table: objects, markers, faces."""
ROOM_SUFFIXES = (".png", ".jpg", ".jpeg")
"""What tells that a `room` is a file."""


def read_with_paths(path: Path) -> dict[str, Any]:
    """Content of a TOML file, the files that it names found beside it.

    Raises:
        ConfigError: The file cannot be read, see `read_toml`.
    """
    found: dict[str, Any] = _placed(read_toml(path), path.parent)
    return found


def _placed(value: object, folder: Path) -> Any:  # noqa: ANN401 - whatever the file holds
    if isinstance(value, list):
        return [_placed(each, folder) for each in value]
    if not isinstance(value, Mapping):
        return value
    table = {key: _placed(each, folder) for key, each in value.items()}
    keys = [*FILE_KEYS.get(str(table.get("kind")), ())]
    if is_picture(table.get("room")):
        keys.append("room")
    if isinstance(table.get("rooms"), list):
        table["rooms"] = [_beside(each, folder) if is_picture(each) else each for each in table["rooms"]]
    return table | {key: _beside(table[key], folder) for key in keys if isinstance(table.get(key), str)}


def is_picture(room: object) -> bool:
    """Whether a room is a file of the user's, no name."""
    return isinstance(room, str) and room.lower().endswith(ROOM_SUFFIXES)


def _beside(name: str, folder: Path) -> str:
    """The path from the current folder, where it is below that, or else the whole one; unchanged where nothing is."""
    path = expanded(name)
    there = folder / path
    if path.is_absolute() or not (is_file(there) or is_folder(there)):
        return name
    whole = Path(os.path.abspath(there))
    here = Path.cwd()
    return whole.relative_to(here).as_posix() if whole.is_relative_to(here) else str(whole)
