import numpy as np
import pytest

from magicsim.geometry.mesh import SurfaceMesh
from magicsim.light.facing.finger import APART_MM, HOUSING, FingerBody, all_placed, with_object
from magicsim.light.world.finish import GREY, Finish

BODY = FingerBody.of((4.0, 6.0), 10.0)
TRIANGLE = SurfaceMesh(vertices=np.eye(3), faces=np.array([[0, 1, 2]], np.int32))


def areas(mesh: SurfaceMesh) -> np.ndarray:
    a, b, c = (mesh.vertices[mesh.faces[:, k]] for k in range(3))
    return np.cross(b - a, c - a) / 2


def test_body_is_a_closed_box_with_its_face_up():
    vectors = areas(BODY.mesh)
    np.testing.assert_allclose(vectors.sum(0), 0, atol=1e-12)
    assert np.linalg.norm(vectors, axis=1).sum() == pytest.approx(2 * (4 * 6 + 4 * 10 + 6 * 10))
    face = vectors[: 2 * BODY.counts[0] * BODY.counts[1]]
    assert (face[:, 2] > 0).all()
    assert face[:, 2].sum() == pytest.approx(24)


def test_squares_keep_their_places():
    values = np.arange(np.prod(BODY.counts), dtype=float).reshape(*BODY.counts, 1)
    of_triangles = BODY.triangles(values)
    centres = BODY.mesh.vertices[BODY.mesh.faces].mean(1)
    for i, j in ((0, 0), (1, 2)):
        low = np.array([-2 + 2 * i, -3 + 2 * j])
        inside = ((centres[:, :2] > low) & (centres[:, :2] < low + 2)).all(1) & (np.abs(centres[:, 2]) < 1e-9)
        assert (of_triangles[inside] == values[i, j]).all()


def test_object_and_finger_keep_their_colours_and_a_missing_object_has_no_surface():
    mesh, finish = with_object(BODY, TRIANGLE, Finish(color=(0.1, 0.2, 0.3), specular=0.4), np.array([0.3, 0.2, 0.1]))
    assert finish.vertex_colors
    assert finish.specular == 0.4
    assert mesh.colors is not None
    assert mesh.colors[0] == pytest.approx([0.1, 0.2, 0.3])
    assert mesh.colors[3] == pytest.approx([0.3, 0.2, 0.1])
    assert mesh.colors[-1] == pytest.approx([HOUSING] * 3)
    assert mesh.vertices[3:, 2].max() == -APART_MM
    placed = all_placed(BODY, 5.0, (None, 3))
    assert np.ptp(placed[:3], axis=0) == pytest.approx([0, 0, 0])
    assert -15 < placed[0, 2] < -5
    assert placed[3:, 2].max() == -5


def test_companion_stands_between_object_and_finger_in_the_mesh():
    skin = SurfaceMesh(vertices=2 * np.eye(3), faces=TRIANGLE.faces, colors=np.full((3, 3), 0.6))
    mesh, _ = with_object(BODY, TRIANGLE, Finish(), np.full(3, 0.3), skin)
    assert mesh.colors is not None
    assert mesh.colors[[0, 3, 6]] == pytest.approx(np.array([[0.7] * 3, [0.6] * 3, [0.3] * 3]))
    np.testing.assert_array_equal(mesh.faces[:3], [[0, 1, 2], [3, 4, 5], BODY.mesh.faces[0] + 6])
    assert mesh.vertices[3:6, 2].max() < mesh.vertices[6:, 2].min()
    grey, _ = with_object(BODY, TRIANGLE, Finish(), np.full(3, 0.3), TRIANGLE)
    assert grey.colors is not None
    assert grey.colors[3] == pytest.approx(GREY)
    placed = all_placed(BODY, 5.0, (np.eye(3), 3), (None, 3))
    np.testing.assert_array_equal(placed[:3], np.eye(3))
    assert np.ptp(placed[3:6], axis=0) == pytest.approx([0, 0, 0])
