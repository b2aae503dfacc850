"""What labels say of a recorded frame in the words of a simulated one: gap, depth, contact, class."""

import math
from dataclasses import dataclass

from magicsim.errors import ConfigError, unknown_choice
from magicsim.frame_class import FrameClass, classify_frame
from magicsim.real.description import TruthRules
from magicsim.real.labels import Row
from magicsim.real.sequence import force_size


@dataclass(frozen=True, slots=True, kw_only=True)
class RealTruth:
    """State of one frame, as far as it is known."""

    gap_mm: float
    """NaN without an object and where nobody knows."""
    depth_mm: float
    """NaN where nobody knows."""
    contact: bool | None
    frame_class: FrameClass | None
    """None where it is not scored."""


def truth_of(row: Row, rules: TruthRules, told: frozenset[str], *, name: str = "frame") -> RealTruth:
    """The state that labels tell.

    A class that is given counts. Else a gap decides, as for simulated frames; else a depth; else contact, where a
    touch of unknown depth counts as one; else an outside light.

    Args:
        row: Labels of the frame.
        rules: What follows from what.
        told: Which labels the file has at all: an empty gap then means that there is no object.
        name: What messages call the frame.

    Raises:
        ConfigError: A word that is no class.
    """
    gap_mm, depth_mm, force_n = row["gap_mm"], row["depth_mm"], force_size(row["force_n"])
    if math.isnan(gap_mm) and depth_mm > 0:
        gap_mm = -depth_mm
    if math.isnan(depth_mm) and not math.isnan(gap_mm):
        depth_mm = max(0.0, -gap_mm)
    contact: bool | None = row["contact"]
    if contact is None and not math.isnan(force_n):
        contact = force_n > rules.contact_n
    if contact is None and not math.isnan(gap_mm):
        contact = gap_mm < 0
    if contact is None and not math.isnan(depth_mm):
        contact = depth_mm > 0
    found: FrameClass | None
    if "frame_class" in told:
        found = _given(row["frame_class"], rules, name)
    elif not math.isnan(gap_mm) or "gap_mm" in told:
        found = classify_frame(
            gap_mm=None if math.isnan(gap_mm) else gap_mm,
            force_n=float(bool(contact)),
            light_on=bool(row["flashlight"]),
        )
    elif contact:
        found = FrameClass.CONTACT
    elif row["flashlight"]:
        found = FrameClass.LIGHT
    else:
        found = FrameClass(rules.without_contact) if contact is False and rules.without_contact else None
    return RealTruth(gap_mm=gap_mm, depth_mm=depth_mm, contact=contact, frame_class=found)


def _given(word: str, rules: TruthRules, name: str) -> FrameClass | None:
    """Class that a column gives; None for an empty text."""
    meant = rules.classes.get(word, word)
    if meant and meant not in list(FrameClass):
        msg = f"'{name}': {unknown_choice('class', word, FrameClass)}; truth.classes translates other words"
        raise ConfigError(msg)
    return FrameClass(meant) if meant else None
