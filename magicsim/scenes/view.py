"""What the camera is to see."""

from dataclasses import dataclass

from magicsim.arrays import Array
from magicsim.geometry.indenter import Indenter
from magicsim.geometry.pose import Pose


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """State of everything that light meets. Arrays are compared by identity: pass the same one while nothing moves."""

    body: Array | None = None
    """Deformed body vertices, shape (vertices, 3) [mm]; None at rest."""
    infill: Array | None = None
    """Deformed infill vertices, shape (vertices, 3) [mm]; None at rest."""
    markers: Array | None = None
    """Displaced vertices of markers below the face, shape (vertices, 3) [mm]; None at rest."""
    indenter: Indenter | None = None
    """The object where it is, or None."""
    flashlight_x_mm: float | None = None
    """Shift of the outside light [mm], or None while it is off."""

    facing_mm: float | None = None
    """Distance to the contact face of another finger that looks back [mm]; None without one."""

    is_released: bool = False
    """Whether a deformed block is touched no more, and only a dent is left."""
    passing_mm: float | None = None
    """Where something that passes in the room is along x [mm]; None while it is out of sight."""
    companion: Pose | None = None
    """Pose of what is seen beside the object and touches nothing; None while it is away."""

    @property
    def is_untouched(self) -> bool:
        """Whether this is the sensor alone, as the anchor holds it."""
        return self.is_undeformed and self.indenter is None and self.flashlight_x_mm is None and self.facing_mm is None

    @property
    def is_undeformed(self) -> bool:
        """Whether the block is as it was built, whatever stands before it."""
        return self.body is None and self.infill is None
