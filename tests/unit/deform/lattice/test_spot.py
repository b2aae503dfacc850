import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.spot import central_lattice, displaced_elsewhere, is_mirror_image
from magicsim.deform.lattice.structure import build_lattice
from magicsim.deform.lattice.zone import contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import parse_object

BALL = parse_object("sphere:radius_mm=4")


def design(*settings: str) -> ElastomerDesign:
    return load_preset(ElastomerDesign, "design", "mini-magictac", settings)


def solved(lattice, indenter: Indenter):
    return ContactSolver(lattice, point_spacing_mm=point_spacing_mm(indenter.shape)).solve(indenter)


@pytest.mark.parametrize(
    ("thing", "is_symmetric"),
    [
        ("sphere:radius_mm=4", True),
        ("dots:radius_mm=0.5,spacing_mm=2,size_mm=10", True),
        ("lines:width_mm=0.5,spacing_mm=1,size_mm=5", True),
        ("lines:width_mm=0.5,spacing_mm=1,size_mm=5,yaw_deg=30", False),
        ("box:size_mm=4x4x4,roll_deg=10", False),
    ],
)
def test_mirror_image_is_told_from_what_is_none(thing: str, is_symmetric: bool):
    assert is_mirror_image(place_object(parse_object(thing), gap_mm=-0.3)) is is_symmetric


def test_object_off_the_middle_is_no_mirror_image():
    assert not is_mirror_image(place_object(BALL, gap_mm=-0.3, x_mm=0.5))


def test_planes_keep_skin_and_core_apart_and_end_at_the_sides():
    block, indenter = design(), place_object(BALL, gap_mm=-0.3)
    zone = contact_zone([indenter], block)
    whole = central_lattice(block, zone, spacing_mm=0.4, is_quarter=False)
    for planes, (low, high) in zip(whole.planes_mm, ((-12, 12), (-16, 16), (0, block.height_mm)), strict=True):
        assert (planes[0], planes[-1]) == pytest.approx((low, high))
        for face in (low + block.skin_mm, high - block.skin_mm):
            assert np.abs(planes - face).min() < 1e-9
    inside = np.abs(whole.planes_mm[0]) < zone.radius_mm
    assert np.diff(whole.planes_mm[0][inside]).max() <= 0.4 * 1.05
    assert np.allclose(whole.planes_mm[0], -whole.planes_mm[0][::-1])


def test_touch_off_the_crown_of_a_dome_moves_the_face_as_that_on_the_crown_does():
    dome = design("face={kind='dome',radius_x_mm=20.0,radius_y_mm=30.0,crown_mm=1.6}")
    lattice = central_lattice(
        dome, contact_zone([place_object(BALL, gap_mm=-0.3)], dome), spacing_mm=0.8, is_quarter=False
    )
    dents = np.exp(-(lattice.flattened(lattice.nodes_mm) ** 2).sum(1) / 4)[:, None] * [0.1, -0.2, 0.3]
    beside, place = np.random.default_rng(1).uniform(-3, 3, (50, 2)), np.array([4.0, -3.0])
    beside[0] = 0

    def on_face(places: np.ndarray) -> np.ndarray:
        return np.column_stack([places, dome.rise_mm(places)])

    there = displaced_elsewhere(lattice, dents, on_face(beside + place), tuple(place))
    np.testing.assert_allclose(there, displaced_elsewhere(lattice, dents, on_face(beside), (0.0, 0.0)), atol=1e-12)
    assert np.abs(there).max() > 0.25


@pytest.mark.slow
def test_quarter_says_what_the_whole_block_says():
    block, indenter = design("footprint_mm=[12,12]"), place_object(BALL, gap_mm=-0.3)
    zone = contact_zone([indenter], block)
    quarter, whole = (
        central_lattice(block, zone, spacing_mm=zone.radius_mm / 4, is_quarter=each) for each in (True, False)
    )
    one, all_four = solved(quarter, indenter), solved(whole, indenter)
    # the face beyond a plane of symmetry is none of the quarter's stencils: 1.0 % here, less on finer lattices
    assert 4 * one.force_n[2] == pytest.approx(all_four.force_n[2], rel=0.02)
    moved = displaced_elsewhere(quarter, one.displacements_mm, whole.nodes_mm, (0.0, 0.0))
    assert np.abs(moved - all_four.displacements_mm).max() < 0.01


def test_displacements_move_with_the_touch():
    block, indenter = design("footprint_mm=[12,12]"), place_object(BALL, gap_mm=-0.3)
    lattice = central_lattice(block, contact_zone([indenter], block), spacing_mm=1.0, is_quarter=True)
    state = solved(lattice, indenter)
    points = np.array([[0.3, -0.2, 0.0], [1.0, 1.5, 2.0]])
    here = displaced_elsewhere(lattice, state.displacements_mm, points, (0.0, 0.0))
    there = displaced_elsewhere(lattice, state.displacements_mm, points + np.array([2.0, -1.0, 0.0]), (2.0, -1.0))
    assert there == pytest.approx(here, abs=1e-12)
    assert here[0, 2] > 0.2


@pytest.mark.slow
def test_touch_half_way_to_the_sides_is_the_one_in_the_middle_moved():
    block, place = design("lattice.spacing_mm=0.5"), (6.0, 8.0)
    central, beside = (place_object(BALL, gap_mm=-0.3, x_mm=x, y_mm=y) for x, y in ((0.0, 0.0), place))
    lattice = central_lattice(block, contact_zone([central], block), spacing_mm=0.4, is_quarter=True)
    middle = solved(lattice, central)
    own = build_lattice(block, zone=contact_zone([beside], block))
    state = solved(own, beside)
    assert 4 * middle.force_n[2] == pytest.approx(state.force_n[2], rel=0.02)
    moved = displaced_elsewhere(lattice, middle.displacements_mm, own.nodes_mm, place)
    error = np.linalg.norm(moved - state.displacements_mm, axis=1)
    assert error.max() < 0.05 * np.abs(state.displacements_mm).max()
