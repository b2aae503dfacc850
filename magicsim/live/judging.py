"""Verdicts of the standard profiles on single frames of a live sensor."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from magicsim.arrays import Frame
from magicsim.detectors.combined import detect
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.profiles.profile_file import load_profile
from magicsim.detectors.verdict import Verdict
from magicsim.errors import MagicsimError
from magicsim.judge.verdicts import PROFILES


@dataclass(frozen=True, slots=True, kw_only=True)
class Judges:
    """The profiles with their references of one sensor under one light."""

    benches: dict[str, tuple[DetectorProfile, References] | str]
    """Each profile with its references, or why it refuses the sensor."""

    @classmethod
    def learned(cls, untouched: Sequence[Frame]) -> Self:
        """From frames of the untouched sensor, RGB of shape (rows, columns, 3), in order of time."""
        benches: dict[str, tuple[DetectorProfile, References] | str] = {}
        for name in PROFILES:
            profile = load_profile(name)
            try:
                benches[name] = (profile, fuse(untouched, profile))
            except MagicsimError as error:
                benches[name] = str(error)
        return cls(benches=benches)

    def verdicts(self, frame: Frame) -> dict[str, Verdict | str]:
        """What each profile says about a frame, or why it says nothing."""
        return {
            name: found if isinstance(found, str) else detect(frame, found[1], found[0])
            for name, found in self.benches.items()
        }
