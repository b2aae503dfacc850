"""Matplotlib figures as SVG text for a page: same input, same bytes, nothing loaded from outside.

Colours are told apart with any colour vision (Okabe and Ito, Color Universal Design, 2008).

A curve of force against depth becomes a table or a picture here too.
"""

import csv
import html
import io
import re
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import matplotlib as mpl
from matplotlib import style
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from magicsim.deform.indentation.press import PressCurve
from magicsim.errors import ConfigError
from magicsim.folder import PRODUCER, check_file, result_file
from magicsim.frame_class import FrameClass

CLASS_COLORS = {
    FrameClass.CLEAR: "#999999",
    FrameClass.NEAR: "#56b4e9",
    FrameClass.CONTACT: "#cc79a7",
    FrameClass.LIGHT: "#f0e442",
}
"""Shade behind the frames of each class; frames that are not scored have none."""
ORANGE = "#e69f00"
INK, FAINT, LINE, BLUE, WRONG = "#010203", "#010204", "#010205", "#010206", "#010207"
"""Stand for the page's colours of text, thin lines, measured curves, its blue and wrong verdicts until `THEME`
replaces them."""
THEME = {
    INK: "var(--ink, #1f2933)",
    FAINT: "var(--faint, #d5dae1)",
    LINE: "var(--curve, #0b3c6f)",
    BLUE: "var(--blue, #0072b2)",
    WRONG: "var(--mark, #d55e00)",
}
"""What replaces the stand-ins in a finished drawing, so that it follows the page's light or dark theme."""


WIDTH_IN = 4.9
"""Width of every drawing [in]: about a phone's window at one point a pixel."""
_SIZE = re.compile(r'(?<=\s)(?:width|height)="[\d.]+pt" ?')
"""Width and height of the whole drawing, in its first line."""
_STYLE = {
    "svg.hashsalt": "magicsim",
    "svg.fonttype": "none",
    "text.parse_math": False,
    "path.simplify": False,
    "font.size": 9.5,
    "axes.titlesize": 9.5,
    "axes.labelsize": 9.5,
    "xtick.labelsize": 9.0,
    "ytick.labelsize": 9.0,
    "legend.fontsize": 9.0,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.titlecolor": INK,
    "xtick.color": INK,
    "ytick.color": INK,
    "axes.edgecolor": FAINT,
    "axes.facecolor": "none",
    "figure.facecolor": "none",
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlelocation": "left",
    "legend.frameon": False,
    "lines.linewidth": 1.4,
}


@contextmanager
def plot_style() -> Iterator[None]:
    """The report's look, whatever the user's own settings are; those are back afterwards."""
    with style.context(["default", _STYLE]):
        yield


def drawn_panel(height_in: float, place: tuple[float, float, float, float]) -> tuple[Figure, Axes]:
    """A figure of the page's width with one panel on a faint grid. To be called within `plot_style`.

    `place` is left, bottom, width and height of the panel, in shares of the figure.
    """
    figure = Figure(figsize=(WIDTH_IN, height_in))
    panel = figure.add_axes(place)
    panel.grid(visible=True, color=FAINT, linewidth=0.6)
    panel.tick_params(length=0.0, colors=INK)
    return figure, panel


def to_svg(figure: Figure, *, name: str, label: str) -> str:
    """The drawing as an `svg` element that fills the width it is given. To be called within `plot_style`."""
    buffer = io.StringIO()
    with mpl.rc_context({"svg.hashsalt": name}):
        figure.savefig(buffer, format="svg", metadata=dict.fromkeys(("Creator", "Date", "Format", "Type")))
    svg = buffer.getvalue()
    svg = svg[svg.index("<svg") :]
    svg = re.sub(r"\s*<metadata>.*?</metadata>", "", svg, flags=re.DOTALL)
    svg = re.sub(r"\s*<defs>\s*<style.*?</defs>", "", svg, count=1, flags=re.DOTALL)
    svg = re.sub(r'\bid="', f'id="{name}-', svg)
    svg = svg.replace("url(#", f"url(#{name}-").replace('xlink:href="#', f'xlink:href="#{name}-')
    for stand_in, color in THEME.items():
        svg = svg.replace(stand_in, color)
    svg = _SIZE.sub("", svg, count=2)
    return svg.replace("<svg", f'<svg role="img" aria-label="{html.escape(label)}" style="stroke-linejoin: round"', 1)


COLUMNS = (
    "depth_mm", "force_x_n", "force_y_n", "force_z_n", "torque_x_nmm", "torque_y_nmm", "torque_z_nmm",
    "contact_area_mm2",
)  # fmt: skip
SUFFIXES = (".csv", ".png")


def check_curve_file(target: Path) -> None:
    """Refuses (`ConfigError`, `OutputError`) a file that a curve cannot become, before it is solved."""
    if target.suffix.lower() not in SUFFIXES:
        raise ConfigError(f"curve = '{target}' is not allowed: must end in {' or '.join(SUFFIXES)}")
    check_file(target)


def write_curve(curve: PressCurve, target: Path, *, title: str) -> None:
    """Writes a table with a row a depth, `COLUMNS`, or draws force and contact area against depth."""
    check_curve_file(target)
    with result_file(target) as partial:
        if target.suffix.lower() == ".csv":
            with partial.open("w", newline="", encoding="utf-8") as file:
                rows = csv.writer(file)
                rows.writerow(COLUMNS)
                for each in curve.points:
                    rows.writerow([each.depth_mm, *each.force_n, *each.torque_nmm, each.contact_area_mm2])
        else:
            _draw(curve, partial, title)


def _draw(curve: PressCurve, target: Path, title: str) -> None:
    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    force, area = figure.subplots(1, 2)
    force.plot(curve.depths_mm, curve.forces_n[:, 2], "o-", color="#0072b2", markersize=3, linewidth=1.2)
    area.plot(curve.depths_mm, curve.areas_mm2, "o-", color="#d55e00", markersize=3, linewidth=1.2)
    force.set(xlabel="depth [mm]", ylabel="normal force [N]")
    area.set(xlabel="depth [mm]", ylabel="contact area [mm²]")
    for panel in (force, area):
        panel.grid(visible=True, color="#e4e4e4", linewidth=0.6)
        panel.set(xlim=(0, None), ylim=(0, None))
    figure.suptitle(title, fontsize="medium", parse_math=False)
    figure.savefig(target, format="png", dpi=150, metadata={"Software": PRODUCER})
