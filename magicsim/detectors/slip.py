"""Slip: while an object is held, the grid relaxes suddenly because the object was pulled away.

The paper (Fan, Li, Zhang, arXiv 2505.24382) reads a sudden rise of S as a slip. Light that comes or goes changes S as
well, so a frame that proximity calls Noise and the one after it are no evidence, and no rise is measured across them.
How much is sudden is not published: here it is a share of what the touch had taken from S, which suits designs whose S
falls to 0.1 on contact as well as designs where it falls to 0.95.

A held object shades and colours outside light, so that Noise may not be seen. But an object that leaves takes its light
away: a rise of S together with a rise of E is light and no slip, until E has come back.
"""

from dataclasses import dataclass

from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.verdict import Proximity, Verdict


@dataclass(frozen=True, slots=True, kw_only=True)
class SlipState:
    """What slip detection remembers between two frames."""

    levels: tuple[float, ...] = ()
    """Similarities of the last frames that were evidence, oldest first, `profile.slip_window` at most."""
    entropy: float | None = None
    """Entropy of the last of them [bit], or of the last one before light that was no Noise."""
    after_noise: bool = False
    """Whether the last frame was Noise."""
    lit: bool = False
    """Whether a rise of S came with a rise of E and E has not come back since."""


def step_slip(state: SlipState, verdict: Verdict, profile: DetectorProfile) -> tuple[SlipState, bool]:
    """Whether the held object slipped with this frame.

    With S_low the smallest S of the last `slip_window` frames, a slip is
    (S - S_low) / (1 - S_low) >= slip_share, or a touch that is lost: S >= tau_g + touch_hysteresis (1 - tau_g);
    neither if E is `slip_entropy_rise` or more above that of the last frame.

    Args:
        state: `SlipState()` when the object is taken hold of, then from the step before.
        verdict: Of the frame; its E, S and proximity count.
        profile: slip_share, slip_window, slip_entropy_rise, tau_g and touch_hysteresis.

    Returns:
        The next state, and whether the object slipped.
    """
    similarity, entropy = verdict.similarity, verdict.entropy
    if verdict.proximity is Proximity.NOISE:
        return SlipState(after_noise=True), False
    brighter = state.entropy is not None and entropy - state.entropy >= profile.slip_entropy_rise
    if state.lit and brighter:
        return state, False
    if state.lit or state.after_noise:
        return SlipState(levels=(similarity,), entropy=entropy), False
    relaxes = is_touch_lost(similarity, profile) or _rises(state.levels, similarity, profile)
    if relaxes and brighter:
        return SlipState(entropy=state.entropy, lit=True), False
    levels = (*state.levels, similarity)[-profile.slip_window :]
    return SlipState(levels=levels, entropy=entropy), relaxes


def is_touch_lost(similarity: float, profile: DetectorProfile) -> bool:
    """Whether S is so far above tau_g that a touch counts as ended: the upper threshold of the hysteresis."""
    return similarity >= profile.tau_g + profile.touch_hysteresis * (1.0 - profile.tau_g)


def _rises(levels: tuple[float, ...], similarity: float, profile: DetectorProfile) -> bool:
    low = min(levels, default=similarity)
    return similarity > low and similarity - low >= profile.slip_share * (1.0 - low)
