"""Kinds of meshes, of names in two folders, and of what is imported before the program."""

import os
import shutil
from pathlib import Path

import numpy as np
import trimesh

from laboratory.input_kinds.registry import run, variation

TIME_NS = 1_700_000_000_000_000_000
SLOT = [(-3, -3), (3, -3), (3, 3), (0.4, 3), (0.4, -1), (-0.4, -1), (-0.4, 3), (-3, 3)]
"""A plate with a slot, counter-clockwise [mm]."""
SLOT_MM3 = 3 * (36 - 0.8 * 4)
CLOSE = 1e-3


def _ball(path: Path, radius: float) -> Path:
    trimesh.creation.icosphere(subdivisions=2, radius=radius).export(path)
    os.utime(path, ns=(TIME_NS, TIME_NS))
    return path


def _top_mm(path: str, **options: float) -> float:
    from magicsim.geometry.files.mesh_file import load_mesh

    return load_mesh(path, **options).support_mm(np.array([0.0, 0.0, 1.0]))


def _unlike(found: float, wanted: float) -> str | None:
    return None if abs(found - wanted) < CLOSE * abs(wanted) else f"{found:g} and not {wanted:g}"


@variation("mesh of equal name, time and size", "two folders, one process", expected="the second one's size")
def two_folders(work: Path) -> str | None:
    """Reads tip.stl by its relative name in two folders."""
    found, here = 0.0, Path.cwd()
    for name, radius in (("a", 2.0), ("b", 3.0)):
        (work / name).mkdir()
        os.chdir(_ball(work / name / "tip.stl", radius).parent)
        found = _top_mm("tip.stl")
        os.chdir(here)
    return _unlike(found, 3.0)


@variation("mesh of equal name, time and size", "cp -p over the old one", expected="the new one's size")
def copied(work: Path) -> str | None:
    """Replaces a mesh that was read by a copy with its time."""
    there = _ball(work / "tip.stl", 2.0)
    _top_mm(str(there))
    (work / "new").mkdir()
    shutil.copy2(_ball(work / "new" / "tip.stl", 3.0), there)
    return _unlike(_top_mm(str(there)), 3.0)


@variation("mesh of equal name, time and size", "picture with a blank in its name", expected="another hash")
def picture(work: Path) -> str | None:
    """Changes a texture that an indented line of an OBJ file's materials names."""
    from magicsim.config.named_files import config_digest

    (work / "a.obj").write_text("  mtllib a.mtl\nv 0 0 0\n")
    (work / "a.mtl").write_text("newmtl x\n\tMAP_KD my skin.png\n")
    hashes = set()
    for text in ("one", "two"):
        (work / "my skin.png").write_text(text)
        hashes.add(config_digest({"kind": "mesh", "path": str(work / "a.obj")}))
    return None if len(hashes) == 2 else "the same hash"


def _slotted(path: Path, first: int, *, negative: bool = False) -> str:
    corners = SLOT[first:] + SLOT[:first]
    count = len(corners)
    lines = [f"v {x} {y} {z}" for z in (-3.0, 0.0) for x, y in corners]
    faces = [[count + each + 1 for each in range(count)], list(range(count, 0, -1))]
    faces += [[i + 1, (i + 1) % count + 1, count + (i + 1) % count + 1, count + i + 1] for i in range(count)]
    shift = 2 * count + 1 if negative else 0
    lines += ["f " + " ".join(str(each - shift) for each in face) for face in faces]
    path.write_text("\n".join(lines) + "\n")
    return str(path)


@variation("concave polygon in an OBJ file", "first corner convex", expected="98.4 mm3")
def concave(work: Path) -> str | None:
    """A slotted plate that a fan from the first corner would fill in part."""
    return _volume(_slotted(work / "slot.obj", 0))


@variation("concave polygon in an OBJ file", "first corner at the slot's end", expected="98.4 mm3")
def concave_from_the_slot(work: Path) -> str | None:
    """The same plate from another corner."""
    return _volume(_slotted(work / "slot.obj", 5))


@variation("concave polygon in an OBJ file", "corners counted from the end", expected="98.4 mm3")
def concave_negative(work: Path) -> str | None:
    """The same plate with negative numbers."""
    return _volume(_slotted(work / "slot.obj", 2, negative=True))


def _volume(path: str) -> str | None:
    from magicsim.geometry.files.mesh_file import load_mesh

    return _unlike(load_mesh(path).surface.volume_mm3(), SLOT_MM3)


@variation("unit of a mesh", "GLB in metres", expected="a ball of 40 mm")
def metres(work: Path) -> str | None:
    """Radius 0.02 m."""
    return _unlike(_top_mm(str(_ball(work / "ball.glb", 0.02))), 20.0)


@variation("unit of a mesh", "GLB with y up", expected="a cone 8 mm high along z")
def upright(work: Path) -> str | None:
    """A cone along y."""
    cone = trimesh.creation.cone(radius=0.004, height=0.008)
    cone.apply_transform(np.array([[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]], float))
    cone.export(work / "cone.glb")
    return _unlike(_top_mm(str(work / "cone.glb")), 8.0)


@variation("unit of a mesh", "STL in metres that touches", expected="one line: metres? try scale=1000")
def tiny(work: Path) -> str | None:
    """Radius 0.02 in a format without a unit."""
    from magicsim.errors import ConfigError
    from magicsim.geometry.indenter import place_object
    from magicsim.geometry.objects.kinds import parse_object

    try:
        place_object(parse_object(f"mesh:path={_ball(work / 'ball.stl', 0.02)}"), gap_mm=-0.01)
    except ConfigError as error:
        return None if "metres? try scale=1000" in str(error) else str(error)
    return "it touches"


def _imported(work: Path, first: str) -> str | None:
    """Says what is wrong where a module is imported before the program."""
    code = f"{first}\nimport magicsim.light.backend as b\nprint(b.dr.sum(b.dr.arange(b.mi.Float, 1000))[0])"
    ended = run("-c", code, folder=work)
    told = (ended.stderr.strip().splitlines() or [""])[-1]
    is_one_line = "was imported before magicsim" in told
    return None if is_one_line or "499500" in ended.stdout else f"exit code {ended.returncode}: {told}"


@variation("renderer imported before the program", "mitsuba", expected="it works, or one line names the library")
def mitsuba_first(work: Path) -> str | None:
    """As a notebook may."""
    return _imported(work, "import mitsuba")


@variation("renderer imported before the program", "drjit", expected="it works, or one line names the library")
def drjit_first(work: Path) -> str | None:
    """As a notebook may."""
    return _imported(work, "import drjit")


@variation("renderer imported before the program", "mitsuba with its variant set", expected="likewise")
def variant_first(work: Path) -> str | None:
    """As a notebook may."""
    return _imported(work, "import mitsuba\nmitsuba.set_variant('llvm_ad_rgb')")
