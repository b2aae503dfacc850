"""Fields of a touch: what moves, moves in them as the camera sees it."""

import numpy as np
import pytest

from magicsim.camera.projection import project_px
from magicsim.deform.lattice.structure import build_lattice
from magicsim.emulator.fields import SHIFT_UNIT_MM, FieldMaker, Mirror, filled, mirrors_of
from magicsim.scenes.scene import load_scene

ROWS, COLUMNS = 320, 240
ROWS_OFF = np.zeros((ROWS, COLUMNS), bool)
WARPS, FINE = 3, 16
"""Planes that take the image along, and images of the camera's resolution among the fields."""


@pytest.fixture(scope="module")
def scene():
    return load_scene("pressed")


@pytest.fixture(scope="module")
def nodes(scene):
    return build_lattice(scene.design).nodes_mm


def maker_of(scene, nodes, image) -> FieldMaker:
    return FieldMaker.of(scene.design, scene.rig, nodes, image.astype(np.float32))


def unfolded(fields):
    """The images of the camera's resolution, shape (images, rows, columns)."""
    rows, columns = fields.shape[1:]
    parts = fields[: 4 * FINE].reshape(FINE, 2, 2, rows, columns)
    return parts.transpose(0, 3, 1, 4, 2).reshape(FINE, 2 * rows, 2 * columns)


def blob(place_px) -> np.ndarray:
    """A spot of light around a column and row, over an even ground."""
    row, column = np.indices((ROWS, COLUMNS))
    spot = np.exp(-((column - place_px[0]) ** 2 + (row - place_px[1]) ** 2) / (2 * 4.0**2))
    return np.repeat(1 + spot[..., None], 3, -1)


def test_where_nothing_moves_the_gate_is_shut_and_the_image_stays(scene, nodes):
    image = blob((100, 120))
    fields, gate = maker_of(scene, nodes, image).make(
        np.zeros_like(nodes, np.float32), image.astype(np.float32), ROWS_OFF
    )
    assert gate.max() == 0
    images = unfolded(fields)
    np.testing.assert_allclose(images[: 3 * WARPS], 0, atol=1e-5)
    np.testing.assert_allclose(images[3 * WARPS], image[..., 0] / image.mean() - 1, atol=1e-5)
    np.testing.assert_allclose(fields[4 * FINE :], 0)


@pytest.mark.parametrize("shift_mm", [(0.4, 0.0, 0.0), (0.0, -0.3, 0.0), (0.0, 0.0, 0.6)])
@pytest.mark.parametrize("plane", range(WARPS))
def test_a_plane_takes_the_image_along_as_the_camera_sees_it(scene, nodes, shift_mm, plane):
    # A spot that stands on the plane goes where `project_px` has its displaced place.
    heights = np.unique(np.round(nodes[:, 2], 5))
    z = heights[int(np.argmin(np.abs(heights - (0.12, 0.5, 0.88)[plane] * scene.design.height_mm)))]
    place = np.array([6.0, 8.0, z])
    before, after = (
        project_px(place + shift, scene.design, scene.rig.lens, scene.rig.camera) for shift in (0, np.array(shift_mm))
    )
    image = blob(before)
    moved = np.broadcast_to(np.array(shift_mm, np.float32), nodes.shape)
    fields, _ = maker_of(scene, nodes, image).make(moved, image.astype(np.float32), ROWS_OFF)
    warped = unfolded(fields)[3 * plane] * image.mean() + image[..., 0] - 1
    row, column = np.indices(warped.shape)
    found = np.array([(warped * column).sum(), (warped * row).sum()]) / warped.sum()
    assert np.linalg.norm(after - before) > 0.5
    np.testing.assert_allclose(found, after, atol=0.15)


def test_shifts_have_their_unit_and_the_gate_opens_with_them(scene, nodes):
    moved = np.zeros(nodes.shape, np.float32)
    moved[:, 0] = 0.15
    image = blob((100, 120))
    fields, gate = maker_of(scene, nodes, image).make(moved, image.astype(np.float32), ROWS_OFF)
    shifts = fields[4 * FINE :]
    np.testing.assert_allclose(shifts[0::3], 0.15 / SHIFT_UNIT_MM, rtol=1e-4)
    np.testing.assert_allclose(shifts[1::3], 0, atol=1e-6)
    assert 0.8 < gate.min() <= gate.max() < 1


def test_fields_are_filled_up_for_the_network():
    fields = np.arange(2 * 9 * 12, dtype=np.float32).reshape(2, 9, 12)
    full = filled(fields)
    assert full.shape == (2, 16, 16)
    np.testing.assert_array_equal(full[:, :9, :12], fields)
    np.testing.assert_array_equal(full[:, 9:, :12], np.broadcast_to(fields[:, -1:], (2, 7, 12)))


def test_the_default_rig_has_two_mirrors_of_which_one_swaps_red_and_blue(scene):
    assert mirrors_of(scene.rig) == (Mirror(axis=0, channels=(2, 1, 0)), Mirror(axis=1))
    askew = scene.rig.model_copy(update={"camera": scene.rig.camera.model_copy(update={"principal_offset_px": (3, 0)})})
    assert mirrors_of(askew) == ()
    red = scene.rig.strips[0].model_copy(update={"radiance": (5.0, 5.0, 0.0)})
    assert mirrors_of(scene.rig.model_copy(update={"strips": (red, *scene.rig.strips[1:])})) == (Mirror(axis=1),)


@pytest.mark.parametrize("mirror", [Mirror(axis=0, channels=(2, 1, 0)), Mirror(axis=1)])
def test_a_mirrored_touch_has_mirrored_fields(scene, nodes, mirror):
    rng = np.random.default_rng(1)
    x, y, z = (nodes / nodes.max(0)).T

    def touch(side):
        """A touch, or what its mirror image is."""
        u, v = (side * x, y) if mirror.axis == 0 else (x, side * y)
        moved = 0.3 * np.stack([u * v + 0.2 * u, u**2 - v, u + v**3 + z], 1)
        moved[:, mirror.axis] *= side
        row, column = np.indices((ROWS, COLUMNS)) / 40
        light = np.stack([np.sin(column + 2 * row) + 3, np.cos(row) + 2, np.sin(3 * column) + 4], -1)
        mask = np.hypot(column - 2, row - 3) < 1
        if side < 0:
            light = np.flip(light, 1 - mirror.axis)[..., list(mirror.channels)]
            mask = np.flip(mask, 1 - mirror.axis)
        maker = maker_of(scene, nodes, light)
        return maker.make(moved.astype(np.float32), (1.1 * light).astype(np.float32), mask)

    fields, gate = touch(1)
    other, other_gate = touch(-1)
    np.testing.assert_allclose(mirror.fields(fields), other, atol=2e-3)
    np.testing.assert_allclose(mirror.image(gate[None])[0], other_gate, atol=1e-4)
    image = rng.random((3, 4, 6)).astype(np.float32)
    np.testing.assert_array_equal(mirror.image(mirror.image(image)), image)
