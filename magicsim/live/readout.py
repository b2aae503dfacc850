"""What the window writes beside the pictures, as HTML; every text of elsewhere is escaped."""

import base64
from html import escape

import cv2

from magicsim.arrays import Frame
from magicsim.detectors.verdict import Verdict
from magicsim.live.sight import Sight

STYLE = "width:100%;font-size:13px;border-collapse:collapse"
CELL = "padding:2px 6px;text-align:right"
ROW = "padding:2px 6px;text-align:left;font-weight:600"
LETTERS = (("E [bit]", "entropy"), ("C", "correlation"), ("S", "similarity"))


SHOWN_PX = 240
"""Width at which the camera's frame is shown [px]."""


def frame_picture(image: Frame) -> str:
    """The camera's frame, lossless and with square pixels, RGB of shape (rows, columns, 3)."""
    encoded = cv2.imencode(".png", cv2.cvtColor(image, cv2.COLOR_RGB2BGR))[1].tobytes()
    rows, columns = image.shape[:2]
    return (
        f"<img class='camera' alt='camera frame, {columns} x {rows} pixels' "
        f"src='data:image/png;base64,{base64.b64encode(encoded).decode()}' "
        f"style='width:{SHOWN_PX}px;display:block;margin:4px auto;image-rendering:pixelated'>"
    )


def verdict_table(verdicts: dict[str, Verdict | str]) -> str:
    """Table of E, C, S and the verdicts, one column a profile."""
    if not verdicts:
        return "<p style='margin:4px 0'>No frame yet.</p>"
    head = "".join(f"<th scope='col' style='{CELL}'>{escape(name)}</th>" for name in verdicts)
    rows = [
        _row(label, [f"{getattr(each, name):.3f}" if isinstance(each, Verdict) else "-" for each in verdicts.values()])
        for label, name in LETTERS
    ]
    for label, name in (("proximity", "proximity"), ("contact", "combined")):
        words = [str(getattr(each, name)) if isinstance(each, Verdict) else "-" for each in verdicts.values()]
        rows.append(_row(label, words))
    notes = "".join(
        f"<p style='margin:4px 0'>{escape(name)}: {escape(why)}</p>"
        for name, why in verdicts.items()
        if isinstance(why, str)
    )
    return f"<table class='verdicts' style='{STYLE}'><tr><td></td>{head}</tr>{''.join(rows)}</table>{notes}"


def force_lines(sight: Sight) -> str:
    """Force, contact and the cost of the step."""
    x, y, z = sight.force_n
    wish = sight.wish
    place = f"{wish.gap_mm:.2f} mm" if wish.has_object else "no object"
    rows = [
        _row("gap", ["", "", place]),
        _row("force x, y, z [N]", [f"{value:.3f}" for value in (x, y, z)]),
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
