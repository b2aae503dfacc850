import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from magicsim.geometry.shapes.revolved import Arc, ConvexProfile, cone, domed_cylinder


def sampled(profile: ConvexProfile, step_mm: float = 1e-3) -> np.ndarray:
    """Points on arcs and segments, drawn from the definition alone: where the outward normal has each angle."""
    pieces, start, previous = [], -90.0, None
    for arc in profile.arcs:
        angles = np.radians(np.linspace(start, arc.end_deg, 2 + int(np.radians(180) * arc.radius_mm / step_mm)))
        circle = [arc.radial_mm, arc.axial_mm] + arc.radius_mm * np.stack([np.cos(angles), np.sin(angles)], 1)
        begin = circle[0] * [0, 1] if previous is None else previous
        pieces += [np.linspace(begin, circle[0], 2 + int(np.linalg.norm(circle[0] - begin) / step_mm)), circle]
        start, previous = arc.end_deg, circle[-1]
    pieces.append(np.linspace(previous, previous * [0, 1], 2 + int(previous[0] / step_mm)))
    return np.concatenate(pieces)


PROFILES = {
    "ball": ConvexProfile((Arc(radial_mm=0.0, axial_mm=0.3, radius_mm=1.0, end_deg=90.0),)),
    "dome": domed_cylinder(1.2, 3.0, 0.2).profile,
    "pointed": cone(25.0, 3.0, tip_radius_mm=0.1, flat_radius_mm=0.0, edge_radius_mm=0.05).profile,
    "cut": cone(60.0, 2.0, tip_radius_mm=0.1, flat_radius_mm=0.5, edge_radius_mm=0.1).profile,
}


@pytest.fixture(params=PROFILES.values(), ids=PROFILES.keys())
def profile(request: pytest.FixtureRequest) -> ConvexProfile:
    return request.param


def test_distance_is_that_to_the_nearest_point_of_the_curve(profile: ConvexProfile):
    places = np.random.default_rng(0).uniform([0, -2.5], [3.5, 2.5], (300, 2))
    curve = sampled(profile)
    brute = np.array([np.linalg.norm(curve - place, axis=1).min() for place in places])
    distance, _ = profile.distance(places)
    assert np.abs(distance) == pytest.approx(brute, abs=1e-4)


def test_sign_tells_the_inside_of_the_hull(profile: ConvexProfile):
    places = np.random.default_rng(1).uniform([0, -2.5], [3.5, 2.5], (300, 2))
    angles = np.radians(np.linspace(-90, 90, 2001))
    support = np.array([profile.support_mm(np.cos(a), np.sin(a)) for a in angles])
    beyond = (places @ np.stack([np.cos(angles), np.sin(angles)]) - support).max(axis=1)
    distance, _ = profile.distance(places)
    clear = np.abs(distance) > 1e-3
    assert np.array_equal(distance[clear] > 0, beyond[clear] > 0)


def test_polyline_runs_from_axis_to_axis_on_the_curve(profile: ConvexProfile):
    line = profile.polyline()
    distance, _ = profile.distance(line)
    assert np.abs(distance).max() < 1e-12
    assert line[[0, -1], 0].tolist() == [0, 0]
    assert (np.diff(line[:, 1]) >= -1e-12).all()


@settings(deadline=None, max_examples=60)
@given(
    half_angle=st.floats(1, 80),
    length=st.floats(1, 10),
    tip=st.floats(0.01, 0.3),
    edge=st.floats(0.01, 0.1),
)
def test_pieces_of_a_cone_meet_without_a_gap_or_a_corner(half_angle: float, length: float, tip: float, edge: float):
    profile = cone(half_angle, length, tip_radius_mm=tip, flat_radius_mm=0.0, edge_radius_mm=edge).profile
    assume(profile.arcs[0].radial_mm > 0)
    curve = sampled(profile, step_mm=0.01)
    distance, normal = profile.distance(curve)
    assert np.abs(distance).max() < 1e-9
    step = np.linalg.norm(np.diff(curve, axis=0), axis=1)
    turn = np.linalg.norm(np.diff(normal, axis=0), axis=1)
    assert (turn <= step / min(tip, edge) + 1e-6).all()
    assert profile.support_mm(0.0, 1.0) == pytest.approx(length / 2)
    assert profile.support_mm(0.0, -1.0) == pytest.approx(length / 2)


def test_domed_cylinder_is_a_ball_above_and_a_shaft_below():
    solid = domed_cylinder(1.5, 6.0, 0.1)
    rng = np.random.default_rng(0)
    above = rng.uniform([-3, -3, 1.5], [3, 3, 4], (100, 3))
    assert solid.distance(above)[0] == pytest.approx(np.linalg.norm(above - [0, 0, 1.5], axis=1) - 1.5)
    angle = rng.uniform(0, 2 * np.pi, 100)
    beside = np.stack([2 * np.cos(angle), 2 * np.sin(angle), rng.uniform(-2.9, 1.5, 100)], 1)
    distance, normal = solid.distance(beside)
    assert distance == pytest.approx(np.full(100, 0.5))
    assert normal == pytest.approx(beside * [0.5, 0.5, 0])


def test_cone_is_a_plane_along_its_flank():
    half = np.radians(25.0)
    solid = cone(25.0, 4.0, tip_radius_mm=0.05, flat_radius_mm=0.0, edge_radius_mm=0.02)
    apex = 2.0 - 0.05 + 0.05 / np.sin(half)  # of the flank's straight continuation
    for depth in (0.3, 1.0, 2.5):
        on_flank = np.array([depth * np.tan(half), 0.0, apex - depth])
        outward = np.array([np.cos(half), 0.0, np.sin(half)])
        for gap in (0.7, 0.0, -0.02):
            distance, normal = solid.distance((on_flank + gap * outward)[None])
            assert distance[0] == pytest.approx(gap, abs=1e-12)
            assert normal[0] == pytest.approx(outward)


def test_cut_cone_ends_where_its_flank_meets_the_flat_end():
    solid = cone(17.5, 3.0, tip_radius_mm=0.05, flat_radius_mm=0.395, edge_radius_mm=1e-6)
    corner = np.array([[0.395, 0.0, 1.5]])
    assert solid.distance(corner)[0] == pytest.approx([0.0], abs=1e-6)
    assert solid.distance(np.array([[0.2, 0.1, 1.7]]))[0] == pytest.approx([0.2])
    assert solid.support_mm(np.array([1.0, 0.0, 0.0])) == pytest.approx(0.395 + 3 * np.tan(np.radians(17.5)), abs=1e-5)


def test_meshes_have_the_volume_of_the_solids():
    ball, shaft = 2 / 3 * np.pi * 1.5**3, np.pi * 1.5**2 * 4.5
    assert domed_cylinder(1.5, 6.0, 1e-3).mesh().volume_mm3() == pytest.approx(ball + shaft, rel=1e-3)
    low = 0.5 + 3.0 * np.tan(np.radians(30))
    frustum = np.pi * 3.0 / 3 * (low**2 + low * 0.5 + 0.25)
    cut = cone(30.0, 3.0, tip_radius_mm=0.1, flat_radius_mm=0.5, edge_radius_mm=1e-3)
    assert cut.mesh().volume_mm3() == pytest.approx(frustum, rel=1e-3)
    sharp = np.pi * 3.0 / 3 * (3.0 * np.tan(np.radians(30))) ** 2
    pointed = cone(30.0, 3.0, tip_radius_mm=1e-3, flat_radius_mm=0.0, edge_radius_mm=1e-3)
    assert pointed.mesh().volume_mm3() == pytest.approx(sharp, rel=2e-3)


def test_normal_on_the_axis_is_a_unit_vector():
    for solid in (
        domed_cylinder(1.0, 6.0, 0.1),
        cone(30.0, 6.0, tip_radius_mm=0.1, flat_radius_mm=0, edge_radius_mm=0.1),
    ):
        axis = np.stack([np.zeros(41), np.zeros(41), np.linspace(-3.5, 3.5, 41)], 1)
        _, normal = solid.distance(axis)
        assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(41))
        assert normal[-1] == pytest.approx([0, 0, 1])
