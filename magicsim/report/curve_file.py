"""A curve of force against depth as a table or as a picture."""

import csv
from pathlib import Path

from magicsim.deform.indentation.press import PressCurve
from magicsim.errors import ConfigError
from magicsim.folder import PRODUCER, check_file, result_file

COLUMNS = (
    "depth_mm", "force_x_n", "force_y_n", "force_z_n", "torque_x_nmm", "torque_y_nmm", "torque_z_nmm",
    "contact_area_mm2",
)  # fmt: skip
SUFFIXES = (".csv", ".png")


def check_curve_file(target: Path) -> None:
    """Refuses a file that a curve cannot become, before it is solved.

    Raises:
        ConfigError: Its name does not say which kind of file.
        OutputError: It cannot be written.
    """
    if target.suffix.lower() not in SUFFIXES:
        raise ConfigError(f"curve = '{target}' is not allowed: must end in {' or '.join(SUFFIXES)}")
    check_file(target)


def write_curve(curve: PressCurve, target: Path, *, title: str) -> None:
    """Writes a table with a row a depth, `COLUMNS`, or draws force and contact area against depth.

    Raises:
        ConfigError: Another ending.
        OutputError: The file cannot be written.
    """
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
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    force, area = figure.subplots(1, 2)
    force.plot(curve.depths_mm, curve.forces_n[:, 2], "o-", color="#0072b2", markersize=3, linewidth=1.2)
    area.plot(curve.depths_mm, curve.areas_mm2, "o-", color="#d55e00", markersize=3, linewidth=1.2)
    force.set(xlabel="depth [mm]", ylabel="normal force [N]")
    area.set(xlabel="depth [mm]", ylabel="contact area [mm²]")
    for panel in (force, area):
        panel.grid(visible=True, color="#e4e4e4", linewidth=0.6)
        panel.set(xlim=(0, None), ylim=(0, None))
    figure.suptitle(title, fontsize="medium")
    figure.savefig(target, format="png", dpi=150, metadata={"Software": PRODUCER})
