import logging
import math

import pytest

from magicsim import load_design, load_object, press, press_curve
from magicsim.errors import ConfigError
from magicsim.geometry.limits import LimitsWatch, PressLimits

PUBLISHED = load_design("mini-magictac").limits
BLOCK = ["footprint_mm=[12,12]", "lattice.spacing_mm=2", "lattice.cells_across=0", "lattice.edge_nodes=0"]


def disc_mm2(radius_mm: float) -> float:
    return math.pi * radius_mm**2


@pytest.mark.parametrize("name", ["mini-magictac", "mini-magictac-finger", "mini-magictac-rate"])
def test_limits_are_those_of_the_published_protocol(name: str):
    limits = load_design(name).limits
    assert (limits.force_n, limits.depth_mm, limits.sharp_force_n, limits.sharp_depth_mm) == (6.0, 2.5, 3.0, 2.0)


@pytest.mark.parametrize(
    ("force_n", "depth_mm", "radius_mm", "said"),
    [
        (6.0, 2.5, 2.0, ""),
        (6.1, 2.5, 2.0, "6.1 N is above design.limits.force_n = 6, contact radius 2 mm"),
        (6.0, 2.6, 2.0, "2.6 mm is above design.limits.depth_mm = 2.5"),
        (3.1, 1.0, 1.51, ""),
        (3.1, 1.0, 1.49, "3.1 N is above design.limits.sharp_force_n = 3"),
        (3.1, 2.1, 0.5, "sharp_force_n = 3 and 2.1 mm is above design.limits.sharp_depth_mm = 2"),
        (0.0, 9.0, 0.0, ""),
    ],
)
def test_what_is_beyond_is_told_with_the_figure(force_n: float, depth_mm: float, radius_mm: float, said: str):
    found = PUBLISHED.excess(depth_mm=depth_mm, force_n=force_n, area_mm2=disc_mm2(radius_mm))
    assert said in found
    assert bool(said) == bool(found)


def test_design_without_limits_bears_everything():
    assert not PressLimits().excess(depth_mm=9.0, force_n=900.0, area_mm2=0.1)
    only = PressLimits(force_n=5.0)  # of sharp contacts too
    assert only.excess(depth_mm=9.0, force_n=6.0, area_mm2=0.1)


def test_sharp_limits_are_not_above_the_others():
    with pytest.raises(ConfigError, match=r"limits: sharp_force_n = 9 is not allowed: must be at most force_n = 6"):
        load_design("mini-magictac", ["limits.sharp_force_n=9"])


def test_it_warns_once(caplog: pytest.LogCaptureFixture):
    watch = LimitsWatch(PUBLISHED)
    for excess in ("", "7 N is above", "8 N is above"):
        watch.see(excess)
    assert [record.levelno for record in caplog.records] == [logging.WARNING]
    assert "7 N is above" in caplog.text


def test_press_beyond_the_limits_warns_with_the_figure(caplog: pytest.LogCaptureFixture):
    box, design = load_object("box:size_mm=6x6x6"), load_design("mini-magictac", BLOCK)
    found = press(design, box, depth_mm=1.0)
    assert found.force_n[2] > 6
    assert [
        f"{found.force_n[2]:.3g} N is above design.limits.force_n = 6" in each.message for each in caplog.records
    ] == [True]
    caplog.clear()
    press_curve(design, box, (0.5, 1.0))
    assert len(caplog.records) == 1
    caplog.clear()
    press(design, box, depth_mm=0.1)
    press(load_design("uniform-block", BLOCK), box, depth_mm=1.0)
    assert not caplog.records
