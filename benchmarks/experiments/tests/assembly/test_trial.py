"""A trial from grip to open fingers, on sensors small enough for a test."""

import numpy as np
import pytest
from robot.conftest import TINY

from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.gripper import Gripper
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim_experiments.assembly.playing import play
from magicsim_experiments.assembly.stages import AssemblyConfig, Misalignment, Step, TrialStage
from magicsim_experiments.assembly.trial import Setup, base_of, check_plug, take_plug

SMALL = [
    *(setting for setting in TINY if not setting.startswith("object.")), "object.radius_mm=4", "object.length_mm=6",
    "object.pin_radius_mm=1.5", "object.pin_length_mm=8", "output.contact_mask=false", "output.displacements=false",
]  # fmt: skip
SPACE = Workspace(
    x_mm=(-1, 1), y_mm=(0, 4), twist_deg=(-15, 15), tilt_x_deg=(-15, 15), tilt_y_deg=(-15, 15), gap_mm=(-1.2, 12)
)
CONFIG = AssemblyConfig(squeeze_mm=1.2)
SHORT = (
    Step(stage=TrialStage.GRIP, depth_mm=None),
    Step(stage=TrialStage.APPROACH, depth_mm=-0.5),
    Step(stage=TrialStage.FIRST, depth_mm=1.0, push_n=0.5),
    Step(stage=TrialStage.OPEN, depth_mm=1.0),
)


@pytest.fixture(scope="module")
def scene() -> SceneConfig:
    return load_scene("assembly", SMALL)


@pytest.mark.slow
def test_plug_meets_the_base_beside_the_jack_and_goes_in_on_its_axis(scene: SceneConfig):
    setup = Setup(place=ObjectPlace(y_mm=3.0), timeline=SHORT, references=2, config=CONFIG)
    with Gripper(scene, workspace=SPACE, quality="control", sees_other=False) as gripper:
        assert not gripper.has_companion
        gripped = take_plug(gripper, check_plug(scene.object), setup)
        beside = play(gripper, gripped, Misalignment(kind="offset", x_mm=4.0))
        aligned = play(gripper, gripped, Misalignment(kind="aligned"))
        again = play(gripper, gripped, Misalignment(kind="offset", x_mm=4.0))
    assert [each.base_force_n for each in again] == [each.base_force_n for each in beside]
    assert all(np.array_equal(a.images, b.images) for a, b in zip(again, beside, strict=True))
    met = beside[2]
    assert [each.step.stage for each in beside] == [step.stage for step in SHORT]
    assert 0.95 * 0.5 <= np.linalg.norm(met.base_force_n) <= 0.5  # the carriage stops as hard as it may push
    assert met.base_force_n[1] < -0.4
    assert met.place.y_mm < beside[1].place.y_mm - 0.05  # the base pushes the plug back into the grip
    assert abs(met.base_force_n[0]) < 0.1 * abs(met.base_force_n[1])
    assert np.linalg.norm(aligned[2].base_force_n) < 0.01
    assert aligned[2].place.y_mm == pytest.approx(aligned[1].place.y_mm, abs=1e-3)
    assert np.abs(met.images[0].astype(int) - beside[1].images[0]).max() > 3
    assert len(gripped.references[0]) == 2


@pytest.mark.slow
def test_each_stage_has_its_samples_and_the_base_is_where_the_contact_has_it(scene: SceneConfig):
    plug = check_plug(scene.object)
    setup = Setup(place=ObjectPlace(y_mm=3.0), timeline=SHORT, references=2, config=CONFIG, samples=3)
    with Gripper(scene, workspace=SPACE, quality="control", companion=base_of(plug, setup)) as gripper:
        gripped = take_plug(gripper, plug, setup)
        moments = play(gripper, gripped, Misalignment(kind="aligned"))
        shown = [finger.state.companion for finger in gripper.fingers]
    assert [each.step.stage for each in moments] == [step.stage for step in SHORT for _ in range(3)]
    times = [each.time_s for each in moments]
    assert times == sorted(set(times))
    mouth = 3.0 + plug.length_mm / 2 + plug.pin_length_mm - 1.0  # the pin is 1 mm deep
    assert [pose and pose[1] for pose in shown] == pytest.approx([mouth, mouth], abs=0.1)
