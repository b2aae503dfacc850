"""What presses, shears or turns as its mirror image does gives forces and torques that are mirror images."""

from typing import Any

import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.path import PressResult
from magicsim.deform.indentation.press import press
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object

SMALL = (
    "footprint_mm=[10,10]", "skin_mm=1.0", "core_mm=4.0", "cell_mm=0.8", "wall_mm=0.2", "lattice.spacing_mm=1.0",
    "lattice.edge_nodes=150",
)  # fmt: skip
"""A block that is solved in a second."""
SHARE = 1e-3


def pressed(what: str, settings: tuple[str, ...], **options: Any) -> PressResult:
    design = load_preset(ElastomerDesign, "design", "mini-magictac", list(settings))
    return press(design, parse_object(what), told=lambda _: None, **options)


def assert_mirrored(here: PressResult, there: PressResult, width_mm: float) -> None:
    """In the plane x = 0; torques are measured by the force at the object's half width."""
    force, other = np.array(here.force_n), np.array(there.force_n) * [-1, 1, 1]
    torque, turned = np.array(here.torque_nmm), np.array(there.torque_nmm) * [1, -1, -1]
    size = float(np.linalg.norm(force))
    assert np.abs(force - other).max() < SHARE * size
    assert np.abs(torque - turned).max() < SHARE * size * width_mm / 2
    assert abs(torque[2] - turned[2]) < SHARE * abs(torque[2])


@pytest.mark.parametrize(
    ("size_mm", "depth_mm", "twist_deg", "friction", "settings"),
    [
        (2.0, 0.3, 20.0, 1.0, SMALL),
        pytest.param(4.0, 0.5, 20.0, 1.0, (), marks=pytest.mark.slow),
        pytest.param(4.0, 1.0, 10.0, 1.0, (), marks=pytest.mark.slow),
        pytest.param(3.0, 0.5, 35.0, 0.5, (), marks=pytest.mark.slow),
    ],
)
def test_box_turned_either_way(
    size_mm: float, depth_mm: float, twist_deg: float, friction: float, settings: tuple[str, ...]
) -> None:
    here, there = (
        pressed(f"box:size_mm={size_mm:g}", settings, depth_mm=depth_mm, twist_deg=sign * twist_deg, friction=friction)
        for sign in (1, -1)
    )
    assert_mirrored(here, there, size_mm)


@pytest.mark.slow
@pytest.mark.parametrize("depth_mm", [0.5, 1.0])
def test_centred_box_has_no_side(depth_mm: float) -> None:
    found = pressed("box:size_mm=3", (), depth_mm=depth_mm)
    assert np.abs(found.force_n[:2]).max() < SHARE * found.force_n[2]
    assert np.abs(found.torque_nmm).max() < SHARE * found.force_n[2] * 1.5
