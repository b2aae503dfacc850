import logging
from pathlib import Path

import numpy as np
import pytest
import trimesh

from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import press
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.files.mesh_file import crossing_edges, inside_out_parts, load_mesh
from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.kinds import parse_object


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
        (lambda mesh: mesh.apply_scale(1e-4), "change scale"),
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
