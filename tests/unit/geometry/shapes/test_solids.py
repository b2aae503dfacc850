import numpy as np
import pytest
import scipy.optimize
import trimesh

from magicsim.geometry.mesh import SurfaceMesh
from magicsim.geometry.objects.textured import RIDGE_SEGMENTS, DotPlate, Plate, RidgePlate
from magicsim.geometry.shapes.mesh_solid import MeshShape
from magicsim.geometry.shapes.revolved import cone, domed_cylinder
from magicsim.geometry.shapes.solids import SEGMENTS, RoundedBox, RoundedCylinder, Shape, Sphere

PLATE = Plate(size_mm=3.6, thickness_mm=1.2, edge_radius_mm=0.15)
CONVEX = {
    "sphere": Sphere(2.5),
    "box": RoundedBox((3.0, 4.0, 5.0), 0.4),
    "sharp box": RoundedBox((3.0, 2.0, 2.0), 0.02),
    "cylinder along x": RoundedCylinder(1.5, 4.0, "x", 0.3),
    "cylinder along y": RoundedCylinder(1.5, 4.0, "y", 0.3),
    "cylinder along z": RoundedCylinder(2.0, 1.5, "z", 0.5),
    "domed cylinder": domed_cylinder(1.2, 4.5, 0.2),
    "hemisphere": domed_cylinder(2.0, 2.3, 0.3),
    "pointed cone": cone(35.0, 3.0, tip_radius_mm=0.1, flat_radius_mm=0.0, edge_radius_mm=0.1),
    "cut cone": cone(20.0, 4.0, tip_radius_mm=0.1, flat_radius_mm=0.8, edge_radius_mm=0.15),
    "wide cone": cone(70.0, 1.1, tip_radius_mm=0.1, flat_radius_mm=0.0, edge_radius_mm=0.02),
}
ANALYTIC = CONVEX | {
    "dots": DotPlate(radius_mm=0.5, spacing_mm=1.15, plate=PLATE),
    "dots that leave no face": DotPlate(radius_mm=0.55, spacing_mm=1.1001, plate=PLATE),
    "ridges": RidgePlate(width_mm=0.6, spacing_mm=1.3, height_mm=0.8, edge_radius_mm=0.1, plate=PLATE),
    "round ridges": RidgePlate(width_mm=1.0, spacing_mm=1.6, height_mm=0.7, edge_radius_mm=0.35, plate=PLATE),
}
SAG_MM = {
    "dots": 2 * 0.5 * (1 - np.cos(np.pi / 32)),
    "dots that leave no face": 2 * 0.55 * (1 - np.cos(np.pi / 32)),
    "ridges": 2 * 0.1 * (1 - np.cos(np.pi / RIDGE_SEGMENTS)),
    "round ridges": 2 * 0.35 * (1 - np.cos(np.pi / RIDGE_SEGMENTS)),
}
"""Twice r (1 - cos(pi / segments)), as balls are faceted in two directions, where fewer segments are used."""


@pytest.fixture(params=[*ANALYTIC, "mesh"])
def shape(request: pytest.FixtureRequest) -> Shape:
    if request.param == "mesh":
        return MeshShape.of(RoundedBox((5.6, 5.7, 5.8), 0.4).mesh())
    return ANALYTIC[request.param]


@pytest.fixture(params=CONVEX.values(), ids=CONVEX.keys())
def convex_shape(request: pytest.FixtureRequest) -> Shape:
    return request.param


def cloud(count: int = 200) -> np.ndarray:
    """Points inside and outside of every shape above."""
    return np.random.default_rng(3).uniform(-3.2, 3.2, (count, 3))


def sag_mm(shape: Shape) -> float:
    """How far a faceted mesh may lie inside a curved surface."""
    if isinstance(shape, MeshShape):
        return 1e-9
    for name, sag in SAG_MM.items():
        if shape is ANALYTIC[name]:
            return sag
    size = max(shape.support_mm(axis) for axis in np.eye(3))
    return 3 * size * (1 - np.cos(np.pi / SEGMENTS)) + 0.02 * getattr(shape, "edge_radius_mm", 0.0)


def as_trimesh(mesh: SurfaceMesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices, mesh.faces, process=False)


def nearest_mm(mesh: trimesh.Trimesh, points: np.ndarray) -> np.ndarray:
    """Distance to the nearest of all triangles, by brute force."""
    triangles = np.asarray(mesh.triangles)
    return np.array(
        [
            np.linalg.norm(
                trimesh.triangles.closest_point(triangles, np.broadcast_to(point, (len(triangles), 3))) - point, axis=1
            ).min()
            for point in points
        ]
    )


def test_distance_is_that_to_the_nearest_triangle_of_the_mesh(shape: Shape):
    points = cloud(60)
    distance, _ = shape.distance(points)
    assert np.abs(distance) == pytest.approx(nearest_mm(as_trimesh(shape.mesh()), points), abs=sag_mm(shape))


def test_distance_is_negative_exactly_inside(shape: Shape):
    points = cloud()
    distance, _ = shape.distance(points)
    mesh = shape.mesh()
    clear = np.abs(distance) > sag_mm(shape)
    # Winding number by the solid angles of all triangles (Van Oosterom and Strackee 1983).
    a, b, c = (mesh.vertices[mesh.faces[:, k]][None] - points[clear][:, None] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    numerator = np.einsum("pti,pti->pt", a, np.cross(b, c))
    dots = [np.einsum("pti,pti->pt", *pair) for pair in ((a, b), (b, c), (c, a))]
    denominator = la * lb * lc + dots[0] * lc + dots[1] * la + dots[2] * lb
    winding = np.arctan2(numerator, denominator).sum(1) / (2 * np.pi)
    assert np.array_equal(distance[clear] < 0, winding > 0.5)
    assert 0.02 < (distance < 0).mean() < 0.98


def test_normal_is_a_unit_vector_equal_to_the_gradient_of_the_distance(shape: Shape):
    points = cloud()
    step = 1e-5
    forward = np.stack([shape.distance(points + step * axis)[0] for axis in np.eye(3)], 1)
    backward = np.stack([shape.distance(points - step * axis)[0] for axis in np.eye(3)], 1)
    gradient = (forward - backward) / (2 * step)
    smooth = np.abs(np.linalg.norm(gradient, axis=1) - 1) < 1e-3  # not on the medial axis
    _, normal = shape.distance(points)
    assert smooth.mean() > 0.95
    assert np.linalg.norm(normal, axis=1) == pytest.approx(np.ones(len(points)))
    assert normal[smooth] == pytest.approx(gradient[smooth], abs=2e-3)


def test_point_moved_by_its_distance_against_the_normal_lies_on_the_surface(shape: Shape):
    points = cloud()
    distance, normal = shape.distance(points)
    outside = distance > 0
    landed, _ = shape.distance((points - distance[:, None] * normal)[outside])
    assert landed == pytest.approx(np.zeros(outside.sum()), abs=1e-9)


def test_support_is_the_farthest_point_of_the_mesh(shape: Shape):
    vertices = shape.mesh().vertices
    for direction in np.random.default_rng(4).standard_normal((20, 3)):
        unit = direction / np.linalg.norm(direction)
        assert shape.support_mm(unit) == pytest.approx(float((vertices @ unit).max()), abs=sag_mm(shape))


def test_support_is_the_farthest_point_of_zero_distance(convex_shape: Shape):
    shape = convex_shape
    unit = np.array([0.48, -0.6, 0.64])

    def outside_mm(height: float) -> float:
        """Smallest distance on the plane at this height along the direction, searched from a grid."""
        side = np.cross(unit, [1.0, 0.0, 0.0])
        side /= np.linalg.norm(side)
        other = np.cross(unit, side)

        def at(uv: np.ndarray) -> float:
            return float(shape.distance((height * unit + uv[0] * side + uv[1] * other)[None])[0][0])

        starts = [np.array([u, v]) for u in np.linspace(-3, 3, 7) for v in np.linspace(-3, 3, 7)]
        best = min(starts, key=at)
        return float(scipy.optimize.minimize(at, best, method="Nelder-Mead", options={"xatol": 1e-9}).fun)

    support = shape.support_mm(unit)
    assert outside_mm(support + 1e-3) > 0
    assert outside_mm(support - 1e-3) < 0


def test_support_along_an_axis_is_half_the_size():
    box = RoundedBox((3.0, 4.0, 5.0), 0.4)
    assert [box.support_mm(axis) for axis in np.eye(3)] == pytest.approx([1.5, 2.0, 2.5])
    cylinder = RoundedCylinder(1.5, 4.0, "y", 0.3)
    assert [cylinder.support_mm(axis) for axis in np.eye(3)] == pytest.approx([1.5, 2.0, 1.5])


def test_mesh_is_closed_and_outward_with_vertices_on_the_surface(shape: Shape):
    mesh = shape.mesh()
    distance, _ = shape.distance(mesh.vertices)
    assert mesh.is_watertight()
    assert mesh.volume_mm3() > 0
    assert np.abs(distance).max() < sag_mm(shape)


def test_mesh_has_the_volume_of_the_solid():
    assert Sphere(2.5).mesh().volume_mm3() == pytest.approx(4 / 3 * np.pi * 2.5**3, rel=2e-3)
    assert RoundedCylinder(2.0, 3.0, "z", 0.01).mesh().volume_mm3() == pytest.approx(np.pi * 4 * 3, rel=2e-3)
    # A box rounded all over by Steiner's formula
    core, r = np.array([2.2, 3.2, 4.2]), 0.4
    faces = 2 * (core[0] * core[1] + core[1] * core[2] + core[2] * core[0])
    volume = core.prod() + r * faces + np.pi * r**2 * core.sum() + 4 / 3 * np.pi * r**3
    assert RoundedBox((3.0, 4.0, 5.0), 0.4).mesh().volume_mm3() == pytest.approx(volume, rel=2e-3)


def test_distance_at_the_middle_of_a_solid_is_finite():
    for each in ANALYTIC.values():
        distance, normal = each.distance(np.zeros((1, 3)))
        assert distance[0] < 0
        assert np.isfinite(normal).all()


def test_feature_is_the_radius_or_half_width_of_what_presses():
    features = {name: each.feature_mm for name, each in ANALYTIC.items()}
    assert features == pytest.approx({
        "sphere": 2.5,
        "box": 1.5,
        "sharp box": 1.0,
        "cylinder along x": 1.5,
        "cylinder along y": 1.5,
        "cylinder along z": 0.75,
        "domed cylinder": 1.2,
        "hemisphere": 2.0,
        "pointed cone": 0.1,
        "cut cone": 0.8,
        "wide cone": 0.1,
        "dots": 0.5,
        "dots that leave no face": 0.55,
        "ridges": 0.3,
        "round ridges": 0.3,
    })  # fmt: skip
