"""Everything that a run of assemblies depends on beside the scene of the fingers."""

from collections.abc import Sequence
from typing import Annotated, Self

from pydantic import AfterValidator, Field, model_validator

from magicsim.config.models import Config, apply_overrides, validate
from magicsim_experiments.assembly.jack import LIMITS, Jack
from magicsim_experiments.assembly.meeting import Contact
from magicsim_experiments.assembly.stages import Spread, timeline
from magicsim_experiments.assembly.trial import MASS_G, SPEED_MM_S, SQUEEZE_MM, Setup
from magicsim_experiments.task.settings import in_order

PREFIX = "task."
"""What settings of the task begin with; all others are the scene's."""
JACK, CONTACT, SPREAD = Jack(), Contact(), Spread()
Positive = Annotated[float, Field(gt=0, le=1000)]
Offset = Annotated[float, Field(ge=0, le=20)]
Angle = Annotated[float, Field(ge=0, le=30)]


class JackConfig(Config):
    """The hole in the base."""

    radius_mm: Annotated[float, Field(ge=LIMITS["radius_mm"][0], le=LIMITS["radius_mm"][1])] = JACK.radius_mm
    """Radius [mm]."""
    chamfer_mm: Annotated[float, Field(ge=LIMITS["chamfer_mm"][0], le=LIMITS["chamfer_mm"][1])] = JACK.chamfer_mm
    """Chamfer of the mouth, at 45 degrees [mm]."""
    depth_mm: Annotated[float, Field(ge=LIMITS["depth_mm"][0], le=LIMITS["depth_mm"][1])] = JACK.depth_mm
    """Depth [mm]."""


class ContactConfig(Config):
    """Contact between plug and base."""

    stiffness_n_mm3: Annotated[float, Field(ge=0.1, le=100)] = CONTACT.stiffness_n_mm3
    """Pressure by depth [N/mm3]."""
    friction: Annotated[float, Field(ge=0, le=2)] = CONTACT.friction
    """Coulomb's coefficient."""
    spring_n: Annotated[float, Field(ge=0, le=100)] = CONTACT.spring_n
    """Resistance of the jack's contacts to a pin in the hole [N]."""
    spring_mm: Annotated[tuple[Positive, Positive], AfterValidator(in_order)] = CONTACT.spring_mm
    """Depths of the pin at which that begins, and is there in full [mm]."""


class AssemblyConfig(Config):
    """One run of the assembly task; every number is assumed where nothing else is said."""

    jack: JackConfig = JackConfig()
    """The hole in the base."""
    contact: ContactConfig = ContactConfig()
    """Contact between plug and base."""
    mass_g: Positive = MASS_G
    """Mass of the plug [g]."""
    squeeze_mm: Annotated[float, Field(gt=0, le=4)] = SQUEEZE_MM
    """How much closer than touching the faces grip [mm]."""
    speed_mm_s: Positive = SPEED_MM_S
    """Speed of the carriage and of each finger [mm/s]."""
    before_mm: Annotated[float, Field(gt=0, le=8)] = 0.5
    """How far before the mouth the approach ends [mm]."""
    insertion_mm: Annotated[tuple[Positive, Positive], AfterValidator(in_order)] = (2.0, 4.0)
    """How far the pin would go in the first and in the second insertion if nothing gave way [mm]."""
    push_n: tuple[Positive, Positive] = (2.0, 4.0)
    """Force of the base at which the carriage stops in the first and in the second insertion [N]."""
    success_mm: Positive = 8.0
    """Depth of the pin once it is aligned [mm]."""
    offset_mm: Annotated[tuple[Offset, Offset], AfterValidator(in_order)] = SPREAD.offset_mm
    """Smallest and largest offset of a base beside the axis [mm]; published is 'above 3 mm'."""
    angle_deg: Annotated[tuple[Angle, Angle], AfterValidator(in_order)] = SPREAD.angle_deg
    """Smallest and largest angle of a base [degrees]; published are 'slight angles'."""
    aligned_mm: Offset = SPREAD.aligned_mm
    """Largest offset of a base that counts as aligned [mm]: the chamfer has to take it."""

    @model_validator(mode="after")
    def _check_success(self) -> Self:
        if self.success_mm > self.jack.depth_mm:
            msg = (
                f"success_mm = {self.success_mm:g} is not allowed: must be at most {self.jack.depth_mm:g}, the depth "
                "of the jack"
            )
            raise ValueError(msg)
        return self

    def setup(self, *, references: int, samples: int) -> Setup:
        """What does not change from trial to trial."""
        first, second = zip(self.insertion_mm, self.push_n, strict=True)
        return Setup(
            jack=Jack(**self.jack.model_dump()),
            contact=Contact(**self.contact.model_dump()),
            mass_g=self.mass_g,
            squeeze_mm=self.squeeze_mm,
            timeline=timeline(before_mm=self.before_mm, insertions=(first, second), success_mm=self.success_mm),
            references=references,
            samples=samples,
            speed_mm_s=self.speed_mm_s,
        )

    @property
    def spread(self) -> Spread:
        """Ranges of the misalignments."""
        return Spread(offset_mm=self.offset_mm, angle_deg=self.angle_deg, aligned_mm=self.aligned_mm)


def split_settings(settings: Sequence[str]) -> tuple[list[str], AssemblyConfig]:
    """Settings of the scene, and the task with its own, which begin with `task.`.

    Args:
        settings: `dotted.key=value` each.
    """
    own = [each.strip()[len(PREFIX) :] for each in settings if each.strip().startswith(PREFIX)]
    others = [each for each in settings if not each.strip().startswith(PREFIX)]
    return others, validate(AssemblyConfig, apply_overrides({}, own), source="task assembly")
