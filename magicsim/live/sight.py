"""What the user of the window asks for, what it shows, and how that is written as HTML.

Of what is asked for only the newest value counts; every text of elsewhere is escaped.
"""

import base64
from dataclasses import dataclass, field, replace
from html import escape
from typing import Self

import cv2

from magicsim.arrays import AnyArray, Array, Frame
from magicsim.detectors.verdict import Verdict
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.pose import Pose
from magicsim.notebook.screen import STRONGER, beside_change
from magicsim.robot.darkroom import FULL, Rgb
from magicsim.robot.workspace import Workspace
from magicsim.simulation.episode import SimulatedFrame

DESIGN_FIELDS = {"skin_mm": (0.3, 3.0), "core_mm": (1.0, 12.0), "cell_mm": (0.4, 3.0), "wall_mm": (0.1, 1.0)}
"""Fields of a design that have a slider, each with its ends [mm]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Wish:
    """Object, lights, camera and design as they are asked for."""

    gap_mm: float = 4.0
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

    def pushed(self, space: Workspace, **by: float) -> Self:
        """The wish with the object moved by `gap_mm`, `x_mm`, `y_mm` and `twist_deg`, kept inside of the workspace."""
        moved: dict[str, float] = {}
        for name, step in by.items():
            low, high = getattr(space, name)
            moved[name] = round(min(max(getattr(self, name) + step, low), high), 6)
        return replace(self, **moved)  # type: ignore[arg-type]


def design_values(design: ElastomerDesign) -> tuple[float, ...]:
    """Values of `DESIGN_FIELDS` of a design, in their order [mm]."""
    return tuple(float(getattr(design, name)) for name in DESIGN_FIELDS)


@dataclass(frozen=True, slots=True, kw_only=True)
class Sight:
    """One moment: what was asked for, what came of it, and what it took."""

    wish: Wish
    """Where object, lights, camera and design are now; not what was asked for where that was refused."""
    nodes_mm: Array
    """Deformed positions of the solved lattice's nodes, shape (nodes, 3) [mm]."""
    displacement_mm: Array
    """How far each node has moved, shape (nodes,) [mm]."""
    object_pose: Pose | None
    """The object in the sensor's frame; None without one."""
    force_n: tuple[float, float, float]
    """Force of the object on the sensor [N]."""
    slip_share: float
    """Share of the normal force that presses on sliding points, 0..1."""
    frame: SimulatedFrame | None = None
    """The camera's frame; None where only the lattice is solved yet."""
    verdicts: dict[str, Verdict | str] = field(default_factory=dict)
    """Verdicts of each profile, or why it gives none."""
    refusal: str | None
    """Why what was asked for was not done; None where it was."""
    solve_s: float
    """Time of the solve [s]."""
    light_s: float = 0.0
    """Time of the picture [s]; 0 where there is none yet."""

    @property
    def frames_per_second(self) -> float:
        """Rate of such steps."""
        return 1.0 / max(self.solve_s + self.light_s, 1e-6)


STYLE = "width:100%;font-size:13px;border-collapse:collapse"
CELL = "padding:2px 6px;text-align:right"
ROW = "padding:2px 6px;text-align:left;font-weight:600"
SAID = {
    "E [bit]": "entropy", "C": "correlation", "S": "similarity", "proximity": "proximity", "contact": "combined"
}  # fmt: skip
"""Rows of the table of verdicts, each with the field that it shows."""
SHOWN_PX = 420
"""Width at which the camera's frame and its change are shown, or the panel's where that is less [px]."""


def frame_picture(image: Frame, rest: AnyArray, *, gamma: float) -> str:
    """The camera's frame for a screen beside its change, see `magicsim.notebook.screen.beside_change`; lossless."""
    shown = beside_change(image, rest, gamma=gamma)
    encoded = cv2.imencode(".png", cv2.cvtColor(shown, cv2.COLOR_RGB2BGR))[1].tobytes()
    (rows, columns), drawn = image.shape[:2], "pixelated" if shown.shape[1] < SHOWN_PX else "auto"
    return (
        f"<img class='camera' alt='camera frame, {columns} x {rows} pixels, and {STRONGER} times its change' "
        f"src='data:image/png;base64,{base64.b64encode(encoded).decode()}' "
        f"style='width:{SHOWN_PX}px;max-width:100%;display:block;margin:4px auto;image-rendering:{drawn}'>"
    )


def verdict_table(verdicts: dict[str, Verdict | str]) -> str:
    """Table of E, C, S and the verdicts, one column a profile."""
    if not verdicts:
        return "<p style='margin:4px 0'>No frame yet.</p>"
    head = "".join(f"<th scope='col' style='{CELL}'>{escape(name)}</th>" for name in verdicts)
    rows = []
    for label, name in SAID.items():
        said = [getattr(each, name) if isinstance(each, Verdict) else "-" for each in verdicts.values()]
        rows.append(_row(label, [f"{each:.3f}" if isinstance(each, float) else str(each) for each in said]))
    notes = "".join(
        f"<p style='margin:4px 0'>{escape(name)}: {escape(why)}</p>"
        for name, why in verdicts.items()
        if isinstance(why, str)
    )
    return f"<table class='verdicts' style='{STYLE}'><tr><td></td>{head}</tr>{''.join(rows)}</table>{notes}"


def force_lines(sight: Sight) -> str:
    """Force, contact and the cost of the step."""
    place = f"{sight.wish.gap_mm:.2f} mm" if sight.wish.has_object else "no object"
    rows = [
        _row("gap", ["", "", place]),
        _row("force x, y, z [N]", [f"{value:.3f}" for value in sight.force_n]),
        _row("slipping", ["", "", f"{sight.slip_share:.2f}"]),
        _row("solve, light [s]", ["", f"{sight.solve_s:.2f}", f"{sight.light_s:.2f}" if sight.frame else "..."]),
        _row("frames / s", ["", "", f"{sight.frames_per_second:.2f}" if sight.frame else "..."]),
    ]
    return f"<table class='forces' style='{STYLE}'>{''.join(rows)}</table>"


def state_line(busy: tuple[str, float] | None, refusal: str | None) -> str:
    """What is going on, and why the last wish was refused."""
    doing = "ready" if busy is None else f"{busy[0]}, {busy[1]:.0f} s"
    why = f"<br><span role='alert' class='refusal' style='color:#b3261e'>{escape(refusal)}</span>" if refusal else ""
    return f"<p class='state' role='status' style='margin:4px 8px'>{escape(doing)}{why}</p>"


def _row(label: str, cells: list[str]) -> str:
    inner = "".join(f"<td style='{CELL}'>{escape(cell)}</td>" for cell in cells)
    return f"<tr><th scope='row' style='{ROW}'>{escape(label)}</th>{inner}</tr>"
