"""Nothing that lies inside the block between its contact points is an answer, and nothing else is refused."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import axis_weights, contact_face, face_weights, point_spacing_mm
from magicsim.deform.deformation import Deformation
from magicsim.deform.indentation.press import press
from magicsim.deform.lattice.core_failure import CoreLaw
from magicsim.deform.lattice.structure import Lattice, box_lattice, build_lattice
from magicsim.deform.lattice.yielding import FlowLaw
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.overlap import UNSEEN_MM, overlap_fault, points_inside, smallest_radius_mm, surface_points
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import ConvergenceError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object

SMALL = ["footprint_mm=[6,6]", "core_mm=3.0"]
COARSE = load_preset(ElastomerDesign, "design", "uniform-block", [*SMALL, "lattice.cells_across=0"])


def solved(
    what: str, depth_mm: float, x_mm: float = 0.0, y_mm: float = 0.0, core: CoreLaw | None = None
) -> tuple[Lattice, Deformation, float]:  # fmt: skip
    """Lattice, state and deepest point of an object in the small coarse block."""
    indenter = place_object(parse_object(what), gap_mm=-depth_mm, x_mm=x_mm, y_mm=y_mm)
    lattice = build_lattice(COARSE, zone=contact_zone([indenter], COARSE))
    solver = ContactSolver(lattice, point_spacing_mm=point_spacing_mm(indenter.shape), core=core)
    state = solver.solve(indenter)
    inside = points_inside(lattice, state.displacements_mm, indenter)
    return lattice, state, float(inside.depth_mm.max(initial=0.0))


@pytest.mark.parametrize("depth_mm", [0.1, 0.2, 0.25])
def test_a_ball_between_the_points_is_refused_with_the_radius_that_is_found(depth_mm: float) -> None:
    with pytest.raises(ConvergenceError, match=rf"lies {depth_mm:g} mm inside .* 0.2 mm apart .* radii from 0.23 mm"):
        solved("sphere:radius_mm=0.05", depth_mm)


def test_the_radius_that_is_said_to_be_found_is_found_anywhere() -> None:
    radius = smallest_radius_mm(0.2)
    for x_mm in np.linspace(0, 0.2, 5):
        assert solved(f"sphere:radius_mm={radius:.4g}", UNSEEN_MM + 0.005, x_mm, 0.1)[1].force_n[2] > 0


def test_a_ball_too_small_for_the_lattice_gets_finer_cells() -> None:
    design = load_preset(ElastomerDesign, "design", "uniform-block", ["footprint_mm=[3,3]", "core_mm=1.0"])
    found = press(design, parse_object("sphere:radius_mm=0.05"), depth_mm=0.05)
    assert found.force_n[2] > 0
    indenter = place_object(parse_object("sphere:radius_mm=0.05"), gap_mm=-0.05)
    lattice = build_lattice(design, zone=contact_zone([indenter], design))
    assert min(np.diff(planes).min() for planes in lattice.planes_mm[:2]) == pytest.approx(0.05, rel=0.05)


def test_a_ball_deeper_than_a_face_can_follow_is_refused_at_once() -> None:
    with pytest.raises(ConvergenceError, match=r"pressed 0.5 mm deep and measures 0.1 mm.* at least 0.2 mm"):
        press(
            load_preset(ElastomerDesign, "design", "uniform-block", SMALL), parse_object("sphere:radius_mm=0.05"),
            depth_mm=0.5,
        )  # fmt: skip


def test_a_ball_around_which_the_face_stretches_beyond_its_nodes_is_refused_at_once() -> None:
    design = load_preset(ElastomerDesign, "design", "mini-magictac", [])
    with pytest.raises(ConvergenceError, match=r"pressed 0.5 mm deep .* the face stretches .* at most"):
        press(design, parse_object("sphere:radius_mm=0.1"), depth_mm=0.5)


def test_smooth_objects_lie_in_the_face_to_a_hundredth_of_the_node_spacing() -> None:
    assert solved("sphere:radius_mm=2", 0.5)[2] < 0.01
    assert solved("cylinder:radius_mm=2,length_mm=12,axis=x", 0.4, y_mm=0.3)[2] < 0.01


@pytest.mark.parametrize("what", ["box:size_mm=3", "punch:radius_mm=1", "cone:half_angle_deg=30"])
def test_edges_and_tips_that_press_are_accepted(what: str) -> None:
    _, state, depth = solved(what, 0.4)
    assert state.force_n[2] > 0
    assert 0.01 < depth < 0.4


def test_what_stands_beside_the_block_is_not_inside_it() -> None:
    _, state, depth = solved("box:size_mm=3", 0.4, x_mm=2.5)
    assert state.force_n[2] > 0
    assert depth < 0.4
    assert solved("box:size_mm=3", 1.0, x_mm=5.0)[1].is_rest


@pytest.mark.parametrize("overlap_mm", [0.06, 0.075, 0.099])
def test_an_edge_in_a_side_of_the_block_lies_inside_by_what_it_overlaps(overlap_mm: float) -> None:
    box = parse_object("box:size_mm=0.92x4x6,edge_radius_mm=0.011")
    indenter = place_object(box, gap_mm=-0.75, x_mm=3 + 0.46 - overlap_mm, y_mm=1.0)
    lattice = build_lattice(COARSE, zone=contact_zone([indenter], COARSE))
    inside = points_inside(lattice, np.zeros_like(lattice.nodes_mm), indenter)
    assert inside.depth_mm.max() == pytest.approx(overlap_mm, abs=1e-3)


@pytest.fixture
def spike(tmp_path: Path) -> str:
    """A plate with a tip of 0.5 mm that is thinner than contact points are apart."""
    tip = trimesh.creation.cone(0.05, 0.6).apply_translation([0.1, 0.1, 0.4])
    plate = trimesh.creation.box((2.0, 2.0, 1.0))
    trimesh.boolean.union([plate, tip], engine="manifold").export(tmp_path / "spike.stl")
    return f"mesh:path={tmp_path / 'spike.stl'}"


def test_a_spike_that_misses_the_points_is_refused(spike: str) -> None:
    with pytest.raises(ConvergenceError, match="no contact point near it presses"):
        solved(spike, 0.4)


def test_a_spike_beside_what_presses_is_refused_where_the_core_may_fail_too(spike: str) -> None:
    flow = FlowLaw(cells=np.arange(1), modulus_mpa=0.01, shear=1.0)
    for core in (None, CoreLaw(flow=flow)):
        with pytest.raises(ConvergenceError, match=r"lies 0\.5 mm inside .* at most 0\.4 mm is allowed"):
            solved(spike, 0.55, core=core)


def test_a_tip_on_a_plane_of_symmetry_counts() -> None:
    planes = np.linspace(0, 3, 4)
    quarter = box_lattice((planes, planes, planes), shear_modulus_mpa=1.0, lame_mpa=10.0)
    whole = Deformation.rest(quarter)
    indenter = place_object(parse_object("sphere:radius_mm=0.05"), gap_mm=-0.4)
    assert points_inside(quarter, whole.displacements_mm, indenter).depth_mm.max(initial=0.0) < 0.4
    mirrored = replace(quarter, is_mirrored=True)
    assert points_inside(mirrored, whole.displacements_mm, indenter).depth_mm.max() == pytest.approx(0.4)


def test_state_of_no_contact_is_a_fault_only_below_the_object() -> None:
    lattice = build_lattice(COARSE)
    rest, face = Deformation.rest(lattice), contact_face(lattice)
    below = place_object(parse_object("sphere:radius_mm=2"), gap_mm=0.1)
    inside = place_object(parse_object("sphere:radius_mm=2"), gap_mm=-0.3)
    assert overlap_fault(lattice, face, rest, below) is None
    assert "lies 0.3 mm inside" in str(overlap_fault(lattice, face, rest, inside))


def test_axis_weights_are_those_of_the_face() -> None:
    lattice = build_lattice(COARSE)
    x, y = np.array([-2.9, 0.31]), np.array([0.17, 2.2])
    (along_x, _), (along_y, _) = (axis_weights(p, at) for p, at in zip(lattice.planes_mm[:2], (x, y), strict=True))
    values = np.random.default_rng(0).normal(size=(len(lattice.nodes_mm), 3))
    face = values[: lattice.layer_nodes].reshape(along_y.shape[1], along_x.shape[1], 3)
    expected = face_weights(lattice, np.stack([x, y], axis=1)) @ values
    found = np.einsum("qj,qi,jic->qc", along_y, along_x, face)
    np.testing.assert_allclose(found, expected, atol=1e-12)


def test_edges_of_a_mesh_are_looked_at_between_its_vertices(tmp_path: Path) -> None:
    path = tmp_path / "plate.stl"
    trimesh.creation.box((4.0, 3.0, 1.0)).export(path)
    points = surface_points(parse_object(f"mesh:path={path}").shape())
    side = points[(np.abs(points[:, 1] - 1.5) < 1e-9) & (np.abs(points[:, 2] - 0.5) < 1e-9)]
    assert np.diff(np.sort(side[:, 0])).max() < 0.11
    assert len(surface_points(parse_object("sphere:radius_mm=2").shape())) == len(
        parse_object("sphere:radius_mm=2").shape().mesh().vertices
    )
