"""How far the two fingers of `GraspLift` close, open and rise, and where its object may go between them."""

from dataclasses import dataclass

from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import AnyObject
from magicsim.robot.fingers import half_extents_mm
from magicsim.robot.grip.linkage import Linkage
from magicsim.robot.lift import ROOM_MM
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
        """The limits of a task.

        Args:
            target: The object.
            start_gap_mm: Smallest and largest gap at the start [mm]; the fingers open to twice the largest.
            offset_mm: Largest shift of the object along each axis at the start [mm].
            target_mm: Height to lift it to [mm]; the fingers rise to twice that.
            deepest_mm: Largest indentation of a finger [mm].

        Raises:
            ConfigError: The fingers would pass through each other, or the object does not fit between them.
        """
        linkage, touching = Linkage(), sum(half_extents_mm(target))
        narrowest, widest = (linkage.width_mm(angle) for angle in (linkage.least_deg, linkage.most_deg))
        deepest = (touching - narrowest) / 2
        if deepest_mm >= deepest:
            msg = (
                f"deepest_mm = {deepest_mm:g} is not allowed: the fingers would pass through each other, must be below "
                f"{deepest:.4g}, where they are closed"
            )
            raise ConfigError(msg)
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
