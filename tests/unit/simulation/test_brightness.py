import logging

import numpy as np
import pytest

from magicsim.scenes.rig import LedStrip, Rig
from magicsim.simulation.stream import BrightnessWatch

LIT = Rig(schema_version=1, strips=(LedStrip(side="-x", radiance=(5.0, 5.0, 5.0)),))
DARK = Rig(schema_version=1, strips=())


def grey(level: float, *, white: float = 0.0) -> np.ndarray:
    image = np.full((10, 10, 3), level, np.uint8)
    image[: round(10 * white)] = 255
    return image


@pytest.mark.parametrize(
    ("rig", "image", "flashlight", "said"),
    [
        (LIT, grey(90), False, ""),
        (LIT, grey(90, white=0.5), True, ""),
        (LIT, grey(90, white=0.6), False, "rig.camera.exposure_grey = 90 is too bright"),
        (LIT, grey(90, white=0.6), True, "rig.flashlight.radiance = [1.0, 1.0, 1.0] is too bright"),
        (LIT, grey(0), False, "design.materials.infill.sigma_s_per_mm"),
        (DARK, grey(0), False, "no light of rig.strips, rig.leds and rig.ring shines"),
    ],
)
def test_black_and_saturated_frames_name_the_field(
    rig: Rig, image: np.ndarray, flashlight: bool, said: str, caplog: pytest.LogCaptureFixture
):
    caplog.set_level(logging.WARNING)
    watch = BrightnessWatch(rig=rig, lit=rig.lit(is_opaque=False))
    for index in (4, 5):
        watch.see(image, index=index, flashlight=flashlight)
    assert len(caplog.records) == bool(said)
    assert said in caplog.text
    assert not said or "frame 4 is" in caplog.text


@pytest.mark.parametrize(("gain", "told"), [(1e3, 0), (1e6, 1)])
def test_exposure_that_makes_up_for_lost_light_is_told(gain: float, told: int, caplog: pytest.LogCaptureFixture):
    caplog.set_level(logging.WARNING)
    BrightnessWatch(rig=LIT, lit=(True, True, True)).see_exposure(np.full(3, gain))
    assert len(caplog.records) == told
