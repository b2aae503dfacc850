import numpy as np
import pytest

from magicsim.camera.effect_settings import Mjpeg
from magicsim.camera.exposure import through_mjpeg


def mjpeg(**settings) -> Mjpeg:
    return Mjpeg(kind="mjpeg", **settings)


def stripes(axis: int) -> np.ndarray:
    """Neighbouring rows or columns of two colours of one brightness."""
    place = np.indices((32, 32))[axis] % 2
    return np.where(place[..., None] == 0, [160, 100, 100], [90, 136, 100]).astype(np.uint8)


def contrast(image: np.ndarray, axis: int) -> float:
    redness = image[..., 0].astype(float) - image[..., 1]
    return float(np.abs(np.diff(redness, axis=axis)).mean() / 106)


@pytest.mark.parametrize(("chroma", "along_columns", "along_rows"), [("444", 1, 1), ("422", 1, 0), ("420", 0, 0)])
def test_colours_are_halved_where_the_sampling_says(chroma: str, along_columns: int, along_rows: int):
    found = mjpeg(quality=100, chroma=chroma)
    assert contrast(through_mjpeg(stripes(0), found), 0) == pytest.approx(along_columns, abs=0.1)
    assert contrast(through_mjpeg(stripes(1), found), 1) == pytest.approx(along_rows, abs=0.1)


def test_errors_grow_as_quality_falls_and_channels_stay_in_their_place():
    row, column = np.indices((64, 48))
    image = np.stack([60 + row, 60 + 2 * column, 120 - row // 2], -1).astype(np.uint8)
    image = np.clip(image + np.random.default_rng(1).normal(0, 2, image.shape), 0, 255).astype(np.uint8)
    errors = [np.abs(through_mjpeg(image, mjpeg(quality=q)).astype(float) - image).mean() for q in (98, 85, 50, 10)]
    assert errors == sorted(errors)
    assert errors[0] < 2


def test_an_even_frame_stays_even():
    flat = np.full((32, 24, 3), 90, np.uint8)
    assert (through_mjpeg(flat, mjpeg(quality=50)) == flat).all()
