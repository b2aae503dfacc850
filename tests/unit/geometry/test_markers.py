"""Where dots and pictures are, and which do not fit."""

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import cKDTree

from magicsim.geometry.markers import DotMarkers, PictureMarkers

FACE = (24.0, 32.0)


def dots(pattern, **changes):
    return DotMarkers(kind="dots", **{"pattern": pattern, "pitch_mm": 2.0, "diameter_mm": 1.0} | changes)


@pytest.mark.parametrize("pattern", ["square", "hexagonal"])
def test_regular_dots_are_a_pitch_apart_and_symmetric(pattern):
    places = dots(pattern).centres_mm(FACE)
    nearest = cKDTree(places).query(places, 2)[0][:, 1]
    np.testing.assert_allclose(nearest, 2.0, atol=1e-9)
    for mirror in ([-1, 1], [1, -1]):
        assert cKDTree(places).query(places * mirror)[0].max() < 1e-9
    assert np.abs(places).max(0) + 0.5 + 0.5 == pytest.approx(np.array(FACE) / 2, abs=2.0)


def test_random_dots_do_not_overlap_and_follow_their_seed():
    places = dots("random", seed=3).centres_mm(FACE)
    assert cKDTree(places).query(places, 2)[0][:, 1].min() > 1.0
    np.testing.assert_array_equal(places, dots("random", seed=3).centres_mm(FACE))
    assert len(places) == pytest.approx(23 * 31 / 4 - 30, abs=30)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"diameter_mm": 2.5}, r"diameter_mm = 2.5 is not allowed: must be below pitch_mm = 2"),
        ({"margin_mm": 12.0}, "markers lie outside of the face"),
        ({"depth_mm": 7.0}, "depth_mm = 7 is not allowed"),
        ({"pitch_mm": 0.2, "diameter_mm": 0.1, "margin_mm": 0.0}, None),
    ],
)
def test_dots_that_do_not_fit_are_told(changes, said):
    problem = dots("square", **changes).problem(FACE, 6.6)
    assert problem is None if said is None else said.replace("\\", "") in problem


def test_picture_has_a_marker_for_each_spot(tmp_path):
    pixels = np.zeros((20, 40, 4), np.uint8)
    pixels[2:6, 4:8, 3] = pixels[12:16, 30:34, 3] = 255
    path = tmp_path / "spots.png"
    Image.fromarray(pixels).save(path)
    picture = PictureMarkers(kind="picture", file=str(path), width_mm=8.0)
    np.testing.assert_allclose(picture.centres_mm(FACE), [[-2.8, 1.2], [2.4, -0.8]], atol=1e-9)
    assert picture.is_grey
    assert "outside" in str(picture.model_copy(update={"width_mm": 30.0}).problem(FACE, 6.6))
    assert "'none.png' does not exist (paths start" in str(
        picture.model_copy(update={"file": "none.png"}).problem(FACE, 6.6)
    )
