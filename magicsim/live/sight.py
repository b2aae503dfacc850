"""What the window shows of one moment."""

from dataclasses import dataclass

from magicsim.arrays import Array
from magicsim.detectors.verdict import Verdict
from magicsim.live.wish import Wish
from magicsim.simulation.episode import SimulatedFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class Scenery:
    """The block and the object in 3D."""

    nodes_mm: Array
    """Deformed positions of the solved lattice's nodes, shape (nodes, 3) [mm]."""
    displacement_mm: Array
    """How far each node has moved, shape (nodes,) [mm]."""
    object_position_mm: Array | None
    """Origin of the object's frame in the sensor's, shape (3,) [mm]; None without an object."""
    object_rotation: Array | None
    """Rotation matrix of the object, shape (3, 3)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """One moment: what was asked for, what came of it, and what it took."""

    wish: Wish
    """Where object, lights, camera and design are now; not what was asked for where that was refused."""
    shape: Scenery
    force_n: tuple[float, float, float]
    """Force of the object on the sensor [N]."""
    slip_share: float
    """Share of the normal force that presses on sliding points, 0..1."""
    frame: SimulatedFrame | None
    """The camera's frame; None where only the lattice is solved yet."""
    verdicts: dict[str, Verdict | str]
    """Verdicts of each profile, or why it gives none."""
    refusal: str | None
    """Why what was asked for was not done; None where it was."""
    solve_s: float
    """Time of the solve [s]."""
    light_s: float
    """Time of the picture [s]; 0 where there is none yet."""

    @property
    def frames_per_second(self) -> float:
        """Rate of such steps."""
        return 1.0 / max(self.solve_s + self.light_s, 1e-6)
