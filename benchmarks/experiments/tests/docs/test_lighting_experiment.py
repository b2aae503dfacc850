"""The measures of the lighting experiment on pictures whose answer is known, and the order of what was measured."""

import json

import numpy as np
import pytest

from magicsim.scenes.scene import load_scene

from .pages import DOCS, load

SCRIPT = load(DOCS / "lighting_experiment.py")


def test_even_grey_picture_is_even_and_without_disparity():
    image = np.full((64, 48, 3), 90, np.uint8)
    assert SCRIPT.unevenness(image) == pytest.approx([0, 0, 0], abs=1e-12)
    assert SCRIPT.disparity(image, np.ones((64, 48), bool)) == 0


def test_ramp_is_uneven_in_its_channel_alone():
    image = np.full((64, 96, 3), 100, np.uint8)
    image[..., 0] = np.linspace(20, 180, 96)
    red, green, blue = SCRIPT.unevenness(image)
    assert red > 0.1
    assert [green, blue] == pytest.approx([0, 0], abs=1e-12)


def test_change_is_told_by_channel_and_side():
    rest, where = np.full((40, 40, 3), 50, np.uint8), np.ones((40, 40), bool)
    touched = rest.copy()
    touched[:, 30:, 1] += 20
    touched[:8, :, 2] += 10
    change = SCRIPT.brightening(rest, touched, where)
    assert change["green"]["+x"] > 8
    assert change["green"]["-x"] == 0
    assert change["blue"]["+y"] > 3 > change["blue"]["-y"]
    assert not any(change["red"].values())


def test_lights_stand_where_the_page_says_and_brighten_their_own_sides():
    strips = {strip.side: strip.radiance for strip in load_scene("lighting").rig.strips}
    assert strips["-x"][2] > 0 == strips["-x"][1]
    assert strips["+x"][1] > 0 == strips["+x"][0]
    dark = json.loads((DOCS / "lighting-experiment.json").read_text(encoding="utf-8"))["two-pairs, dark"]
    change = dark["change around the contact, heavy"]
    assert change["green"]["+x"] == max(change["green"].values())
    assert change["red"]["+y"] == max(change["red"].values())
    assert change["blue"]["-x"] == max(change["blue"].values())
