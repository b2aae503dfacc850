"""Kinds of objects of other tools: polygons, numbers of vertices, bodies of bodies; and presses that take too long."""

import json
import struct
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import trimesh

from laboratory.input_kinds.program import SLOT, SLOT_MM3
from laboratory.input_kinds.registry import one_line_with, run, variation

Faces = list[list[int]]
CLOSE, FREE_MM = 1e-3, 0.4
"""Relative error, and distance of the slot's middle from its walls [mm]."""
HALF_WAY = [each for one, other in zip(SLOT, SLOT[1:] + SLOT[:1], strict=True)
            for each in (one, ((one[0] + other[0]) / 2, (one[1] + other[1]) / 2))]  # fmt: skip
"""The plate's corners with one more in the middle of each side."""


def plate(
    corners: Sequence[tuple[float, float]], skew_mm: float = 0.0
) -> tuple[list[tuple[float, float, float]], Faces]:
    """Vertices and polygons of a plate 3 mm high; `skew_mm` lifts every other corner."""
    count = len(corners)
    vertices = [(x, y, z + skew_mm * (n % 2)) for z in (-3.0, 0.0) for n, (x, y) in enumerate(corners)]
    sides = [[n, (n + 1) % count, count + (n + 1) % count, count + n] for n in range(count)]
    return vertices, [list(range(count, 2 * count)), list(range(count))[::-1], *sides]


def write_ply(path: Path, vertices: Sequence[Sequence[float]], faces: Faces, *, form: str) -> str:
    """A PLY file, text or binary, with a colour for each polygon."""
    head = (
        f"ply\nformat {form} 1.0\nelement vertex {len(vertices)}\nproperty float x\nproperty float y\n"
        f"property float z\nelement face {len(faces)}\nproperty list uchar int vertex_index\n"
        "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n"
    )
    if form == "ascii":
        rows = [" ".join(str(each) for each in row) for row in vertices]
        rows += [" ".join(str(each) for each in (len(face), *face, 200, 100, n)) for n, face in enumerate(faces)]
        path.write_text(head + "\n".join(rows) + "\n")
        return str(path)
    order = ">" if form == "binary_big_endian" else "<"
    body = [struct.pack(f"{order}3f", *row) for row in vertices]
    body += [struct.pack(f"{order}B{len(face)}i3B", len(face), *face, 200, 100, n) for n, face in enumerate(faces)]
    path.write_bytes(head.encode() + b"".join(body))
    return str(path)


def write_off(path: Path, vertices: Sequence[Sequence[float]], faces: Faces) -> str:
    """An OFF file with a comment."""
    rows = [" ".join(str(each) for each in row) for row in vertices]
    rows += [" ".join(str(each) for each in (len(face), *face)) for face in faces]
    path.write_text(f"OFF # other tool\n{len(vertices)} {len(faces)} 0\n" + "\n".join(rows) + "\n")
    return str(path)


def write_obj(path: Path, *parts: tuple[list[tuple[float, float, float]], Faces]) -> str:
    """An OBJ file of several objects, whose corners are counted from the end."""
    lines = []
    for number, (vertices, faces) in enumerate(parts):
        lines += [f"o part{number}", f"usemtl m{number}", *(f"v {x} {y} {z}" for x, y, z in vertices)]
        lines += ["f " + " ".join(str(each - len(vertices)) for each in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


def unlike_plate(path: str, volume_mm3: float = SLOT_MM3) -> str | None:
    """What is wrong with a plate: its volume, its slot, or faces that pass through each other."""
    from magicsim.geometry.files.mesh_file import crossing_edges, load_mesh

    solid = load_mesh(path, scale=1.0)
    volume, free = solid.surface.volume_mm3(), float(solid.distance(np.array([[0.0, 1.0, -1.0]]))[0][0])
    if crossing := crossing_edges(solid.surface):
        return f"{crossing} edges cross"
    is_right = abs(volume - volume_mm3) < CLOSE * volume_mm3 and abs(free - FREE_MM) < CLOSE
    return None if is_right else f"{volume:g} mm3, slot {free:g} mm free"


def _refusal(path: Path | str, *words: str) -> str | None:
    """What is wrong with the one line that refuses a mesh."""
    from magicsim.errors import ConfigError
    from magicsim.geometry.files.mesh_file import load_mesh

    try:
        load_mesh(str(path))
    except ConfigError as error:
        missing = [word for word in words if word not in str(error)]
        return f"without {missing}: {error}" if missing else None
    return "it is read"


@variation("concave polygon in a PLY or OFF file", "text PLY with colours", expected="98.4 mm3, slot free")
def ply_text(work: Path) -> str | None:
    """The slotted plate from the slot's corner."""
    return unlike_plate(write_ply(work / "slot.ply", *plate(SLOT[5:] + SLOT[:5]), form="ascii"))


@variation("concave polygon in a PLY or OFF file", "binary PLY of unequal polygons", expected="98.4 mm3, slot free")
def ply_binary(work: Path) -> str | None:
    """The same in the other order of bytes."""
    return unlike_plate(write_ply(work / "slot.ply", *plate(SLOT), form="binary_big_endian"))


@variation("concave polygon in a PLY or OFF file", "OFF", expected="98.4 mm3, slot free")
def off_text(work: Path) -> str | None:
    """The same as OFF."""
    return unlike_plate(write_off(work / "slot.off", *plate(SLOT)))


@variation("polygon that is not plain", "corners in the middle of sides", expected="98.4 mm3, slot free")
def collinear(work: Path) -> str | None:
    """Its first triangle of a fan has no area."""
    return unlike_plate(write_obj(work / "slot.obj", plate(HALF_WAY)))


@variation("polygon that is not plain", "corners out of its plane", expected="98.4 mm3, slot free")
def skew(work: Path) -> str | None:
    """Every other corner 0.05 mm higher."""
    return unlike_plate(write_obj(work / "slot.obj", plate(HALF_WAY, 0.05)))


@variation("polygon that is not plain", "two objects in one file", expected="both, 196.8 mm3")
def two_objects(work: Path) -> str | None:
    """Each with numbers from the end."""
    vertices, faces = plate(SLOT)
    other = [(x + 20, y, z) for x, y, z in vertices]
    return unlike_plate(write_obj(work / "slots.obj", (vertices, faces), (other, faces)), 2 * SLOT_MM3)


@variation("file that a reader misreads", "PLY that counts from the end", expected="one line: not there")
def negative(work: Path) -> str | None:
    """PLY has no negative numbers."""
    box = trimesh.creation.box((6, 6, 6))
    faces = [[int(each) - 8 for each in box.faces[0]], *box.faces[1:].tolist()]
    return _refusal(write_ply(work / "box.ply", box.vertices.tolist(), faces, form="ascii"), "is not there")


@variation("file that a reader misreads", "STL in capitals after a mark of UTF-8", expected="216 mm3")
def capitals(work: Path) -> str | None:
    """As some CAD programs write it."""
    from magicsim.geometry.files.mesh_file import load_mesh

    text = trimesh.exchange.stl.export_stl_ascii(trimesh.creation.box((6, 6, 6)))
    (work / "box.stl").write_text("\ufeff" + text.upper(), encoding="utf-8")
    volume = load_mesh(str(work / "box.stl")).surface.volume_mm3()
    return None if abs(volume - 216) < CLOSE * volume else f"{volume:g} mm3"


@variation("file that a reader misreads", "GLB whose positions are shares", expected="one line that says so")
def shares(work: Path) -> str | None:
    """KHR_mesh_quantization: 127 is 1."""
    tree = {"asset": {"version": "2.0"}, "nodes": [{"mesh": 0}], "accessors": [{"count": 9, "normalized": True}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}]}  # fmt: skip
    content = json.dumps(tree).encode()
    (work / "a.glb").write_bytes(b"glTF" + struct.pack("<III", 2, 20 + len(content), len(content)) + b"JSON" + content)
    return _refusal(work / "a.glb", "shares of the largest integer")


def _unlike_body(geoms: str, volume_mm3: float, top_mm: float) -> str | None:
    """What is wrong with the solid of a free MuJoCo body."""
    import mujoco

    from magicsim.robot.mujoco.solids import body_object

    text = f"<mujoco><worldbody><body name='thing'><freejoint/>{geoms}</body></worldbody></mujoco>"
    solid = body_object(mujoco.MjSpec.from_string(text).compile(), 1)[0].shape()
    volume, top = solid.mesh().volume_mm3(), solid.support_mm(np.array([0.0, 0.0, 1.0]))
    is_right = abs(volume - volume_mm3) < 20 * CLOSE * volume_mm3 and abs(top - top_mm) < 100 * CLOSE
    return None if is_right else f"{volume:g} mm3 up to {top:g} mm"


PLATE = "<geom type='box' size='.004 .004 .002' mass='.01'/>"
PLATE_MM3, POST_MM3 = 256.0, 24.0


@variation("MuJoCo body of several bodies", "geometry on a child", expected="280 mm3 up to 9 mm")
def child(_work: Path) -> str | None:
    """A post 6 mm above the middle of the plate."""
    return _unlike_body(
        f"{PLATE}<body pos='0 0 .006'><geom type='box' size='.001 .001 .003'/></body>", PLATE_MM3 + POST_MM3, 9.0
    )


@variation("MuJoCo body of several bodies", "two welds that turn", expected="280 mm3 up to 6 mm")
def turned(_work: Path) -> str | None:
    """The post lies along y, lifted by two bodies of which one has no geometry."""
    nested = "<body pos='0 .01 0' euler='90 0 0'><body pos='0 .005 0' euler='0 0 90'>{}</body></body>"
    post = nested.format("<geom type='box' size='.001 .001 .003'/>")
    return _unlike_body(f"{PLATE}{post}", PLATE_MM3 + POST_MM3, 6.0)


@variation("MuJoCo body of several bodies", "child on a hinge", expected="256 mm3 up to 2 mm: it is another body")
def hinged(_work: Path) -> str | None:
    """The post swings."""
    return _unlike_body(
        f"{PLATE}<body pos='0 0 .006'><joint/><geom type='box' size='.001 .001 .003'/></body>", PLATE_MM3, 2.0
    )


@variation("press that takes too long", "command", expected="one line: bound, depth, what to try")
def bound_of_press(work: Path) -> str | None:
    """A bound of one iteration, and a way of several load steps."""
    ended = run(
        "-m", "magicsim", "press", "uniform-block", "--object", "sphere:radius_mm=1", "--depth-mm", "3",
        "--max-iterations", "1", folder=work,
    )  # fmt: skip
    return one_line_with(ended, "max_iterations = 1", "mm deep", "3 mm were asked for", "raise the bound")


@variation("press that takes too long", "scene", expected="one line: bound, depth, what to try")
def bound_of_scene(work: Path) -> str | None:
    """The same bound in a scene."""
    ended = run(
        "-m", "magicsim", "simulate", "pressed", "--out", "out", "--set", "contact.max_iterations=1", "--set",
        "keyframes=[{frame=0,gap_mm=-2.5}]", folder=work, timeout_s=600,
    )  # fmt: skip
    return one_line_with(ended, "max_iterations = 1", "mm deep", "raise the bound")


@variation("press that takes too long", "cone of 40,000 needles", expected="one line: long and thin")
def needles(work: Path) -> str | None:
    """Every distance would ask all of them."""
    trimesh.creation.cone(4.0, 8.0, sections=20_000).export(work / "cone.stl")
    return _refusal(work / "cone.stl", "long and thin")
