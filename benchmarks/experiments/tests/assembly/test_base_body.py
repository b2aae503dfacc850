import numpy as np
import pytest

from magicsim_experiments.assembly.meeting import Jack
from magicsim_experiments.assembly.trial import APART_MM, HIGH_MM, base_body


def test_base_is_closed_and_its_mouth_and_hole_are_those_of_the_contact():
    jack, apart_mm = Jack(), 9.0
    body = base_body(jack, apart_mm=apart_mm)
    assert body.is_watertight()
    radial = np.hypot(body.vertices[:, 0], body.vertices[:, 2])
    is_hole = (radial < jack.radius_mm + jack.chamfer_mm + 0.01) & (body.vertices[:, 1] < jack.depth_mm + 1e-6)
    rim = body.vertices[is_hole]
    assert len(rim) > 60
    # A polygon of 32 sides is inside of its circle by half a per cent.
    assert np.abs(jack.distance(rim)[0]).max() < 0.005 * (jack.radius_mm + jack.chamfer_mm)
    mouth = body.vertices[body.vertices[:, 1] < 1e-9]
    assert np.abs(mouth[:, 2]).max() == pytest.approx(apart_mm / 2 - APART_MM)


def test_base_keeps_out_of_the_fingers_as_deep_as_the_ridge_is_high():
    body = base_body(Jack(), apart_mm=9.0)
    beside = body.vertices[np.abs(body.vertices[:, 2]) > 4.5]
    assert beside[:, 1].min() == pytest.approx(HIGH_MM)
