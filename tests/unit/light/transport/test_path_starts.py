"""Camera samples are spread over their pixel, along columns, along rows and over the area."""

import numpy as np
import pytest

from magicsim.camera.camera import Window
from magicsim.light.backend import mi
from magicsim.light.transport.path_starts import CameraStarts

COLUMNS, ROWS, SAMPLES = 6, 4, 16


def places(*, pattern=0, window=Window.whole(COLUMNS, ROWS)):  # noqa: B008
    """Places of the samples in their pixels, in units of a pixel, shape (samples, pixels, 2)."""
    camera = mi.load_dict(
        {"type": "perspective", "fov": 90, "film": {"type": "hdrfilm", "width": COLUMNS, "height": ROWS}}
    )
    pixels = window.numbers(COLUMNS, ROWS)
    starts = CameraStarts.of(camera, samples=SAMPLES, pixels=pixels, pattern=pattern, part=range(SAMPLES))
    found = []
    for number in range(SAMPLES):
        direction = np.array(starts.ray(mi.UInt32(number)).d)
        # A perspective camera looks along +z, with +x to the left of its image and 90 degrees across the columns.
        slopes = -direction[:2] / direction[2]
        found.append((slopes * COLUMNS / 2 + np.array([[COLUMNS / 2], [ROWS / 2]])).T)
    pixels = np.floor(np.mean(found, axis=0))
    return np.array(found) - pixels


def test_every_power_of_two_has_a_sample_in_each_column_and_row_of_a_pixel():
    for count in (2, 4, 8, 16):
        strips = np.sort(np.floor(places()[:count] * count), axis=0)
        np.testing.assert_array_equal(strips, np.broadcast_to(np.arange(count)[:, None, None], strips.shape))


def test_sixteen_samples_fill_the_cells_of_four_by_four():
    cells = np.sort((np.floor(places() * 4) @ [1, 4]), axis=0)
    np.testing.assert_array_equal(cells, np.broadcast_to(np.arange(16)[:, None], cells.shape))


def test_a_window_has_the_samples_of_the_whole_image():
    whole = places().reshape(SAMPLES, ROWS, COLUMNS, 2)
    part = places(window=Window(column=2, row=1, columns=3, rows=2))
    np.testing.assert_array_equal(part, whole[:, 1:3, 2:5].reshape(SAMPLES, -1, 2))


def test_patterns_of_pixels_and_of_images_differ():
    first, other = places(), places(pattern=1)
    assert len(np.unique(first[0], axis=0)) == COLUMNS * ROWS
    assert np.abs(first - other).mean() == pytest.approx(1 / 3, abs=0.05)
