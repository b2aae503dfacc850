"""What a detector must offer to be judged, and the built-in one."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol, runtime_checkable

from magicsim.arrays import Frame
from magicsim.detectors.at_rest import FEATURES
from magicsim.detectors.combined import behind_coat, detect
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.profiles.profile_file import load_profile
from magicsim.errors import ConfigError


@dataclass(frozen=True, slots=True, kw_only=True)
class Detection:
    """What a detector says of one frame. Plain words and numbers, so that a plug-in needs nothing of magicsim."""

    proximity: str
    """`Normal`, `Approaching` or `Noise`."""
    contact: str
    """`Touched`, `Untouched` or `Unknown`, with everything known taken into account."""
    approach: float
    """Score that rises with the evidence for a nearby object; any scale, used for ranking alone."""
    touch: float
    """Score that rises with the evidence for a touch; any scale, used for ranking alone."""
    entropy: float | None = None
    """E [bit], where the detector has it; its spread at rest is then told, and likewise that of the next two."""
    correlation: float | None = None
    """C."""
    similarity: float | None = None
    """S."""


@runtime_checkable
class Detector(Protocol):
    """A detector; one object is made without arguments for every episode."""

    def fit(self, references: Sequence[Frame]) -> None:
        """Learns the untouched sensor from its reference frames, RGB, uint8, shape (rows, columns, 3)."""

    def step(self, frame: Frame) -> Detection:
        """Judges the next frame of the stream; called once for every frame, in order.

        Anything with the first four fields of `Detection` may be returned.
        """


MakeDetector = Callable[[], Detector]


class ProfileDetector:
    """The built-in detectors with one profile: temporal fusion, proximity, contact, combined detection."""

    def __init__(self, profile: DetectorProfile, *, is_coated: bool = False) -> None:
        """Takes thresholds and options, and whether an opaque coat hides what is outside."""
        self.profile, self.is_coated = profile, is_coated
        self._references: References | None = None

    def fit(self, references: Sequence[Frame]) -> None:
        """See `Detector`."""
        self._references = fuse(list(references), self.profile)

    def step(self, frame: Frame) -> Detection:
        """See `Detector`; a touch under outside light is no evidence, which its score follows."""
        if self._references is None:
            msg = "step before fit: a detector needs its references first"
            raise ConfigError(msg)
        verdict = detect(frame, self._references, self.profile)
        if self.is_coated:
            verdict = behind_coat(verdict)
        return Detection(
            proximity=verdict.proximity,
            contact=verdict.combined,
            approach=verdict.p_approach,
            touch=verdict.p_touch * (1 - (0 if self.is_coated else verdict.p_noise)),
            **{name: getattr(verdict, name) for name in FEATURES},
        )


def built_in(profile: str | Path, *, is_coated: bool = False) -> MakeDetector:
    """Makes built-in detectors with a profile, for a sensor with an opaque coat where it has one.

    Raises:
        PresetError: No such profile.
    """
    loaded = load_profile(profile)
    return lambda: ProfileDetector(loaded, is_coated=is_coated)
