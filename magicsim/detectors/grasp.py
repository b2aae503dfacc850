"""The grasp state machine: wait, close, grasp, transport, and back after a slip.

Published as the MagicGripper's grasping run (Fan, Li, Zhang, arXiv 2505.24382): Approaching that is held for some
frames closes the gripper, a similarity below the threshold means grasped, then the object is moved, and a sudden rise
of the similarity means that it slipped. Outside light never closes the gripper. The numbers of frames and the
hysteresis are options of the profile; both are assumed.

Light that comes or goes changes S as a slip does, so a frame that proximity calls Noise and the one after it are no
evidence of a slip, and no rise is measured across them. How much is sudden is not published: here it is a share of what
the touch had taken from S, which suits designs whose S falls to 0.1 on contact as well as designs where it falls to
0.95. A held object shades and colours outside light, so that Noise may not be seen. But an object that leaves takes its
light away: a rise of S together with a rise of E is light and no slip, until E has come back.
"""

from dataclasses import dataclass, field, replace
from enum import StrEnum

from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import Contact, Proximity, Verdict


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
    low = min(state.levels, default=similarity)
    rises = similarity > low and similarity - low >= profile.slip_share * (1.0 - low)
    relaxes = is_touch_lost(similarity, profile) or rises
    if relaxes and brighter:
        return SlipState(entropy=state.entropy, lit=True), False
    levels = (*state.levels, similarity)[-profile.slip_window :]
    return SlipState(levels=levels, entropy=entropy), relaxes


def is_touch_lost(similarity: float, profile: DetectorProfile) -> bool:
    """Whether S is so far above tau_g that a touch counts as ended: the upper threshold of the hysteresis."""
    return similarity >= profile.tau_g + profile.touch_hysteresis * (1.0 - profile.tau_g)


class GraspStage(StrEnum):
    """What the gripper does."""

    WAITING = "Waiting"
    """Open; until Approaching has been seen for `approach_frames`."""
    CLOSING = "Closing"
    """Closing; until Touched has been seen for `touch_frames`, or for `close_frames` at most."""
    GRASPED = "Grasped"
    """Holding, not yet moving; for `transport_frames`."""
    TRANSPORTING = "Transporting"
    """Holding and moving."""
    SLIPPED = "Slipped"
    """The object was lost in the frame before; for one frame."""
    RETURNING = "Returning"
    """Opening and going back; until Untouched has been seen for `return_frames`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GraspState:
    """The machine between two frames."""

    stage: GraspStage = GraspStage.WAITING
    run: int = 0
    """Frames in a row that speak for the next stage."""
    frames: int = 0
    """Frames in this stage so far."""
    slip: SlipState = field(default_factory=SlipState)
    """Memory of the slip detection while holding."""


def step_grasp(state: GraspState, verdict: Verdict, profile: DetectorProfile, *, opening: bool = False) -> GraspState:
    """The machine after one more frame; a pure function of what it is given.

    Args:
        state: `GraspState()` first, then from the step before.
        verdict: Of the frame.
        profile: Numbers of frames, hysteresis, slip, thresholds.
        opening: Whether the gripper opens on purpose, so that losing the object is no slip.
    """
    if opening and state.stage not in (GraspStage.WAITING, GraspStage.RETURNING):
        return GraspState(stage=GraspStage.RETURNING)
    return _STEPS[state.stage](replace(state, frames=state.frames + 1), verdict, profile)


def _waiting(state: GraspState, verdict: Verdict, profile: DetectorProfile) -> GraspState:
    """Approaching counts; Noise ends the run; Normal ends it unless E is only just below tau_e."""
    if verdict.proximity is Proximity.APPROACHING:
        return _advance(state, profile.approach_frames, GraspStage.CLOSING)
    nearly = verdict.entropy >= profile.tau_e - profile.entropy_hysteresis
    keeps = verdict.proximity is Proximity.NORMAL and nearly
    return state if keeps else replace(state, run=0)


def _closing(state: GraspState, verdict: Verdict, profile: DetectorProfile) -> GraspState:
    """Touched counts; Unknown is no evidence; Untouched ends the run once the touch is lost."""
    if verdict.combined is Contact.TOUCHED:
        state = _advance(state, profile.touch_frames, GraspStage.GRASPED)
    elif verdict.combined is Contact.UNTOUCHED and is_touch_lost(verdict.similarity, profile):
        state = replace(state, run=0)
    if state.stage is GraspStage.CLOSING and state.frames >= profile.close_frames:
        return GraspState(stage=GraspStage.RETURNING)
    return state


def _holding(state: GraspState, verdict: Verdict, profile: DetectorProfile) -> GraspState:
    """A slip ends it; otherwise transport begins after some frames, of which Noise counts none."""
    memory, slipped = step_slip(state.slip, verdict, profile)
    if slipped:
        return GraspState(stage=GraspStage.SLIPPED)
    state = replace(state, slip=memory)
    if state.stage is GraspStage.TRANSPORTING or verdict.proximity is Proximity.NOISE:
        return state
    return replace(_advance(state, profile.transport_frames, GraspStage.TRANSPORTING), slip=memory)


def _slipped(state: GraspState, verdict: Verdict, profile: DetectorProfile) -> GraspState:
    return _returning(GraspState(stage=GraspStage.RETURNING), verdict, profile)


def _returning(state: GraspState, verdict: Verdict, profile: DetectorProfile) -> GraspState:
    """Untouched counts; Unknown is no evidence; Touched ends the run."""
    if verdict.combined is Contact.UNTOUCHED:
        return _advance(state, profile.return_frames, GraspStage.WAITING)
    return replace(state, run=0) if verdict.combined is Contact.TOUCHED else state


def _advance(state: GraspState, needed: int, following: GraspStage) -> GraspState:
    """One more frame of the run, or the next stage when that was the last one needed."""
    return GraspState(stage=following) if state.run + 1 >= needed else replace(state, run=state.run + 1)


_STEPS = {
    GraspStage.WAITING: _waiting,
    GraspStage.CLOSING: _closing,
    GraspStage.GRASPED: _holding,
    GraspStage.TRANSPORTING: _holding,
    GraspStage.SLIPPED: _slipped,
    GraspStage.RETURNING: _returning,
}
"""What each stage does with a frame."""
