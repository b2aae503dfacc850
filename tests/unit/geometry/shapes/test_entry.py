import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects.kinds import parse_object
from magicsim.geometry.shapes.entry import EntrySide
from magicsim.geometry.shapes.solids import RoundedCylinder

KINDS = (
    "punch:radius_mm=1",
    "punch:radius_mm=0.5,edge_radius_mm=0.02",
    "box:size_mm=3x4x5",
    "box:size_mm=3x4x5,roll_deg=90",
    "box:size_mm=3x4x5,roll_deg=20,pitch_deg=-10",
    "cylinder:radius_mm=1,length_mm=4",
    "domed_cylinder:radius_mm=0.5",
    "cone:half_angle_deg=30",
    "cone:half_angle_deg=17.5,flat_radius_mm=0.395,length_mm=3",
    "dots:radius_mm=0.2,spacing_mm=0.5",
    "lines:width_mm=0.3,spacing_mm=0.7",
)
PUNCH = RoundedCylinder(2.0, 10.0, "z", 0.1)
ENTERED = EntrySide(PUNCH, (0.0, 0.0, 1.0), shell_mm=0.05, reach_mm=0.5)


@pytest.fixture(params=KINDS)
def entered(request: pytest.FixtureRequest) -> EntrySide:
    shape = parse_object(request.param).shape()
    assert isinstance(shape, EntrySide)
    return shape


def at(inside_shaft_mm: float, below_face_mm: float) -> np.ndarray:
    """A point of the punch of radius 2 mm and length 10 mm."""
    return np.array([[2.0 - inside_shaft_mm, 0.0, 5.0 - below_face_mm]])


def near_top(shape: EntrySide, depth_mm: float, count: int = 4000) -> np.ndarray:
    """Points above a level of the solid's own up direction, inside and outside."""
    up = np.array(shape.up)
    points = np.random.default_rng(5).uniform(-1.5, 1.5, (count, 3))
    height = shape.support_mm(up) - depth_mm * np.random.default_rng(6).uniform(-0.2, 1, count)
    return points + (height - points @ up)[:, None] * up


def test_point_below_the_face_and_near_the_shaft_leaves_through_the_face():
    for inside, below in ((0.15, 0.3), (0.11, 0.5), (0.3, 0.45)):
        assert PUNCH.distance(at(inside, below))[1][0] == pytest.approx([1, 0, 0])
        gap, normal = ENTERED.distance(at(inside, below))
        assert gap[0] == pytest.approx(-below)
        assert normal[0] == pytest.approx([0, 0, 1])


@settings(deadline=None)
@given(inside=st.floats(-1, 0.05), below=st.floats(0.0, 8.0))
def test_point_barely_inside_the_shaft_keeps_it_as_nearest_feature(inside: float, below: float):
    gap, normal = ENTERED.distance(at(inside, below))
    nearest, direction = PUNCH.distance(at(inside, below))
    assert gap == nearest
    assert np.array_equal(normal, direction)


@settings(deadline=None)
@given(inside=st.floats(0.0, 1.9), below=st.floats(1.0, 4.0))
@example(inside=0.0625, below=1.0)
def test_point_far_below_the_face_leaves_through_the_nearest_surface(inside: float, below: float):
    # The rim lies up to its radius of 0.1 mm below the face
    point = at(inside, below + 0.1)
    assert ENTERED.distance(point)[0] == PUNCH.distance(point)[0]


def test_outside_and_in_the_shell_nothing_is_changed(entered: EntrySide):
    points = near_top(entered, 3.0)
    exact, direction = entered.solid.distance(points)
    gap, normal = entered.distance(points)
    kept = exact >= -entered.shell_mm
    assert kept.any()
    assert np.array_equal(gap[kept], exact[kept])
    assert np.array_equal(normal[kept], direction[kept])
    assert (gap[~kept] < 0).all()
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(len(points)))


@pytest.mark.parametrize("text", KINDS)
def test_step_onto_a_face_pushes_no_deep_point_down_or_sideways(text: str):
    placed = place_object(parse_object(text), gap_mm=-0.25)
    shell = placed.shape.shell_mm
    face = np.zeros((4000, 3))
    face[:, :2] = np.random.default_rng(7).uniform(-2, 2, (4000, 2))
    deep = face[placed.shape.solid.distance(placed.pose.to_object(face))[0] < -2 * shell]
    gap, normal = placed.distance(deep)
    flank = 0.25  # sine of the steepest flank above, of the cut cone
    assert (normal[:, 2] > flank).all()
    assert (gap > -0.25 - 1e-9).all()


def test_nearest_features_alone_would_push_deep_points_sideways():
    placed = place_object(parse_object("punch:radius_mm=1"), gap_mm=-0.25)
    face = np.zeros((4000, 3))
    face[:, :2] = np.random.default_rng(7).uniform(-2, 2, (4000, 2))
    distance, normal = placed.shape.solid.distance(placed.pose.to_object(face))
    assert (np.abs(normal[distance < -0.1, 2]) < 0.1).any()


def test_rise_to_the_surface_ends_on_the_surface(entered: EntrySide):
    points = near_top(entered, 0.5)
    points = points[entered.solid.distance(points)[0] < 0]
    way, normal = entered.rise_to_surface(points)
    found = way <= 0.4
    assert found.mean() > 0.3
    landed, outward = entered.solid.distance((points + way[:, None] * np.array(entered.up))[found])
    assert np.abs(landed).max() < 1e-8
    assert np.abs(np.einsum("pi,pi->p", outward, normal[found]) - 1).max() < 1e-5


def test_rise_to_the_surface_is_the_first_crossing_along_the_approach():
    shape = parse_object("cone:half_angle_deg=30").shape()
    assert isinstance(shape, EntrySide)
    apex = 2.5 - 0.05 + 0.05 / np.sin(np.radians(30))
    points = np.array([[0.3, 0.0, apex - 0.3 / np.tan(np.radians(30)) - 0.17]])
    way, normal = shape.rise_to_surface(points)
    assert way[0] == pytest.approx(0.17)
    assert normal[0] == pytest.approx([np.cos(np.radians(30)), 0, 0.5])
    # The vertical way times the slope is the distance to a plane
    assert shape.distance(points)[0][0] == pytest.approx(-0.17 * 0.5)


def test_on_the_axis_of_a_cone_the_normal_points_up_and_does_not_flip():
    shape = parse_object("cone:half_angle_deg=20").shape()
    for depth in (0.06, 0.1, 0.2, 0.35):
        x = np.array([-1e-3, -1e-9, 0.0, 1e-9, 1e-3])
        points = np.stack([x, 0 * x, np.full(5, 2.5 - depth)], 1)
        gap, normal = shape.distance(points)
        assert normal[2] == pytest.approx([0, 0, 1])
        assert normal[:, 2].min() > 0.95
        assert normal[0] == pytest.approx(normal[4] * [-1, 1, 1])
        assert gap[0] == pytest.approx(gap[4])


def test_gap_and_normal_are_continuous_where_a_load_step_can_carry_a_point(entered: EntrySide):
    up = np.array(entered.up)
    points = near_top(entered, 0.4 * entered.reach_mm, 2000)
    step = 1e-6
    for direction in (*np.eye(3), up):
        gap, normal = entered.distance(points)
        moved_gap, moved_normal = entered.distance(points + step * direction)
        # Ramps over the shell are steep, jumps are none
        assert np.abs(moved_gap - gap).max() < 1e-3
        jump = np.linalg.norm(moved_normal - normal, axis=1)
        deep = entered.solid.distance(points)[0] < -2 * entered.shell_mm
        assert jump[deep].max(initial=0) < 1e-2


def test_gap_has_the_normal_as_its_gradient_below_a_flat_face():
    points = np.random.default_rng(8).uniform([-1.3, -1.3, 4.55], [1.3, 1.3, 4.88], (200, 3))
    step = 1e-6
    gradient = np.stack(
        [
            (ENTERED.distance(points + step * a)[0] - ENTERED.distance(points - step * a)[0]) / (2 * step)
            for a in np.eye(3)
        ],
        axis=1,
    )
    assert gradient == pytest.approx(ENTERED.distance(points)[1], abs=1e-6)


def test_support_mesh_and_feature_are_those_of_the_solid():
    up = np.array([0.0, 0.0, 1.0])
    assert ENTERED.support_mm(up) == PUNCH.support_mm(up)
    assert ENTERED.feature_mm == PUNCH.feature_mm
    assert np.array_equal(ENTERED.mesh().vertices, PUNCH.mesh().vertices)
