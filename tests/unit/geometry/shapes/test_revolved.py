import numpy as np
import pytest

from magicsim.geometry.shapes.revolved import cone, domed_cylinder


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
