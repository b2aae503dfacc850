"""An object of some weight between two fingers that close and rise: what friction carries, what slips, what falls.

The y axis of the gripper's frame points up. While the object stands, the table bears what the fingers leave out of
balance, except along the closing axis, along which it gives way. It is let go once friction carries more than all of
its weight, and then rests where both contacts, its weight and an outer wrench balance (`Gripper.hold`). Where there is
no such place above the table it is back on the table within the step: its inertia is left out, and a fall of 4 mm takes
29 ms.
"""

from dataclasses import dataclass, replace

from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import AnyObject
from magicsim.robot.fingers import ObjectPlace, half_extents_mm
from magicsim.robot.grip.held import BALANCE_SHARE
from magicsim.robot.grip.linkage import Linkage
from magicsim.robot.grip.load import Hold, Load
from magicsim.robot.gripper import Gripper
from magicsim.robot.workspace import Range, Workspace

TWIST_DEG, TILT_DEG = 25.0, 10.0
"""How far a held object may turn about the closing axis, and tilt [degrees]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reach:
    """Limits of the fingers and of the object's place."""

    touching_mm: float
    """Distance of the faces at which both just touch the object [mm]."""
    gap_mm: Range
    """Mean distance of the object's sides from the faces [mm], negative when pressed."""
    finger_mm: Range
    """Height of the fingers [mm]."""
    workspace: Workspace
    """Workspace of the object, in the gripper's frame."""

    @classmethod
    def around(
        cls, target: AnyObject, *, start_gap_mm: Range, offset_mm: float, target_mm: float, deepest_mm: float
    ) -> "Reach":
        """Limits of a task; `ConfigError` where fingers would pass through each other, or the object does not fit."""
        linkage, touching = Linkage(), sum(half_extents_mm(target))
        narrowest, widest = (linkage.width_mm(angle) for angle in (linkage.least_deg, linkage.most_deg))
        deepest = (touching - narrowest) / 2
        if deepest_mm >= deepest:
            raise ConfigError(
                f"deepest_mm = {deepest_mm:g} is not allowed: the fingers would pass through each other, must be below "
                f"{deepest:.4g}, where they are closed"
            )
        linkage.check_room(target.kind, touching)
        opened, highest, aside = min(2 * start_gap_mm[1], (widest - touching) / 2), 2 * target_mm, offset_mm + ROOM_MM
        workspace = Workspace(
            x_mm=(-aside, aside),
            y_mm=(-offset_mm - highest, aside),
            twist_deg=(-TWIST_DEG, TWIST_DEG),
            tilt_x_deg=(-TILT_DEG, TILT_DEG),
            tilt_y_deg=(-TILT_DEG, TILT_DEG),
            gap_mm=(-deepest_mm, opened + offset_mm),
        )
        return cls(touching_mm=touching, gap_mm=(-deepest_mm, opened), finger_mm=(0.0, highest), workspace=workspace)

    def width_at_mm(self, gap_mm: float) -> float:
        """Distance of the faces at a mean gap [mm]."""
        return 2 * gap_mm + self.touching_mm

    def gap_at_mm(self, width_mm: float) -> float:
        """The mean gap at a distance of the faces [mm]."""
        return (width_mm - self.touching_mm) / 2


ROOM_MM = 1.1
"""How far a held object may move from where it stood between the fingers, beyond the way to the table [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiftState:
    """Where fingers and object are."""

    width_mm: float
    """Distance between the contact faces [mm]."""
    finger_mm: float = 0.0
    """Height of the fingers above where they started [mm]."""
    object_mm: float = 0.0
    """Height of the object above the table [mm]."""
    carried_n: float = 0.0
    """Upward force of both fingers on the object [N]; negative when they push it down."""
    normal_n: float = 0.0
    """Larger normal force of the two fingers [N]."""
    slip_share: float = 0.0
    """Share of the normal force on sliding points, 0..1, of the finger that slides more."""
    slip_mm: float = 0.0
    """How far that skin slid over the object in the last step which slid more [mm]."""
    hold: Hold = Hold.PLACED
    """`placed` on the table, `held` or `slipped` above it, or `dropped` on it in the last step."""

    @property
    def has_dropped(self) -> bool:
        """Whether the object fell back to the table in the last step."""
        return self.hold is Hold.DROPPED


class Lift:
    """One object between the fingers, moved by `step`."""

    def __init__(self, gripper: Gripper, *, load: Load, width_mm: float, place: ObjectPlace) -> None:
        """Places the object on the table between the fingers, which push it away where they would press it."""
        self.gripper, self.load = gripper, load
        self._y_mm = place.y_mm
        gripper.close(width_mm, place=place, floats=True)
        self.state = LiftState(width_mm=width_mm)

    def step(self, *, closing_mm: float, rising_mm: float) -> LiftState:
        """Moves both fingers and finds where the object is afterwards.

        Raises:
            ConfigError: The fingers would leave the workspace, or the load presses the object deeper than it goes;
                nothing has changed.
            ConvergenceError: No valid equilibrium was found; nothing has changed.
        """
        gripper, last = self.gripper, self.state
        before, slid = gripper.now(), [finger.slid_mm for finger in gripper.fingers]
        width, finger = last.width_mm - 2 * closing_mm, last.finger_mm + rising_mm
        try:
            height = self._settle(width, finger)
            truth = gripper.truth()
            fell = height == 0 < last.object_mm and last.object_mm + min(rising_mm, 0.0) > 0
            ways = [each.slid_mm - way for each, way in zip(gripper.fingers, slid, strict=True)]
            self.state = LiftState(
                width_mm=width,
                finger_mm=finger,
                object_mm=height,
                carried_n=truth.force_n[1],
                normal_n=max(truth.upper.force_n[2], truth.lower.force_n[2]),
                slip_share=max(each.slip_share for each in gripper.fingers),
                slip_mm=max(ways),
                hold=Hold.DROPPED if fell else gripper.outcome,
            )
        except BaseException:
            gripper.go_back(before)
            raise
        return self.state

    def _settle(self, width_mm: float, finger_mm: float) -> float:
        """Height of the object [mm]; the gripper is left there."""
        gripper, load = self.gripper, self.load
        if gripper.outcome is Hold.PLACED:
            self._stand(width_mm, finger_mm)
            borne = load.weight_n - load.force_n[1] - gripper.truth().force_n[1]
            if borne >= -BALANCE_SHARE * load.weight_n:
                return 0.0
        before = gripper.now()
        most = ROOM_MM + self.state.object_mm
        if gripper.hold(width_mm, load=load, most_slide_mm=most) is not Hold.DROPPED:
            height = gripper.place.y_mm - self._y_mm + finger_mm
            if height > 0:
                return height
        gripper.go_back(before)
        self._stand(width_mm, finger_mm)
        return 0.0

    def _stand(self, width_mm: float, finger_mm: float) -> None:
        """The object upright on the table, giving way along the closing axis alone."""
        upright = replace(
            self.gripper.place, y_mm=self._y_mm - finger_mm, twist_deg=0.0, tilt_x_deg=0.0, tilt_y_deg=0.0
        )
        self.gripper.close(width_mm, place=upright, floats=True)
