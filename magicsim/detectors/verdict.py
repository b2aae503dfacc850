"""What the detectors say about one frame."""

from dataclasses import dataclass, field, fields
from enum import StrEnum


class Proximity(StrEnum):
    """Verdict of the proximity algorithm."""

    NORMAL = "Normal"
    """Nothing brightens."""
    APPROACHING = "Approaching"
    """The channels brighten differently: an object seen through the side-lit grid."""
    NOISE = "Noise"
    """The channels brighten alike: light from outside."""


class Contact(StrEnum):
    """Verdict of the contact algorithm, and of the combined detection, which alone says `Unknown`."""

    TOUCHED = "Touched"
    """The grid looks different from the untouched one."""
    UNTOUCHED = "Untouched"
    """The grid is where it was."""
    UNKNOWN = "Unknown"
    """Outside light changes the grid's look too, so the frame is no evidence either way."""


NUMBERS = ("entropy", "correlation", "similarity", "p_approach", "p_noise", "p_touch")
"""Fields of a verdict that are numbers."""
WORDS = ("proximity", "contact", "combined")
"""Fields that are words."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """Features, probabilities and verdicts of one frame."""

    entropy: float
    """Shannon entropy E of the brightening [bit], 0..8."""
    correlation: float
    """Mean pairwise Pearson correlation C of the brightened channels, -1..1."""
    similarity: float
    """Grid similarity S, 0..1."""
    p_approach: float
    """Probability of a nearby object, 0..1."""
    p_noise: float
    """Probability of outside light, 0..1."""
    p_touch: float
    """Probability of a touch from the similarity alone, 0..1."""
    proximity: Proximity
    """Verdict from E and C."""
    contact: Contact
    """Verdict from S alone: `Touched` or `Untouched`."""
    combined: Contact
    """The contact verdict, `Unknown` where proximity says `Noise`."""
    weak: bool | None = field(default=None, compare=False)
    """Whether it rests on less than the camera's own repeatability, see `magicsim.detectors.at_rest`; None where the
    spread at rest is not known."""
    source: str | None = None
    """Where the frame came from, such as a file name; None for an array in memory."""

    def as_dict(self) -> dict[str, float | str]:
        """The fields ready for JSON, without `weak` and `source` where there are none."""
        values = {each.name: getattr(self, each.name) for each in fields(self)}
        return {name: value for name, value in values.items() if value is not None}
