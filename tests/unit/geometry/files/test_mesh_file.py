import os
from pathlib import Path

import numpy as np
import pytest
import trimesh

from magicsim.errors import ConfigError
from magicsim.geometry.files import mesh_file
from magicsim.geometry.files.mesh_file import load_mesh
from magicsim.geometry.objects.kinds import parse_object
from magicsim.geometry.shapes.entry import EntrySide


def written(folder: Path, mesh: trimesh.Trimesh, name: str = "part.stl") -> str:
    mesh.export(folder / name)
    return str(folder / name)


@pytest.mark.parametrize("suffix", mesh_file.SUFFIXES)
def test_every_format_gives_the_same_solid(tmp_path: Path, suffix: str):
    box = trimesh.creation.box((2.0, 3.0, 4.0))
    box.apply_translation((0.5, 0.0, 0.0))
    shape = load_mesh(written(tmp_path, box, f"part{suffix}"))
    assert shape.surface.is_watertight()
    assert shape.surface.volume_mm3() == pytest.approx(24.0)
    assert shape.support_mm(np.array([1.0, 0.0, 0.0])) == pytest.approx(1.5)
    assert shape.feature_mm == pytest.approx(1.0)


def test_object_of_kind_mesh_is_scaled_and_has_its_side_of_entry(tmp_path: Path):
    path = written(tmp_path, trimesh.creation.icosphere(radius=0.1))
    shape = parse_object(f"mesh:path={path},scale=25.4,feature_mm=0.4").shape()
    assert isinstance(shape, EntrySide)
    assert shape.support_mm(np.array([0.0, 0.0, 1.0])) == pytest.approx(2.54)
    assert shape.feature_mm == 0.4
    assert shape.shell_mm == 0.05


def test_path_is_relative_to_the_current_directory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    written(tmp_path, trimesh.creation.icosphere())
    monkeypatch.chdir(tmp_path)
    assert load_mesh("part.stl").surface.volume_mm3() > 4


def test_mesh_that_is_inside_out_is_turned(tmp_path: Path):
    ball = trimesh.creation.icosphere()
    ball.invert()
    shape = load_mesh(written(tmp_path, ball))
    assert shape.surface.volume_mm3() > 0
    assert shape.distance(np.zeros((1, 3)))[0][0] < -0.9


def test_file_is_read_once_until_it_changes(tmp_path: Path):
    path = written(tmp_path, trimesh.creation.icosphere(radius=1.0))
    first = load_mesh(path)
    assert load_mesh(path) is first
    written(tmp_path, trimesh.creation.icosphere(radius=2.0))
    os.utime(path, ns=(0, 1))
    assert load_mesh(path).support_mm(np.array([0.0, 0.0, 1.0])) == pytest.approx(2.0)


def without_one_triangle() -> trimesh.Trimesh:
    ball = trimesh.creation.icosphere()
    return trimesh.Trimesh(ball.vertices, ball.faces[1:], process=False)


@pytest.mark.parametrize(
    ("mesh", "named"),
    [
        (without_one_triangle(), "is not watertight"),
        (
            trimesh.creation.icosphere(radius=500),
            "measures 1000 x 1000 x 1000 mm: must be 0.01 to 200 mm; change scale",
        ),
        (trimesh.creation.icosphere(radius=0.001), "must be 0.01 to 200 mm; change scale"),
    ],
)
def test_mesh_that_cannot_press_is_refused_in_one_line(tmp_path: Path, mesh: trimesh.Trimesh, named: str):
    path = written(tmp_path, mesh)
    with pytest.raises(ConfigError) as caught:
        load_mesh(path)
    assert str(caught.value).startswith(f"mesh '{path}'")
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_too_many_triangles_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(mesh_file, "MAX_TRIANGLES", 100)
    path = written(tmp_path, trimesh.creation.icosphere(subdivisions=2))
    with pytest.raises(ConfigError, match="has 320 triangles: at most 100 are allowed"):
        load_mesh(path)


@pytest.mark.parametrize(
    ("name", "content", "named"),
    [
        ("part.step", b"", "must end in .stl, .obj, .ply or .glb"),
        ("part.stl", b"", "mesh '"),
        ("part.stl", b"solid nothing\nendsolid nothing\n", "mesh '"),
        ("part.obj", b"", "mesh '"),
        ("part.obj", b"v 0 0 0\nv 1 0 0\n", "mesh '"),
        ("part.ply", b"not a ply file", "cannot be read"),
        ("part.glb", b"\x00\x01", "cannot be read"),
    ],
)
def test_file_that_holds_no_mesh_is_refused_in_one_line(tmp_path: Path, name: str, content: bytes, named: str):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ConfigError) as caught:
        load_mesh(str(path))
    assert named in str(caught.value)
    assert "\n" not in str(caught.value)


def test_empty_path_is_refused():
    with pytest.raises(ConfigError, match="mesh '' is not allowed: must end in"):
        load_mesh("")


def test_missing_file_and_folder_are_refused(tmp_path: Path):
    (tmp_path / "folder.stl").mkdir()
    for name in ("missing.stl", "folder.stl"):
        with pytest.raises(
            ConfigError, match=r"does not exist \(paths start beside the TOML file, or in the current folder\)"
        ):
            load_mesh(str(tmp_path / name))
