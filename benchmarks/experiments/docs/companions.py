"""What stands beside an object in both fingers' pictures: this script writes `companions.jpg`.

Above: a banana that is offered, without and with the hand, and what the hand changes, four times as strong. Below: a
plug deep in the jack, likewise without and with the base. Upper finger, `quality="control"`.
"""

from pathlib import Path

import cv2
import numpy as np

from magicsim.arrays import Frame
from magicsim.geometry.pose import Pose
from magicsim.notebook.screen import change, on_screen
from magicsim.robot.fingers import ObjectPlace, object_pose
from magicsim.robot.gripper import Gripper
from magicsim.scenes.scene import load_scene
from magicsim_experiments.assembly.stages import AssemblyConfig
from magicsim_experiments.assembly.trial import PLACE, SPACE, base_of, check_plug
from magicsim_experiments.task.hand import hand_pose
from magicsim_experiments.task.running import task_scene
from magicsim_experiments.task.settings import GraspConfig, load_item
from magicsim_experiments.task.world import build_gripper

GAP_MM, DEPTH_MM, SPACE_PX = 2.0, 8.0, 6
HERE = Path(__file__).parent


def both(gripper: Gripper, pose: Pose) -> Frame:
    """Frames without and with what stands at a pose, and their difference, shape (rows, columns, 3)."""
    images = []
    for each in (None, pose):
        gripper.accompany(each)
        images.append(gripper.upper.frame().image)
    gamma = gripper.upper.scene.rig.camera.gamma
    tiles = [*(on_screen(each, gamma=gamma) for each in images), change(images[1], images[0])]
    return np.hstack([np.pad(each, ((0, SPACE_PX), (0, SPACE_PX), (0, 0)), constant_values=255) for each in tiles])


def offered() -> Frame:
    """The hand offers a banana, 2 mm before the upper finger."""
    config = GraspConfig(items=("banana",), quality="control")
    with build_gripper(task_scene(config, load_item("banana")), config) as gripper:
        width = gripper.touching_width_mm + 2 * config.open_gap_mm
        place = ObjectPlace(z_mm=config.open_gap_mm - GAP_MM)
        gripper.close(width, place=place)
        return both(gripper, hand_pose(gripper.place, 0.0))


def plugged() -> Frame:
    """A plug in the grip, 8 mm deep in the jack."""
    scene = load_scene("assembly")
    plug = check_plug(scene.object)
    with Gripper(scene, workspace=SPACE, quality="control", companion=base_of(plug)) as gripper:
        gripper.close(gripper.touching_width_mm - AssemblyConfig().squeeze_mm, place=PLACE)
        axis = object_pose(plug, gripper.place)
        tip = axis.to_sensor(np.array([[0.0, plug.length_mm / 2 + plug.pin_length_mm, 0.0]]))[0]
        return both(gripper, Pose(position_mm=tip - DEPTH_MM * axis.rotation[:, 1], rotation=axis.rotation))


def main() -> None:
    """Renders and writes."""
    sheet = np.vstack([offered(), plugged()])[:-SPACE_PX, :-SPACE_PX, ::-1]
    cv2.imwrite(str(HERE / "companions.jpg"), np.ascontiguousarray(sheet), [cv2.IMWRITE_JPEG_QUALITY, 88])


if __name__ == "__main__":
    main()
