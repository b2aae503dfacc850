"""Files that a configuration names: where they are looked for, and their content as a part of its hash.

A relative path starts in the folder of the TOML file that it stands in; what is not there is looked for from the
current folder, as paths on the command line are. A file may be replaced by another of its name: what was made with the
first is not what the second makes.
"""

import hashlib
import json
import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import AfterValidator

from magicsim.config.documents import read_toml
from magicsim.config.presets import expanded, is_file, is_folder
from magicsim.errors import ConfigError
from magicsim.folder.listing import sha256_of

FILE_KEYS = {"mesh": ("path", "folder"), "picture": ("file",), "height_map": ("file",)}
"""Keys that name a file or a folder, by the `kind` of their table: objects, markers, faces."""
ROOM_SUFFIXES = (".png", ".jpg", ".jpeg")
"""What tells that a `room` is a file."""
MODEL_SUFFIX = ".touch"
"""What tells that a text names a model of touches (`render.model`)."""
FileName = Annotated[str, AfterValidator(os.path.expanduser)]
"""A file of the user's in a model, `~` replaced by the home folder."""


def read_with_paths(path: Path) -> dict[str, Any]:
    """Content of a TOML file, the files that it names found beside it; errors as of `read_toml`."""
    table: dict[str, Any] = _placed(read_toml(path), path.parent)
    return table


def _placed(value: object, folder: Path) -> Any:  # noqa: ANN401 - whatever the file holds
    if isinstance(value, list):
        return [_placed(each, folder) for each in value]
    if not isinstance(value, Mapping):
        return value
    table = {key: _placed(each, folder) for key, each in value.items()}
    keys = [*FILE_KEYS.get(str(table.get("kind")), ())]
    if is_picture(table.get("room")):
        keys.append("room")
    if str(table.get("model")).lower().endswith(MODEL_SUFFIX):
        keys.append("model")
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


MESH_SUFFIXES = (".stl", ".obj", ".ply", ".off", ".glb")
"""What tells that a file is a mesh."""
HEADER = 1 << 16
"""Bytes of a PLY file in which its header ends."""
CONTENT = "content of files"
"""Key of the hashes in what is hashed; no model has a field with blanks."""
MATERIALS = re.compile(rb"mtllib([^\r\n]+)", re.IGNORECASE)
TEXTURE = re.compile(rb"(?:^|[\r\n])[ \t]*(?:map_\w+|bump|disp|decal|norm|refl)[ \t]([^\r\n]+)", re.IGNORECASE)
"""What an OBJ file and its materials name (Wavefront's formats), options before the name, wherever one may look."""
PLY_TEXTURE = re.compile(rb"comment[ \t]+TextureFile[ \t]+([^\r\n]+)", re.IGNORECASE)
GLB_NAME = re.compile(rb'"uri"[ \t\r\n]*:[ \t\r\n]*"((?!data:)[^"\\]{1,1000})"')
JOINED = re.compile(rb"\\\r?\n")
"""A backslash at the end of a line of an OBJ file goes on in the next one."""


def config_digest(data: Mapping[str, Any]) -> str:
    """SHA-256 of a configuration as plain values and of the content of every file that it names.

    Without such files it is that of its JSON alone, keys sorted.
    """
    hashes = file_hashes(data)
    content = {**data, CONTENT: hashes} if hashes else data
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def file_hashes(data: object) -> dict[str, str]:
    """SHA-256 of the files that a configuration names and that are there, by name; a folder stands for its meshes.

    A TOML file brings those that it names in its turn, a mesh its materials and pictures.
    """
    hashes: dict[str, str] = {}
    waiting = sorted(named_files(data))
    while waiting:
        for file in _files_at(expanded(waiting.pop())):
            if file.as_posix() not in hashes:
                hashes[file.as_posix()] = sha256_of(file)
                waiting += sorted(_named_by_toml(file))
    return hashes


def named_files(data: object) -> set[str]:
    """Names of files and folders in a configuration: meshes, pictures, height maps, rooms, and TOML files in place.

    Rooms that come with the program are no files of the user's.
    """
    return set(_names(data))


def _names(value: object) -> Iterator[str]:
    if isinstance(value, str):
        if value.lower().endswith((".toml", MODEL_SUFFIX)):
            yield value
    elif isinstance(value, Mapping):
        keys = FILE_KEYS.get(str(value.get("kind")), ())
        rooms = value.get("rooms")
        yield from (value[key] for key in keys if isinstance(value.get(key), str))
        yield from filter(is_picture, [value.get("room"), *(rooms if isinstance(rooms, list | tuple) else ())])
        for each in value.values():
            yield from _names(each)
    elif isinstance(value, list | tuple):
        for each in value:
            yield from _names(each)


def _files_at(path: Path) -> Iterator[Path]:
    """A file, or the meshes of a folder, each with the materials and pictures that it names."""
    folder = path.iterdir() if is_folder(path) else ()
    files = sorted(each for each in folder if each.suffix.lower() in MESH_SUFFIXES) or [path]
    for each in filter(is_file, files):
        yield each
        yield from _named_by_mesh(each)


def _named_by_mesh(path: Path) -> Iterator[Path]:
    """Files beside a mesh that its reader may open: rather one too many than one too few."""
    match path.suffix.lower():
        case ".obj":
            for library in _beside_mesh(path, MATERIALS.findall(JOINED.sub(b"", path.read_bytes()))):
                yield library
                yield from _beside_mesh(path, TEXTURE.findall(library.read_bytes()))
        case ".ply":
            yield from _beside_mesh(path, PLY_TEXTURE.findall(path.read_bytes()[:HEADER]))
        case ".glb":
            yield from _beside_mesh(path, GLB_NAME.findall(path.read_bytes()))


def _beside_mesh(mesh: Path, ends: list[bytes]) -> list[Path]:
    """Files of the mesh's folder that the ends of lines may name: all of an end, or its last word."""
    found: dict[Path, None] = {}
    for end in dict.fromkeys(ends):
        text = end.decode(errors="replace").strip()
        for name in (text, text.lstrip("/"), os.path.split(text)[-1], *text.split()[-1:]):
            path = mesh.parent / name
            if name and path != mesh and is_file(path):
                found[path] = None
    return list(found)


def _named_by_toml(file: Path) -> set[str]:
    """Names in a TOML file; none of another file, or of one that cannot be read, which its reader tells."""
    if file.suffix.lower() != ".toml":
        return set()
    try:
        return named_files(read_with_paths(file))
    except ConfigError:
        return set()
