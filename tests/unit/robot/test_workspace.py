import pytest

from magicsim.errors import ConfigError
from magicsim.robot.live import LiveSensor
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim.scenes.timeline import FrameState

from .conftest import BLOCK


def state(**values: float) -> FrameState:
    base = {"gap_mm": 1.0, "x_mm": 0.0, "y_mm": 0.0, "twist_deg": 0.0, "flashlight": False, "light_x_mm": 0.0}
    return FrameState(**(base | values))


@pytest.mark.parametrize(
    ("field", "value", "allowed"),
    [("x_mm", 2.5, "-2 to 2"), ("y_mm", -3, "-2 to 2"), ("gap_mm", -2.1, "-2 to 30"), ("twist_deg", 91, "-90 to 90")],
)
def test_pose_outside_is_refused_with_its_range(field: str, value: float, allowed: str):
    with pytest.raises(ConfigError, match=f"{field} = {value:g} is not allowed: must be {allowed}, the workspace"):
        Workspace().check(state(**{field: value}))


def test_what_does_not_press_may_be_beyond_and_a_press_may_not():
    space = Workspace(beyond_mm=5.0)
    space.check(state(y_mm=6.9))
    space.check(state(y_mm=6.9, gap_mm=0.0))
    with pytest.raises(ConfigError, match=r"y_mm = 6\.9 is not allowed: must be -2 to 2"):
        space.check(state(y_mm=6.9, gap_mm=-1e-6))


def test_limits_themselves_and_a_state_without_an_object_are_inside():
    Workspace().check(state(x_mm=2.0, y_mm=-2.0, gap_mm=-2.0, twist_deg=90.0))
    Workspace().check(state(gap_mm=None, x_mm=99.0))


@pytest.mark.parametrize(
    ("limits", "why"),
    [
        ((1.0, 0.0), "smaller one first"),
        ((float("nan"), 1.0), "of at least -2000"),
        ((0.0, float("inf")), "at most 2000"),
        ((-1e6, 0.0), "of at least -2000"),
    ],
)
def test_limits_out_of_order_or_too_far_are_refused(limits: tuple[float, float], why: str):
    with pytest.raises(ConfigError, match=rf"workspace\.x_mm = .* {why}"):
        Workspace(x_mm=limits)


def test_press_deeper_than_the_block_allows_is_refused(tiny_scene: SceneConfig):
    with pytest.raises(ConfigError, match=r"workspace.gap_mm = -6.6 is not allowed: must be at least -5.94"):
        Workspace(gap_mm=(-6.6, 1)).states(tiny_scene)


def test_corners_span_every_range_and_the_twists_between():
    corners = Workspace(x_mm=(-1, 2), y_mm=(0, 0), twist_deg=(-40, 50), gap_mm=(-1, 5)).corners()
    assert {corner.x_mm for corner in corners} == {-1, 2}
    assert sorted({corner.twist_deg for corner in corners}) == [-40, -10, 20, 50]
    assert {corner.gap_mm for corner in corners} == {-1}
    assert len(set(corners)) == len(corners) == 8


def test_lattice_is_fine_wherever_the_object_can_touch():
    scene = load_scene("grip", BLOCK)
    narrow = LiveSensor(scene, workspace=Workspace(x_mm=(0, 0), y_mm=(0, 0), twist_deg=(0, 0), gap_mm=(-1, 1)))
    wide = LiveSensor(scene, workspace=Workspace(x_mm=(-1, 2), y_mm=(0, 0), twist_deg=(0, 0), gap_mm=(-1, 1)))
    inside, outside = narrow.sensor.lattice.zone, wide.sensor.lattice.zone
    assert outside.low_mm[0] == pytest.approx(inside.low_mm[0] - 1, abs=0.11)
    assert outside.high_mm[0] == pytest.approx(inside.high_mm[0] + 2, abs=0.11)
    assert inside.radius_mm == pytest.approx(7**0.5, abs=0.11)  # a ball of 4 mm, 1 mm deep: sqrt(2 * 4 * 1 - 1)
