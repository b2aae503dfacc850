"""A press that takes time: rate, relaxation, and its refusals."""

from itertools import pairwise

import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.press import PressResult, press
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object

BALL = parse_object("sphere:radius_mm=4")


def block(prony: str = "[{time_s=0.5,modulus_mpa=1.0},{time_s=20.0,modulus_mpa=1.0}]") -> ElastomerDesign:
    return load_preset(
        ElastomerDesign, "design", "uniform-block",
        ["footprint_mm=[10,10]", "lattice.cells_across=0",
         "materials.body.poisson_ratio=0.499", "materials.body.youngs_modulus_mpa=1.0",
         f"materials.body.prony={prony}"],
    )  # fmt: skip


def timed(speed_mm_s: float, hold_s: float = 0.0) -> PressResult:
    return press(block(), BALL, depth_mm=0.4, speed_mm_s=speed_mm_s, hold_s=hold_s, tolerance_mm=5e-4)


def test_faster_is_stiffer_between_the_long_term_and_the_instantaneous_response() -> None:
    slow, fast, still = timed(1e-4), timed(1e3), press(block(), BALL, depth_mm=0.4)
    middle = timed(0.4)
    assert slow.force_n[2] == pytest.approx(still.force_n[2], rel=0.02)
    assert fast.force_n[2] == pytest.approx(3 * still.force_n[2], rel=0.02)
    assert slow.force_n[2] < middle.force_n[2] < fast.force_n[2]


def test_force_relaxes_at_hold_to_the_long_term_one() -> None:
    held, still = timed(1.0, hold_s=500.0), press(block(), BALL, depth_mm=0.4)
    forces = [moment.force_n[2] for moment in held.history if moment.time_s > 0.39]
    assert all(later <= earlier * (1 + 1e-3) for earlier, later in pairwise(forces))
    assert forces[0] > 1.8 * still.force_n[2]
    assert forces[-1] == pytest.approx(still.force_n[2], rel=0.02)
    assert held.history[-1].time_s == pytest.approx(500.4)


@pytest.mark.parametrize(
    ("prony", "options", "message"),
    [
        ("[]", {"speed_mm_s": 1.0}, "prony is missing"),
        ("[{time_s=1.0,modulus_mpa=300.0}]", {"speed_mm_s": 1.0}, "poisson_ratio = 0.499 is not allowed"),
        ("[{time_s=1.0,modulus_mpa=1.0}]", {"hold_s": 1.0}, "hold_s = 1 is not allowed without speed_mm_s"),
        ("[{time_s=1.0,modulus_mpa=1.0}]", {"speed_mm_s": 1.0, "twist_deg": 5.0}, "twist_deg = 5 is not allowed"),
    ],
)
def test_refusals_say_what_is_wrong(prony: str, options: dict[str, float], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        press(block(prony), BALL, depth_mm=0.3, **options)  # type: ignore[arg-type]
