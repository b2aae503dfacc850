"""Files that a scene names and does not hold: their content may change under the same name."""

from pathlib import Path

from magicsim.folder.hashing import sha256_of
from magicsim.scenes.rig import DARK
from magicsim.scenes.room import room_file
from magicsim.scenes.scene import SceneConfig


def named_files(scene: SceneConfig) -> dict[str, Path]:
    """The image of the room, the mesh of the object, the height map and the print on the face, where there are such.

    Returns:
        Each file by the setting that names it.

    Raises:
        ConfigError: There is no such room.
    """
    room, design = scene.rig.room, scene.design
    named = {
        "object.path": getattr(scene.object, "path", None),
        "design.face.file": getattr(design.face, "file", None),
        "design.markers.file": getattr(design.markers, "file", None),
    }
    found = {setting: Path(name) for setting, name in named.items() if name is not None}
    return found | ({"rig.room": room_file(room)} if room not in (None, DARK) else {})


def file_hashes(scene: SceneConfig) -> dict[str, str]:
    """SHA-256 of the content of each of the files, by the setting that names it.

    Raises:
        ConfigError: There is no such room.
        OSError: A file cannot be read.
    """
    return {setting: sha256_of(path) for setting, path in sorted(named_files(scene).items())}
