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
