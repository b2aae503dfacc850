"""Slip: while an object is held, the grid relaxes suddenly because the object was pulled away.

The paper (Fan, Li, Zhang, arXiv 2505.24382) reads a sudden rise of S as a slip. Light that comes or goes changes S as
well, so a frame that proximity calls Noise and the one after it are no evidence, and no rise is measured across them.
How much is sudden is not published: here it is a share of what the touch had taken from S, which suits designs whose S
falls to 0.1 on contact as well as designs where it falls to 0.95.
"""

from dataclasses import dataclass

from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import Proximity


@dataclass(frozen=True, slots=True, kw_only=True)
class SlipState:
    """What slip detection remembers between two frames."""

    levels: tuple[float, ...] = ()
    """Similarities of the last frames that were evidence, oldest first, `profile.slip_window` at most."""
    after_noise: bool = False
    """Whether the last frame was Noise."""


def step_slip(
    state: SlipState, similarity: float, proximity: Proximity, profile: DetectorProfile
) -> tuple[SlipState, bool]:
    """Whether the held object slipped with this frame.

    With S_low the smallest S of the last `slip_window` frames, a slip is
    (S - S_low) / (1 - S_low) >= slip_share, or a touch that is lost: S >= tau_g + touch_hysteresis (1 - tau_g).

    Args:
        state: `SlipState()` when the object is taken hold of, then from the step before.
        similarity: S of the frame, 0..1.
        proximity: Proximity verdict of the frame.
        profile: slip_share, slip_window, tau_g and touch_hysteresis.

    Returns:
        The next state, and whether the object slipped.
    """
    if proximity is Proximity.NOISE:
        return SlipState(after_noise=True), False
    if state.after_noise:
        return SlipState(levels=(similarity,)), False
    after = SlipState(levels=(*state.levels, similarity)[-profile.slip_window :])
    return after, is_touch_lost(similarity, profile) or _rises(state.levels, similarity, profile)


def is_touch_lost(similarity: float, profile: DetectorProfile) -> bool:
    """Whether S is so far above tau_g that a touch counts as ended: the upper threshold of the hysteresis."""
    return similarity >= profile.tau_g + profile.touch_hysteresis * (1.0 - profile.tau_g)


def _rises(levels: tuple[float, ...], similarity: float, profile: DetectorProfile) -> bool:
    low = min(levels, default=similarity)
    return similarity > low and similarity - low >= profile.slip_share * (1.0 - low)
