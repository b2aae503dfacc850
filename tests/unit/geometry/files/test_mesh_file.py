import logging
import os
import struct
from pathlib import Path

import numpy as np
import pytest
import trimesh

from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import press
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign, load_design
from magicsim.geometry.files import mesh_file
from magicsim.geometry.files.export import TO_VIEWER, export_design
from magicsim.geometry.files.mesh_file import crossing_edges, inside_out_parts, load_mesh
from magicsim.geometry.indenter import place_object
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.kinds import parse_object
from magicsim.geometry.shapes.entry import EntrySide


def written(folder: Path, mesh: trimesh.Trimesh, name: str = "part.stl") -> str:
    mesh.export(folder / name)
    return str(folder / name)


@pytest.mark.parametrize("suffix", mesh_file.MESH_SUFFIXES)
def test_every_format_gives_the_same_solid(tmp_path: Path, suffix: str):
    box = trimesh.creation.box((2.0, 3.0, 4.0))
    box.apply_translation((0.5, 0.0, 0.0))
    if suffix == ".glb":  # metres, y up
        box.apply_transform(TO_VIEWER)
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
        (trimesh.creation.icosphere(radius=0.001), "must be 0.01 to 200 mm; metres? try scale=1000"),
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
        ("part.step", b"", "must end in .stl, .obj, .ply, .off or .glb"),
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


SHOWN_OFTEN = b'{"nodes":[%s],"meshes":[{"primitives":[{"indices":0}]}],"accessors":[{"count":900000}]}' % b",".join(
    [b'{"mesh":0}'] * 10
)
"""A mesh of 300,000 triangles that ten nodes show."""


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
        ("noise.stl", b"\xff\xfe", "this one has 2"),
        ("many.obj", b"v 0 0 0\n" + b"f 1 1 1\n" * 500_001, "has 500001 triangles: at most 500000"),
        ("bytes.obj", b"v 0 0 0\0", "no text"),
        ("many.ply", b"ply\nelement vertex 4\nelement face 999999999\nend_header\n", "more than its"),
        ("vertices.ply", b"ply\nelement vertex 99999999\nelement face 4\nend_header\n", "more than its"),
        ("head.ply", b"plyx", "does not begin with a PLY header"),
        ("cut.glb", glb(b"{}", length=900), "its header promises 900 bytes"),
        ("many.glb", glb(b'{"accessors":[{"count":9000000000}]}'), "9000000000 values of one kind"),
        ("deep.glb", glb(b"[" * 9000 + b"]" * 9000), "nested too deeply"),
        ("odd.glb", glb(b"[]"), "no glTF"),
        ("shown.glb", glb(SHOWN_OFTEN), "has 3000000 triangles"),
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
def test_large_file_is_refused_unread(tmp_path: Path, name: str, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("magicsim.geometry.files.mesh_file.sha256_of", lambda _: pytest.fail("read"))
    path = tmp_path / name
    path.touch()
    os.truncate(path, 1_000_000_084)
    with pytest.raises(ConfigError, match="has 1000 MB: at most 200 MB are allowed"):
        load_mesh(str(path))


def test_path_with_a_null_byte_is_a_file_that_does_not_exist():
    with pytest.raises(ConfigError, match=r"mesh 'a\\x00b\.stl' does not exist"):
        load_mesh("a\0b.stl")


def box(*shift: float) -> trimesh.Trimesh:
    made = trimesh.creation.box((4.0, 4.0, 4.0))
    made.apply_translation(shift or (0.0, 0.0, 0.0))
    return made


def ball(x: float = 0.0, radius: float = 3.0, *, inverted: bool = False) -> trimesh.Trimesh:
    made = trimesh.creation.icosphere(radius=radius, subdivisions=2)
    made.apply_translation((x, 0.0, 0.0))
    if inverted:
        made.invert()
    return made


def together(*parts: trimesh.Trimesh) -> trimesh.Trimesh:
    return trimesh.util.concatenate(parts)


def figure_eight() -> trimesh.Trimesh:
    """A tube along a curve that crosses itself."""
    t = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    centre = np.stack([4 * np.sin(t), 4 * np.sin(t) * np.cos(t), 0 * t], axis=1)
    along = np.roll(centre, -1, 0) - np.roll(centre, 1, 0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    side = np.stack([-along[:, 1], along[:, 0], 0 * t], axis=1)
    around = np.linspace(0, 2 * np.pi, 16, endpoint=False)
    ring = np.cos(around)[None, :, None] * side[:, None] + np.sin(around)[None, :, None] * np.array([0.0, 0.0, 1.0])
    i, j = np.meshgrid(np.arange(60), np.arange(16), indexing="ij")
    a, b, c, d = (((i + p) % 60 * 16 + (j + q) % 16).ravel() for p, q in ((0, 0), (1, 0), (1, 1), (0, 1)))
    faces = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return trimesh.Trimesh((centre[:, None] + 0.6 * ring).reshape(-1, 3), faces, process=False)


def surface(mesh: trimesh.Trimesh) -> SurfaceMesh:
    return SurfaceMesh(vertices=np.asarray(mesh.vertices), faces=np.asarray(mesh.faces, np.int32))


@pytest.mark.parametrize(
    ("mesh", "crosses"),
    [
        (box(), False),
        (ball(), False),
        (together(box(), box(9.0, 0.0, 0.0)), False),
        (together(ball(), ball(radius=1.0, inverted=True)), False),
        (trimesh.creation.torus(4.0, 1.0), False),
        (together(box(), box(2.0, 1.0, 1.0)), True),
        (together(box(), box(2.0, 0.0, 0.0)), True),
        (together(ball(), ball(3.0)), True),
        (figure_eight(), True),
    ],
)
def test_surface_that_passes_through_itself_is_found(mesh: trimesh.Trimesh, crosses: bool):
    assert (crossing_edges(surface(mesh)) > 0) == crosses


@pytest.mark.parametrize(
    ("mesh", "count"),
    [
        (together(ball(), ball(10.0)), 0),
        (together(ball(), ball(radius=1.0, inverted=True)), 0),
        (together(ball(), ball(10.0, inverted=True)), 1),
        (together(ball(), ball(10.0, inverted=True), ball(20.0, radius=1.0, inverted=True)), 2),
    ],
)
def test_parts_inside_out_are_those_that_are_no_cavities(mesh: trimesh.Trimesh, count: int):
    assert inside_out_parts(surface(mesh)) == count


def test_mesh_that_passes_through_itself_is_warned_about(tmp_path: Path, caplog: pytest.LogCaptureFixture):
    together(box(), box(2.0, 1.0, 1.0)).export(tmp_path / "two.stl")
    with caplog.at_level(logging.WARNING, logger="magicsim"):
        load_mesh(str(tmp_path / "two.stl"))
    (line,) = [record.getMessage() for record in caplog.records]
    assert "two.stl' passes through itself" in line


def test_parts_that_overlap_press_as_the_solid_that_they_make(tmp_path: Path):
    parts = [trimesh.creation.icosphere(radius=3.0, subdivisions=3) for _ in range(2)]
    parts[1].apply_translation((1.5, 0.3, 0.1))
    together(*parts).export(tmp_path / "two.stl")
    trimesh.boolean.union(parts, engine="manifold").export(tmp_path / "one.stl")
    block = load_preset(ElastomerDesign, "design", "uniform-block", ["lattice.spacing_mm=2", "lattice.cells_across=0"])
    two, one = (
        press(block, parse_object(f"mesh:path={tmp_path / name}"), depth_mm=0.5, tolerance_mm=1e-5).force_n
        for name in ("two.stl", "one.stl")
    )
    assert two == pytest.approx(one, rel=1e-6)


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda mesh: mesh.apply_translation((0, 0, 1e6)), "from its origin"),
        (lambda mesh: mesh.apply_scale((1, 1, 0)), "measures 6 x 6 x 0 mm"),
        (lambda mesh: mesh.apply_scale(1e-4), "metres\\? try scale=1000"),
        (lambda mesh: mesh.apply_scale(1e20), "change scale"),
        (lambda mesh: mesh.vertices.__setitem__(3, np.nan), "not finite"),
        (lambda mesh: mesh.vertices.__setitem__(3, np.inf), "not finite"),
    ],
)
def test_mesh_whose_corners_cannot_be_used_says_why(tmp_path: Path, change, named: str):
    mesh = ball()
    change(mesh)
    (tmp_path / "a.obj").write_text(
        "".join(f"v {x} {y} {z}\n" for x, y, z in np.asarray(mesh.vertices))
        + "".join(f"f {a} {b} {c}\n" for a, b, c in mesh.faces + 1)
    )
    with pytest.raises(ConfigError, match=named):
        load_mesh(str(tmp_path / "a.obj"))


SLOT = [(-3, -3), (3, -3), (3, 3), (0.4, 3), (0.4, -1), (-0.4, -1), (-0.4, 3), (-3, 3)]
"""A plate with a slot: 36 mm2 less 0.8 x 4 mm2."""


def slotted(path: Path, first: int, form: str) -> str:
    """A plate 3 mm high whose faces are concave polygons that begin at some corner."""
    corners = SLOT[first:] + SLOT[:first]
    count = len(corners)
    lines = ["# Blender", *(f"v {x} {y} {z}" for z in (-3.0, 0.0) for x, y in corners), "vt 0 0", "vn 0 0 1"]
    top, bottom = [count + each + 1 for each in range(count)], list(range(count, 0, -1))
    sides = [[i + 1, (i + 1) % count + 1, count + (i + 1) % count + 1, count + i + 1] for i in range(count)]
    if form == "negative":
        top, bottom, *sides = ([each - 2 * count - 1 for each in face] for face in (top, bottom, *sides))
    name = "{}/1/1" if form == "textured" else "{}"
    lines += ["f " + " ".join(name.format(each) for each in face) for face in (top, bottom, *sides)]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


@pytest.mark.parametrize("first", range(8))
@pytest.mark.parametrize("form", ["plain", "textured", "negative"])
def test_concave_polygons_of_an_obj_cover_their_own_ground(tmp_path: Path, first: int, form: str, caplog):
    shape = load_mesh(slotted(tmp_path / "slot.obj", first, form), scale=1.0)
    assert shape.surface.volume_mm3() == pytest.approx(3 * (36 - 0.8 * 4))
    inside_the_slot = shape.distance(np.array([[0.0, 1.0, -0.1]]))[0]
    assert inside_the_slot[0] == pytest.approx(0.4)
    assert not caplog.records


def test_triangle_of_two_corners_is_left_out(tmp_path: Path):
    ball = trimesh.creation.icosphere()
    faces = np.concatenate([ball.faces, [[0, 0, 1]]])
    path = written(tmp_path, trimesh.Trimesh(ball.vertices, faces, process=False))
    assert len(load_mesh(path).surface.faces) == len(ball.faces)


def test_text_stl_may_be_in_capitals_after_a_mark_of_utf_8(tmp_path: Path):
    text = trimesh.exchange.stl.export_stl_ascii(trimesh.creation.box((6, 6, 6)))
    (tmp_path / "a.stl").write_text("\ufeff" + text.upper(), encoding="utf-8")
    assert load_mesh(str(tmp_path / "a.stl")).surface.volume_mm3() == pytest.approx(216)


def test_glb_in_millimetres_is_told(tmp_path: Path):
    path = written(tmp_path, ball(), "ball.glb")
    with pytest.raises(ConfigError, match=r"millimetres\? try scale=1$"):
        load_mesh(path)
    assert load_mesh(path, scale=1.0).support_mm(np.array([0.0, 0.0, 1.0])) == pytest.approx(3.0)


def test_triangles_of_one_corner_are_refused_before_they_take_minutes(tmp_path: Path):
    path = written(tmp_path, trimesh.creation.cone(4.0, 8.0, sections=12_000))
    with pytest.raises(ConfigError, match=r"has 24000 triangles that are long and thin, each among 1\d{4} others"):
        load_mesh(path)
    load_mesh(written(tmp_path, trimesh.creation.icosphere(subdivisions=5, radius=5)))


def test_exported_glb_is_the_same_solid_as_a_mesh(tmp_path: Path):
    design = load_design("uniform-block", ["footprint_mm=[8,9]"])
    export_design(design, tmp_path / "block.glb")
    export_design(design, tmp_path / "block.stl")
    solid, other = (load_mesh(str(tmp_path / name)) for name in ("block.glb", "block.stl"))
    assert solid.surface.volume_mm3() == pytest.approx(other.surface.volume_mm3(), rel=1e-5)
    np.testing.assert_allclose(solid.box_mm, other.box_mm, atol=1e-4)


def test_ball_in_metres_is_read_as_metres_of_a_glb_and_told_of_an_stl(tmp_path: Path, caplog):
    ball = trimesh.creation.icosphere(radius=0.02)
    assert np.ptp(load_mesh(written(tmp_path, ball, "ball.glb")).box_mm) == pytest.approx(40.0)
    path = written(tmp_path, ball)
    load_mesh(path)
    assert "is 0.04 mm across: if its unit is the metre, scale=1000; if it is the inch, scale=25.4" in caplog.text
    thing = parse_object(f"mesh:path={path}")
    place_object(thing, gap_mm=1.0)
    with pytest.raises(ConfigError, match=r"0\.04 mm across and cannot touch: .* metres\? try scale=1000"):
        place_object(thing, gap_mm=-0.01)
    place_object(parse_object(f"mesh:path={path},scale=1000"), gap_mm=-0.01)


@pytest.mark.parametrize(
    ("line", "scale"),
    [
        ("# Units: inches", 25.4),
        ("# unit = cm", 10),
        ("# file units: meters", 1000),
        ("# units are in cm", 10),
        ("# Units in mm", None),
        ("# all units in millimeters", None),
    ],
)
def test_unit_that_an_obj_names_is_told_where_it_is_not_the_one_taken(tmp_path: Path, line: str, scale, caplog):
    path = Path(written(tmp_path, trimesh.creation.icosphere(radius=10), "ball.obj"))
    path.write_text(f"{line}\n{path.read_text()}")
    load_mesh(str(path))
    assert caplog.text == "" if scale is None else f"scale={scale:g} would take it as that" in caplog.text
