import os
import struct
from pathlib import Path

import pytest
import trimesh

from magicsim.errors import ConfigError
from magicsim.geometry.files.mesh_file import header_problem, load_mesh


def glb(tree: bytes, *, length: int | None = None) -> bytes:
    whole = 20 + len(tree)
    return b"glTF" + struct.pack("<III", 2, whole if length is None else length, len(tree)) + b"JSON" + tree


@pytest.mark.parametrize(
    ("name", "content", "named"),
    [
        ("cut.stl", bytes(80) + struct.pack("<I", 320) + bytes(100), "a binary one of the 320 triangles"),
        ("many.stl", bytes(80) + struct.pack("<I", 2**32 - 1) + bytes(100), "this one has 184"),
        ("none.stl", bytes(84), "has no triangles"),
        ("latin.stl", b"solid caf\xe9\nfacet\0", "bytes that are no text"),
        ("noise.stl", b"\xff\xfe", "neither a binary nor a text STL"),
        ("many.obj", b"v 0 0 0\n" + b"f 1 1 1\n" * 500_001, "has more triangles than the 500000"),
        ("bytes.obj", b"v 0 0 0\0", "no text"),
        ("many.ply", b"ply\nelement vertex 4\nelement face 999999999\nend_header\n", "more than its"),
        ("vertices.ply", b"ply\nelement vertex 99999999\nelement face 4\nend_header\n", "has 99999999 vertices"),
        ("head.ply", b"plyx", "does not begin with a PLY header"),
        ("cut.glb", glb(b"{}", length=900), "its header promises 900 bytes"),
        ("many.glb", glb(b'{"accessors":[{"count":9000000000}]}'), "9000000000 values of one kind"),
        ("deep.glb", glb(b"[" * 9000 + b"]" * 9000), "nested too deeply"),
        ("odd.glb", glb(b"[]"), "no glTF"),
        ("empty.stl", b"", "is empty"),
    ],
)
def test_header_that_cannot_be_kept_is_refused_with_the_name_of_the_file(
    tmp_path: Path, name: str, content: bytes, named: str
):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ConfigError) as caught:
        load_mesh(str(path))
    assert str(caught.value).startswith(f"mesh '{path}'")
    assert named in str(caught.value)
    assert "charset" not in str(caught.value)


@pytest.mark.parametrize("name", ["large.stl", "large.obj", "large.ply", "large.glb"])
def test_large_file_is_refused_unread(tmp_path: Path, name: str):
    path = tmp_path / name
    path.touch()
    os.truncate(path, 1_000_000_084)
    assert header_problem(path) == "has 1000 MB: at most 200 MB are allowed"


@pytest.mark.parametrize("kind", ["stl", "stl_ascii", "ply", "obj", "glb"])
def test_whole_file_has_no_problem(tmp_path: Path, kind: str):
    path = tmp_path / f"ball.{kind.partition('_')[0]}"
    trimesh.creation.icosphere().export(path, file_type=kind)
    assert header_problem(path) is None


def test_path_with_a_null_byte_is_a_file_that_does_not_exist():
    with pytest.raises(ConfigError, match=r"mesh 'a\\x00b\.stl' does not exist"):
        load_mesh("a\0b.stl")
