"""Everything that a run of grasps depends on."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, Field

from magicsim.config.models import Config, load_preset
from magicsim.geometry.objects.kinds import ObjectConfig


class Item(Config):
    """An everyday thing between the fingers. It is rigid: what gives way is the skin of the sensors alone."""

    schema_version: Literal[1]
    object: ObjectConfig
    """Shape, colour and how it lies between the fingers, in the gripper's frame."""
    mass_g: Annotated[float, Field(gt=0, le=2000)]
    """Mass [g]."""
    friction: Annotated[float, Field(gt=0, le=2)]
    """Coulomb's coefficient between it and the skin of the sensors."""
    crush_n: Annotated[float, Field(gt=0, le=1000)]
    """Normal force of a finger from which it counts as crushed [N]."""


def load_item(name: str | Path) -> Item:
    """Reads an item.

    Args:
        name: Item preset, such as `orange`, or TOML file.
    """
    return load_preset(Item, "item", name)


def item_schema() -> dict[str, Any]:
    """JSON Schema of the files of items."""
    return Item.model_json_schema()


Positive = Annotated[float, Field(gt=0, le=1000)]
Speed = Annotated[float, Field(gt=0, le=1000)]
GIVEN = {"object": "items", "contact.friction": "items", "seed": "seed", "frames_per_second": "frames_per_second"}
"""Settings of a scene that a task says, and what of it says them."""


def in_order(pair: tuple[float, float]) -> tuple[float, float]:
    """The pair, smaller one first."""
    if pair[0] > pair[1]:
        raise ValueError(f"{pair[0]:g}, {pair[1]:g} is not allowed: must be the smaller one first")
    return pair


def refused(settings: Sequence[str], given: Mapping[str, str]) -> Iterator[str]:
    """Why `dotted.key=value` settings of the fingers' scene are refused that the task says: they would do nothing."""
    for each in settings:
        key = each.partition("=")[0].strip()
        for name, by in given.items():
            if key == name or key.startswith(f"{name}."):
                yield f"scene: '{each}' is not allowed: must be left to {by}"


class GripperConfig(Config):
    """What two fingers are in a task with items, and how it is drawn and solved."""

    design: str = "mini-magictac"
    """Design preset or TOML file of both fingers."""
    rig: str = "digit-office"
    """Rig preset or TOML file; where a model reads the frames, they get the size that it takes."""
    scene: tuple[str, ...] = ()
    """Further settings of the fingers' scene, `dotted.key=value`, such as `design.skin_mm=0.5`."""
    quality: Literal["full", "control"] = "full"
    """How finely is solved and rendered, see `magicsim.robot.quality`."""
    seed: Annotated[int, Field(ge=0, lt=2**31)] = 0
    """Seed of everything that is drawn."""


class GraspConfig(GripperConfig):
    """One run of the grasp-and-transport task; every number is assumed where nothing else is said."""

    room: str = "office"
    """Room around, see `Rig.room`; `dark` for none."""
    detector: str = "calibrated"
    """Profile that reads the frames."""
    items: Annotated[tuple[str, ...], Field(min_length=1)] = ("orange", "banana", "biscuit-packet")
    """Item presets or files; each episode draws one."""
    frames_per_second: Annotated[float, Field(ge=1, le=120)] = 15.0
    """Rate of the frames that the machine reads [1/s]."""
    most_frames: Annotated[int, Field(ge=20, le=5000)] = 260
    """Frames of an episode at most."""
    open_gap_mm: Positive = 8.0
    """Room on each side of an item between open fingers [mm]."""
    close_mm_s: Speed = 8.0
    """Closing speed of each finger [mm/s]."""
    open_mm_s: Speed = 24.0
    """Opening speed of each finger [mm/s]."""
    grip_n: Annotated[float, Field(gt=0, le=50)] = 4.0
    """Normal force at which the motors stall [N]."""
    distance_mm: Positive = 300.0
    """From A to B [mm]."""
    carriage_mm_s: Speed = 150.0
    """Speed of the carriage [mm/s]."""
    carriage_mm_s2: Annotated[float, Field(gt=0, le=20000)] = 1000.0
    """Acceleration of the carriage [mm/s2], which the held item feels."""
    hand_mm_s: Annotated[tuple[Speed, Speed], AfterValidator(in_order)] = (60.0, 250.0)
    """Slowest and fastest approach of the hand [mm/s]."""
    near_mm: Annotated[tuple[Positive, Positive], AfterValidator(in_order)] = (1.0, 4.0)
    """Nearest and farthest gap to the watched finger at which the hand offers an item [mm]."""
    hand: bool = True
    """Whether the hand is in the picture while it holds the item, comes and goes, see `task.hand`."""
    pull_share: Annotated[float, Field(ge=0, le=1)] = 0.5
    """Share of the episodes in which a hand pulls the item away."""
    pull_n_s: Annotated[float, Field(gt=0, le=1000)] = 30.0
    """How fast such a pull rises [N/s]."""
    light_share: Annotated[float, Field(ge=0, le=1)] = 0.5
    """Chance of a flashlight before the approach, and again during transport; of each of two with `any`."""
    flashlight: Literal["usual", "any"] = "usual"
    """When flashlights shine: before the approach and in transport, or at any stage, see `task.story`."""

    def _problems(self) -> Iterator[str]:
        given = {"rig.room": "room", "references": "the detector's profile", "keyframes": "the task"}
        yield from refused(self.scene, GIVEN | given)
        (low, high), most = self.near_mm, 2 * self.open_gap_mm
        if high > most:
            where = f"must be at most {most:g}, twice open_gap_mm, where the other finger is"
            yield f"near_mm = {low:g}, {high:g} is not allowed: {where}"
