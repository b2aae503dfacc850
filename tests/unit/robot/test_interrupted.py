"""A sensor and a gripper come to the very bytes that they would have, whatever interrupted them before."""

from collections.abc import Callable

import numpy as np
import pytest
from laboratory.interrupts import Step, differences

from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.load import Load
from magicsim.robot.gripper import Gripper
from magicsim.robot.live import LiveSensor, live_sensor
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import load_scene
from magicsim.simulation.episode import SimulatedFrame

from .conftest import RANGE, TINY

SMALL = [*TINY, "design.lattice.spacing_mm=4", "design.footprint_mm=[8,8]", "object.radius_mm=3"]
SIZES = [1, pytest.param(None, marks=pytest.mark.slow)]
"""Lines of each step that are interrupted: some, or every one of the functions that keep anything."""
SPACE = Workspace(
    x_mm=(-1, 1), y_mm=(-1, 1), twist_deg=(-20, 20), tilt_x_deg=(-9, 9), tilt_y_deg=(-9, 9), gap_mm=(-1.2, 5)
)


def state_of(live: LiveSensor) -> bytes:
    found = live.deformation
    arrays = (found.displacements_mm, found.force_n, found.torque_nmm, found.contact_pressure_mpa, found.anchors_mm)
    stream = (live.slid_mm, live.frame_index, live.time_s, live.state)
    return b"".join(np.ascontiguousarray(each).tobytes() for each in arrays) + repr(stream).encode()


def picture(*frames: SimulatedFrame) -> bytes:
    return b"".join(each.image.tobytes() + repr(each.truth).encode() for each in frames)


def script(told: Callable[[], bytes], **actions: Callable[[], object]) -> dict[str, Step]:
    """Steps that each act and say what there is then; a frame is bytes itself."""

    def step(act: Callable[[], object]) -> Step:
        def acted() -> bytes:
            found = act()
            return told() + (found if isinstance(found, bytes) else repr(found).encode())

        return acted

    return {name: step(act) for name, act in actions.items()}


@pytest.mark.parametrize("most", SIZES)
def test_interrupted_sensor_gives_the_same_forces_and_pictures(most: int | None):
    with live_sensor("pressed", [*SMALL, "contact.friction=0.5"], workspace=RANGE) as live:
        steps = script(
            lambda: state_of(live),
            begins=live.reset,
            presses=lambda: live.move_to(gap_mm=-0.6, x_mm=0.0, y_mm=0.0),
            shears=lambda: live.move_to(x_mm=0.4),
            shines=lambda: live.shine(x_mm=1.0),
            sheared=lambda: picture(live.frame()),
            releases=lambda: live.move_to(gap_mm=0.5),
            dims=lambda: live.set_led_strength(0.5, 1, 1),
            released=lambda: picture(live.frame()),
            takes_away=live.remove_object,
        )
        if most is None:
            steps |= script(lambda: state_of(live), untouched=lambda: picture(live.frame()))
        assert differences(steps, most=most) == []


@pytest.mark.slow
@pytest.mark.parametrize("most", [1, None])
def test_interrupted_gripper_keeps_both_fingers(most: int | None):
    with Gripper(load_scene("grip", SMALL), workspace=SPACE, sees_other=False) as grip:

        def pictures() -> bytes:
            frames = grip.frames()
            return picture(frames.upper, frames.lower)

        width = grip.touching_width_mm
        steps = script(
            lambda: b"".join(map(state_of, grip.fingers)) + repr(grip.truth()).encode(),
            begins=grip.reset,
            closes=lambda: grip.close(width - 0.8, place=ObjectPlace(x_mm=0.2)),
            closed=pictures,
            holds=lambda: grip.hold(width - 0.8, load=Load(weight_n=0.2)),
            turns=lambda: grip.turn_to(grip.linkage.angle_deg(width - 1.0), dt_s=1.0),
            takes_away=grip.remove_object,
        )
        assert differences(steps, most=most, within="robot") == []
