"""Everything that a run of alignments depends on."""

from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, model_validator

from magicsim.config.models import Config
from magicsim_experiments.task.settings import GIVEN, in_order, refuse_given

HOW = (
    "'magicsim study alignment --out DIR' makes one, DIR/models/learning/press-0/model.safetensors (--quick: in "
    "minutes, and worse)"
)
"""How a model is made."""
MISSING_MODEL = f"--model is missing: {HOW}"
Angle = Annotated[float, Field(ge=0, le=60)]


class AlignmentConfig(Config):
    """One run of the alignment task; every number is assumed where nothing else is said."""

    model_sha256: str = ""
    """SHA-256 of the model file that reads the frames."""
    design: str = "mini-magictac"
    """Design preset or TOML file of both fingers."""
    rig: str = "digit-office"
    """Rig preset or TOML file; its frames get the size that the model takes."""
    scene: tuple[str, ...] = ()
    """Further settings of the fingers' scene, `dotted.key=value`, such as `design.skin_mm=0.5`."""
    items: Annotated[tuple[str, ...], Field(min_length=1)] = (
        "rod-10-black", "rod-10-white", "rod-15-black", "rod-15-white", "rod-20-black", "rod-20-white", "pen",
    )  # fmt: skip
    """Item presets or files, taken in turn. Diameters and colours of the rods are published."""
    unseen: tuple[str, ...] = ("pen",)
    """Those of which the model has learned nothing; they are counted apart."""
    quality: Literal["full", "control"] = "full"
    """How finely is solved and rendered, see `magicsim.robot.quality`."""
    seed: Annotated[int, Field(ge=0, lt=2**31)] = 0
    """Seed of everything that is drawn."""
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

    @model_validator(mode="after")
    def _check_scene(self) -> Self:
        refuse_given(self.scene, GIVEN | {"references": "references", "keyframes": "the task"})
        return self
