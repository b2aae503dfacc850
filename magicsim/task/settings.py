"""Everything that a run of grasps depends on, and its hash."""

import hashlib
import json
from typing import Annotated, Literal

from pydantic import Field

from magicsim.config.models import Config
from magicsim.scenes.rig import DARK, Rig

PositiveMm = Annotated[float, Field(gt=0, le=1000)]
Speed = Annotated[float, Field(gt=0, le=1000)]


class GraspConfig(Config):
    """One run of the grasp-and-transport task; every number is assumed where nothing else is said."""

    design: str = "mini-magictac"
    """Design preset or TOML file of both fingers."""
    rig: str = "digit-office"
    """Rig preset or TOML file."""
    room: str = "office"
    """Room around, see `Rig.room`; `dark` for none."""
    scene: tuple[str, ...] = ()
    """Further settings of the fingers' scene, `dotted.key=value`, such as `design.skin_mm=0.5`."""
    detector: str = "calibrated"
    """Profile that reads the frames."""
    items: Annotated[tuple[str, ...], Field(min_length=1)] = ("orange", "banana", "biscuit-packet")
    """Item presets or files; each episode draws one."""
    quality: Literal["full", "control"] = "full"
    """How finely is solved and rendered, see `magicsim.robot.quality`."""
    seed: Annotated[int, Field(ge=0, lt=2**31)] = 0
    """Of everything that is drawn."""
    frames_per_second: Annotated[float, Field(ge=1, le=120)] = 15.0
    """Rate of the frames that the machine reads [1/s]."""
    most_frames: Annotated[int, Field(ge=20, le=5000)] = 260
    """Frames of an episode at most."""
    open_gap_mm: PositiveMm = 8.0
    """Room on each side of an item between open fingers [mm]."""
    close_mm_s: Speed = 8.0
    """Closing speed of each finger [mm/s]."""
    open_mm_s: Speed = 24.0
    """Opening speed of each finger [mm/s]."""
    grip_n: Annotated[float, Field(gt=0, le=50)] = 4.0
    """Normal force at which the motors stall [N]."""
    distance_mm: PositiveMm = 300.0
    """From A to B [mm]."""
    carriage_mm_s: Speed = 150.0
    """Speed of the carriage [mm/s]."""
    carriage_mm_s2: Annotated[float, Field(gt=0, le=20000)] = 1000.0
    """Its acceleration [mm/s2], which the held item feels."""
    hand_mm_s: tuple[Speed, Speed] = (60.0, 250.0)
    """Slowest and fastest approach of the hand [mm/s]."""
    near_mm: tuple[PositiveMm, PositiveMm] = (1.0, 4.0)
    """Nearest and farthest gap to the watched finger at which the hand offers an item [mm]."""
    pull_share: Annotated[float, Field(ge=0, le=1)] = 0.5
    """Share of the episodes in which a hand pulls the item away."""
    pull_n_s: Annotated[float, Field(gt=0, le=1000)] = 30.0
    """How fast such a pull rises [N/s]."""
    light_share: Annotated[float, Field(ge=0, le=1)] = 0.5
    """Chance of a flashlight before the approach, and again during transport."""

    def config_hash(self) -> str:
        """SHA-256 of what episodes depend on, so that a folder is not continued with another task."""
        text = json.dumps(self.model_dump(mode="json"), sort_keys=True)
        return hashlib.sha256(text.encode()).hexdigest()


def in_room(rig: Rig, room: str) -> Rig:
    """The rig in a room; its own light is scaled by nothing.

    Args:
        rig: The rig.
        room: Name, image or `dark`.

    Raises:
        ConfigError: There is no such room.
    """
    from magicsim.config.models import validate

    values = rig.model_dump() | {"room": room}
    if room != DARK and not any(rig.ambient):
        values["ambient"] = (0.1, 0.1, 0.1)
    return validate(Rig, values, source="room")
