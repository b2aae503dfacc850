"""What the user of the window asks for and what it shows: one value each that holds all of it.

Of what is asked for only the newest one counts.
"""

from dataclasses import dataclass, replace
from typing import Self

from magicsim.arrays import Array
from magicsim.detectors.verdict import Verdict
from magicsim.geometry.design import ElastomerDesign
from magicsim.robot.darkroom import FULL, Rgb
from magicsim.robot.workspace import Workspace
from magicsim.simulation.episode import SimulatedFrame

DESIGN_FIELDS = {"skin_mm": (0.3, 3.0), "core_mm": (1.0, 12.0), "cell_mm": (0.4, 3.0), "wall_mm": (0.1, 1.0)}
"""Fields of a design that have a slider, each with its ends [mm]."""
START_GAP_MM = 4.0
"""Gap at which the object waits when the window opens [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wish:
    """Object, lights, camera and design as they are asked for."""

    gap_mm: float = START_GAP_MM
    """Distance of the object's highest point from the undeformed contact face [mm], negative when pressed."""
    x_mm: float = 0.0
    y_mm: float = 0.0
    twist_deg: float = 0.0
    has_object: bool = True
    flashlight: bool = False
    light_x_mm: float = 0.0
    """Shift of the flashlight along x [mm]."""
    led_strength: Rgb = FULL
    """Strengths of the strips' red, green and blue, in units of the rig's radiance."""
    exposure_grey: float
    """Mean grey level of the untouched sensor that exposure aims at."""
    design: tuple[float, ...]
    """Values of `DESIGN_FIELDS`, in their order [mm]."""

    @classmethod
    def of(cls, design: ElastomerDesign, *, exposure_grey: float, has_object: bool) -> Self:
        """What a window shows first."""
        return cls(exposure_grey=exposure_grey, has_object=has_object, design=design_values(design))

    def pushed(self, space: Workspace, **by: float) -> Self:
        """The wish with the object moved by so much, kept inside of the workspace.

        Args:
            space: Where the object may go.
            by: Changes of `gap_mm`, `x_mm`, `y_mm` [mm] and `twist_deg` [degrees].
        """
        moved: dict[str, float] = {}
        for name, step in by.items():
            low, high = getattr(space, name)
            moved[name] = round(min(max(getattr(self, name) + step, low), high), 6)
        return replace(self, **moved)  # type: ignore[arg-type]


def design_values(design: ElastomerDesign) -> tuple[float, ...]:
    """Values of `DESIGN_FIELDS` of a design, in their order [mm]."""
    return tuple(float(getattr(design, name)) for name in DESIGN_FIELDS)


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
