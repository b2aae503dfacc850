"""What is true of both fingers and the object between them, and the frames that show it."""

from dataclasses import dataclass, field

from magicsim.deform.indentation.path import as_vector
from magicsim.robot.fingers import ObjectPlace
from magicsim.robot.grip.load import Hold, Load
from magicsim.robot.grip.pair import Moments, both_wrench
from magicsim.simulation.episode import FrameTruth, SimulatedFrame, Vector


@dataclass(frozen=True, slots=True, kw_only=True)
class GripState:
    """Where fingers and object are, in the gripper's frame."""

    width_mm: float
    """Distance between the contact faces at rest [mm]."""
    place: ObjectPlace
    """The object; where it was last, once it has dropped."""
    hold: Hold = Hold.PLACED
    """What became of the object in the last motion."""
    load: Load = field(default_factory=Load)
    """What acts on it beside the fingers, where these hold it."""
    slid_mm: float = 0.0
    """How far it slid over the skin in the last motion, the larger of both fingers [mm]."""
    limit: str | None = None
    """The coordinate of `place` at whose end in the workspace the object was still driven on, and counts as dropped."""
    is_stalled: bool = False
    """Whether the motors stopped at their force in the last motion."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GripTruth(GripState):
    """What is true of both fingers and the object at once, in the gripper's frame."""

    force_n: Vector
    """Force of both fingers on the object [N]."""
    torque_nmm: Vector
    """Their torque on it about its origin [N mm]."""
    imbalance_n: float
    """Normal force of the upper finger less that of the lower [N]; what is left of it where the object floats."""
    upper: FrameTruth
    """The upper finger's, in its own frame."""
    lower: FrameTruth
    """The lower finger's, in its own frame."""
    angle_deg: float = 0.0
    """Angle of the cranks [degrees]."""

    @property
    def beyond_limits(self) -> str:
        """What of either finger's touch is above the limits of its design; empty where nothing is."""
        return self.upper.beyond_limits or self.lower.beyond_limits


@dataclass(frozen=True, slots=True, kw_only=True)
class GripFrames:
    """One frame of each finger, taken at the same moment."""

    upper: SimulatedFrame
    lower: SimulatedFrame
    truth: GripTruth


@dataclass(frozen=True, slots=True, kw_only=True)
class GripMoment:
    """One moment of the gripper, for `Gripper.go_back`."""

    fingers: Moments
    state: GripState


def grip_truth(state: GripState, upper: FrameTruth, lower: FrameTruth, *, angle_deg: float) -> GripTruth:
    """Truth of fingers and object from that of each finger."""
    wrench = both_wrench((upper, lower), state.width_mm, state.place)
    return GripTruth(
        **{name: getattr(state, name) for name in GripState.__slots__}, force_n=as_vector(wrench[:3]),
        torque_nmm=as_vector(wrench[3:]), imbalance_n=upper.force_n[2] - lower.force_n[2], upper=upper, lower=lower,
        angle_deg=angle_deg,
    )  # fmt: skip
