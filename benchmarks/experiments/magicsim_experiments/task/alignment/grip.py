"""How an item is held in an episode, and the gripper that holds it."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from pydantic import AfterValidator, Field

from magicsim.config.models import validate
from magicsim.errors import ConfigError
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.linkage import Linkage
from magicsim.robot.gripper import Gripper
from magicsim.robot.workspace import Workspace
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim_experiments.learn.model_file import ModelConfig
from magicsim_experiments.task.settings import GIVEN, GripperConfig, Item, in_order, refused

HOW = (
    "'magicsim study alignment --out DIR' makes one, DIR/models/learning/press-0/model.safetensors (--quick: in "
    "minutes, and worse)"
)
"""How a model is made."""
MISSING_MODEL = f"--model is missing: {HOW}"
Angle = Annotated[float, Field(ge=0, le=60)]


class AlignmentConfig(GripperConfig):
    """One run of the alignment task; every number is assumed where nothing else is said."""

    model_sha256: str = ""
    """SHA-256 of the model file that reads the frames."""
    items: Annotated[tuple[str, ...], Field(min_length=1)] = (
        "rod-10-black", "rod-10-white", "rod-15-black", "rod-15-white", "rod-20-black", "rod-20-white", "pen",
    )  # fmt: skip
    """Item presets or files, taken in turn. Diameters and colours of the rods are published."""
    unseen: tuple[str, ...] = ("pen",)
    """Items of which the model has learned nothing; they are counted apart."""
    askew_deg: Annotated[tuple[Angle, Angle], AfterValidator(in_order)] = (5.0, 40.0)
    """Smallest and largest angle, to either side, at which an item is held at first [degrees]."""
    aside_mm: Annotated[float, Field(ge=0, le=10)] = 2.0
    """Farthest from the middle of the fingers, along x and y [mm]."""
    grip_n: Annotated[float, Field(gt=0, le=50)] = 6.0
    """Normal force at which the motors stall [N]."""
    sees_other: bool = True
    """Whether each finger is in the other's picture."""
    references: Annotated[int, Field(ge=1, le=255)] = 10
    """Frames of the empty fingers, as wide open as for the item, whose mean is the model's untouched frame."""
    frames_per_second: Annotated[float, Field(ge=1, le=120)] = 10.0
    """Rate of the frames that are read [1/s]."""
    frames: Annotated[int, Field(ge=2, le=2000)] = 18
    """Frames of an episode."""
    gain_per_s: Annotated[float, Field(gt=0, le=120)] = 4.0
    """Speed of the wrist for each degree that is read, up to its limit [1/s]."""
    wrist_deg_s: Annotated[float, Field(gt=0, le=1000)] = 60.0
    """Largest speed of the wrist [degrees/s]."""
    within_deg: Annotated[float, Field(gt=0, le=45)] = 2.0
    """Error below which an item counts as upright [degrees]."""

    def _problems(self) -> Iterator[str]:
        return refused(self.scene, GIVEN | {"references": "references", "keyframes": "the task"})


STREAM = 38
"""Keeps the draws of episodes apart from others of a seed."""
SLIDE_MM, TURN_DEG, TILT_DEG, DEEPEST_MM, FAR_MM = 4.0, 15.0, 15.0, 2.0, 30.0
"""Room in the workspace for an item that slips or turns in the grip; deepest press and farthest gap [mm, degrees]."""
ASPECT_SHARE = 0.02
"""Difference of the model's and the rig's ratio of rows to columns above which the frames are not alike."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Grip:
    """One episode as drawn."""

    item: str
    askew_deg: float
    """Angle of the item to the fingers, about the closing axis [degrees]."""
    x_mm: float
    y_mm: float
    """Where the middle of the item is [mm]."""

    @property
    def place(self) -> ObjectPlace:
        """Where a hand puts it."""
        return ObjectPlace(x_mm=self.x_mm, y_mm=self.y_mm, twist_deg=self.askew_deg)


def draw_grip(config: AlignmentConfig, episode: int) -> Grip:
    """How the item of an episode, by its number, is held: items take turns, sides too."""
    rng = np.random.default_rng(np.random.SeedSequence([config.seed, STREAM, episode]))
    low, high = config.askew_deg
    turn, number = divmod(episode, len(config.items))
    side = 1 if (turn + number) % 2 else -1
    return Grip(
        item=config.items[number],
        askew_deg=side * float(rng.uniform(low, high)),
        x_mm=float(rng.uniform(-config.aside_mm, config.aside_mm)),
        y_mm=float(rng.uniform(-config.aside_mm, config.aside_mm)),
    )


def grip_scene(config: AlignmentConfig, item: Item, model: ModelConfig) -> SceneConfig:
    """The fingers and what is between them, their frames as large as the model takes.

    Raises:
        ConfigError: The model takes frames of another shape than the rig's.
    """
    scene = load_scene("grip", [f"design={config.design}", f"rig={config.rig}", *config.scene])
    camera = scene.rig.camera
    ratio = (model.frame_rows / model.frame_columns) / (camera.rows / camera.columns)
    if abs(ratio - 1) > ASPECT_SHARE:
        raise ConfigError(
            f"the model takes frames of {model.frame_columns} x {model.frame_rows} pixels, which are no reduced frames "
            f"of the rig's {camera.columns} x {camera.rows}; give the rig that its data were made with"
        )
    values = scene.model_dump()
    values["rig"]["camera"] |= {"columns": model.frame_columns, "rows": model.frame_rows}
    values["contact"]["friction"] = item.friction
    values |= {
        "object": item.object.model_dump(), "seed": config.seed, "frames_per_second": config.frames_per_second,
    }  # fmt: skip
    return validate(SceneConfig, values, source="task alignment")


def build_gripper(scene: SceneConfig, config: AlignmentConfig) -> Gripper:
    """The gripper of the task, its motors as strong as the task says."""
    turn = max(config.askew_deg) + TURN_DEG
    far = config.aside_mm + SLIDE_MM
    space = Workspace(
        x_mm=(-far, far), y_mm=(-far, far), twist_deg=(-turn, turn), tilt_x_deg=(-TILT_DEG, TILT_DEG),
        tilt_y_deg=(-TILT_DEG, TILT_DEG), gap_mm=(-DEEPEST_MM, FAR_MM),
    )  # fmt: skip
    return Gripper(
        scene, workspace=space, linkage=replace(Linkage(), force_limit_n=config.grip_n), quality=config.quality,
        sees_other=config.sees_other,
    )  # fmt: skip
