import numpy as np
import pytest

from magicsim.config.models import load_preset
from magicsim.deform.indentation.bearing import Bearing, BearingPlace, onset
from magicsim.deform.indentation.press import press
from magicsim.errors import ConfigError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.objects.kinds import parse_object
from magicsim.sweep import mechanics
from magicsim.sweep.measures import SweepQuality
from magicsim.sweep.mechanics import durability, press_centrally, press_curve, spacing_error
from magicsim.sweep.parts import block_of
from magicsim.sweep.result import printability

BALL = parse_object("sphere:radius_mm=4")


def design(*settings: str) -> ElastomerDesign:
    return load_preset(ElastomerDesign, "design", "mini-magictac", settings)


def test_force_and_stiffness_are_read_off_the_press():
    depths, force = np.array([0.1, 0.5, 1.0]), np.array([0.1, 1.0, 3.0])
    found, stiffness = press_curve(depths, force, relative_error=0.1)
    assert (found.value, found.low, found.high) == pytest.approx((3.0, 2.7, 3.3))
    assert (stiffness.value, stiffness.low, stiffness.high) == pytest.approx((4.0, 3.6, 4.4))


def pressed_n(block: ElastomerDesign, cells_across: int) -> float:
    return float(press_centrally(block, BALL, 1.0, cells_across=cells_across).force_n[2])


@pytest.mark.slow
def test_error_of_a_force_covers_what_a_finer_lattice_changes():
    block = design("footprint_mm=[12,12]")
    force, finer = (pressed_n(block, cells) for cells in (8, 12))
    error = spacing_error(block, BALL, force, cells_across=8)
    assert 0 < error < 0.1
    assert abs(finer - force) / force < error


def test_error_of_a_force_shrinks_with_the_spacing():
    block = load_preset(ElastomerDesign, "design", "uniform-block", ("footprint_mm=[12,12]", "lattice.spacing_mm=3"))
    errors = [spacing_error(block, BALL, pressed_n(block, cells), cells_across=cells) for cells in (4, 12)]
    assert 0 < errors[1] < errors[0] < 1


def test_press_is_the_same_as_that_of_the_whole_block():
    block = load_preset(ElastomerDesign, "design", "uniform-block", ("footprint_mm=[12,12]", "lattice.growth=1"))
    whole = press(block, BALL, depth_mm=1.0).force_n[2]
    assert pressed_n(block, 8) == pytest.approx(whole, rel=0.05)


def test_object_that_does_not_touch_is_refused():
    with pytest.raises(ConfigError, match="does not reach the face"):
        press_centrally(design(), BALL, -1.0, cells_across=4)


def test_base_design_keeps_every_limit():
    found = printability(block_of(design()))
    assert (found.value, found.note) == (1.0, "")


def test_broken_limits_are_named():
    found = printability(block_of(design("skin_mm=2.0", "cell_mm=1.6")))
    assert found.value == pytest.approx(4 / 6)
    assert "recommended skin 0.5 to 1 mm, here 2" in found.note
    assert "printed cell 0.6 to 1 mm, here 1.57" in found.note


def test_block_without_a_grid_has_no_cells_to_judge():
    block = load_preset(ElastomerDesign, "design", "uniform-block", ())
    assert 0 < printability(block_of(block)).value <= 1


@pytest.fixture
def limits_asked(monkeypatch: pytest.MonkeyPatch) -> list[dict[str, object]]:
    """What the press that finds limits is asked for; forces are ten times the depths, shear is coarser by a tenth."""
    asked: list[dict[str, object]] = []

    def press_limits(block: ElastomerDesign, _: object, *, until: object, coarsening: float, told: object) -> Bearing:
        del told
        asked.append({"until": until, "limits": block.limits})
        shear, stretch = 0.01 * (1.1 if coarsening > 1 else 1), 0.5
        path = tuple(
            BearingPlace(
                depth_mm=depth, force_n=10 * depth, skin_stretch=1 + stretch * depth, skin_stress_mpa=0.1 * depth,
                infill_stress_mpa=shear * depth,
            )
            for depth in (1.0, 2.0)
        )  # fmt: skip
        strengths = [("yield", "infill_stress_mpa", each) for each in block.limits.infill_yield_mpa or ()]
        strengths += [("tear", "skin_stretch", 1 + each) for each in block.limits.elongation_at_break or ()]
        onsets = tuple(onset(path, *each) for each in strengths)
        return Bearing(onsets=onsets, history=path, stopped="no more", spacing_mm=0.2, skin_layers=2, seconds=0.0)

    monkeypatch.setattr(mechanics, "press_limits", press_limits)
    return asked


def test_what_fails_first_is_told_at_the_lowest_strengths(limits_asked: list[dict[str, object]]):
    wanted = ["force_at_yield_n", "force_at_tear_n", "safe_depth_mm", "shore_a"]
    found = durability(design("limits.infill_yield_mpa=[0.005,0.02]"), BALL, wanted)
    assert list(found) == wanted[:3]
    assert found["safe_depth_mm"].value == pytest.approx(0.5)
    yields = found["force_at_yield_n"]
    half = 5.0 - 5.0 / 1.1
    assert (yields.value, yields.low, yields.high) == pytest.approx((5.0, 5.0 - half, 5.0 + half))
    tear = found["force_at_tear_n"]  # a stretch of 3.2 is beyond the last place
    assert (tear.value, tear.low, tear.high) == (20.0, 20.0, None)
    assert tear.note == "at least: none down to 2 mm; no more"
    assert [each["until"] for each in limits_asked] == [{"yield", "tear"}] * 2
    assert limits_asked[0]["limits"].infill_yield_mpa == (0.005, 0.005)


def test_safe_depth_alone_ends_at_the_first_failure(limits_asked: list[dict[str, object]]):
    assert set(durability(design(), BALL, ["safe_depth_mm"])) == {"safe_depth_mm"}
    assert limits_asked[0]["until"] == set()


@pytest.mark.usefixtures("limits_asked")
def test_strength_that_a_design_does_not_say_leaves_a_gap_with_its_name():
    block = design()
    block = block.model_copy(update={"limits": block.limits.model_copy(update={"infill_yield_mpa": None})})
    found = durability(block, BALL, ["force_at_yield_n"])["force_at_yield_n"]
    assert (found.value, found.note) == (None, "the design's limits have no strength for yield")


def test_design_without_strengths_is_named_where_durability_is_wanted():
    block = load_preset(ElastomerDesign, "design", "uniform-block", ())
    found = durability(block, BALL, ["safe_depth_mm"])["safe_depth_mm"]
    assert found.value is None
    assert "the design says no strength: limits needs one of" in found.note


def test_face_that_no_durometer_takes_leaves_a_gap(monkeypatch: pytest.MonkeyPatch):
    def refuses(*_: object, **__: object) -> None:
        raise ConfigError("a durometer presses a plane or a crown")

    monkeypatch.setattr(mechanics, "durometer", refuses)
    found = mechanics.hardness(design(), SweepQuality())
    assert (found.value, found.note) == (None, "a durometer presses a plane or a crown")
