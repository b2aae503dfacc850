"""A file is known by its whole path and its content: never by a relative name and a time."""

import os
import shutil
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image

from magicsim.config.named_files import file_hashes
from magicsim.geometry.face_shape import HeightMap
from magicsim.geometry.files.mesh_file import load_mesh
from magicsim.scenes.room import room_radiance

TIME_NS = 1_700_000_000_000_000_000


def timed(path: Path) -> Path:
    os.utime(path, ns=(TIME_NS, TIME_NS))
    return path


def ball(path: Path, radius_mm: float) -> Path:
    trimesh.creation.icosphere(subdivisions=1, radius=radius_mm).export(path)
    return timed(path)


def width_mm(name: str) -> float:
    return float(np.ptp(load_mesh(name).surface.vertices[:, 0]))


def heights(path: Path, rise_mm: float) -> Path:
    np.save(path, np.linspace(0, rise_mm, 16).reshape(4, 4))
    return timed(path)


def rise_mm(name: str) -> float:
    face = HeightMap(kind="height_map", file=name, footprint_mm=(10, 10))
    return float(np.ptp(face.rise_mm(np.array([[-5.0, 5.0], [5.0, -5.0]]))))


def room(path: Path, grey: int) -> Path:
    pixels = np.full((8, 16, 3), 100, np.uint8)
    pixels[:4] = grey
    Image.fromarray(pixels).save(path, format="BMP" if path.suffix == ".bmp" else None, compress_level=0)
    return timed(path)


def contrast(name: str) -> float:
    radiance = room_radiance(name)
    return float(radiance[0].mean() / radiance[-1].mean())


KINDS = {
    "tip.stl": (ball, width_mm, (1.0, 3.0)),
    "face.npy": (heights, rise_mm, (0.5, 1.0)),
    "room.png": (room, contrast, (50, 200)),
}


@pytest.mark.parametrize("name", KINDS)
def test_same_name_time_and_size_in_two_folders_are_two_files(
    name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
):
    write, read, values = KINDS[name]
    found = []
    for number, value in enumerate(values):
        folder = tmp_path / str(number)
        folder.mkdir()
        monkeypatch.chdir(write(folder / name, value).parent)
        found.append(read(name))
    one, other = (tmp_path / folder / name for folder in "01")
    assert (one.stat().st_size, one.stat().st_mtime_ns) == (other.stat().st_size, other.stat().st_mtime_ns)
    assert found[1] > 1.5 * found[0]


@pytest.mark.parametrize("name", KINDS)
def test_copy_with_the_time_of_its_source_is_another_file(name: str, tmp_path: Path):
    write, read, values = KINDS[name]
    there = write(tmp_path / name, values[0])
    before = read(str(there))
    (tmp_path / "new").mkdir()
    shutil.copy2(write(tmp_path / "new" / name, values[1]), there)
    assert there.stat().st_mtime_ns == TIME_NS
    assert read(str(there)) > 1.5 * before


@pytest.mark.parametrize(
    ("materials", "texture", "name"),
    [
        ("mtllib a.mtl", "map_Kd b b.png", "b b.png"),
        ("   mtllib a.mtl", "MAP_KD skin.png", "skin.png"),
        ("\tmtllib a.mtl  ", "\tMap_Kd skin.png  ", "skin.png"),
        ("mtllib \\\na.mtl", "map_Kd -s 1 1 1 skin.png", "skin.png"),
        ("# written with mtllib a.mtl", "bump -bm 0.2 skin.png", "skin.png"),
        ("mtllib /elsewhere/a.mtl", "map_Kd textures/skin.png", "skin.png"),
    ],
)
def test_every_file_that_the_reader_of_an_obj_opens_counts(materials: str, texture: str, name: str, tmp_path: Path):
    (tmp_path / "a.obj").write_text(f"{materials}\nv 0 0 0\n")
    (tmp_path / "a.mtl").write_text(f"newmtl x\n{texture}\n")
    (tmp_path / name).write_text("picture")
    data = {"kind": "mesh", "path": str(tmp_path / "a.obj")}
    before = file_hashes(data)
    assert {Path(each).name for each in before} == {"a.obj", "a.mtl", name}
    (tmp_path / name).write_text("another")
    assert file_hashes(data) != before


def test_pictures_of_ply_and_glb_count(tmp_path: Path):
    (tmp_path / "a.ply").write_bytes(b"ply\nformat ascii 1.0\ncomment TextureFile my skin.png\nend_header\n")
    (tmp_path / "a.glb").write_bytes(b'glTF{"images":[{"uri": "wood.png"}, {"uri":"data:image/png;base64,AA"}]}')
    for name in ("my skin.png", "wood.png"):
        (tmp_path / name).write_text("picture")
    found = file_hashes([{"kind": "mesh", "path": str(tmp_path / name)} for name in ("a.ply", "a.glb")])
    assert {Path(each).name for each in found} == {"a.ply", "a.glb", "my skin.png", "wood.png"}
