"""The predictions as Markdown."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from relaxation_curve import READING_S, SPEEDS_MM_S, ramp_ratio

YIELD_STRAINS = (0.3, 1.0)
"""Of the infill."""
Rows = list[dict[str, Any]]
HEAD = """# Predictions

Written by `python benchmarks/predictions.py` before any comparison; its docstring says what the uncertainty after each
value contains. The moduli meet two hardness readings and nothing else ([](validation.md)); they are the stiffness some
seconds after contact, and the tables by speed say what time does to them.
"""


def markdown(results: dict[str, Any]) -> str:
    """All parts that were computed, each with its setting."""
    lines = [HEAD]
    if "press" in results:
        setting, variants = results["press"]["setting"], list(results["press"]["variants"])
        lines += _press(results["press"]["rows"], _how(setting, variants))
        lines += ["", *_timed(results["press"]["rows"])]
    if "effects" in results:
        lines += ["", *_effects(results["effects"])]
    if "shear" in results:
        setting, variants = results["shear"]["setting"], list(results["shear"]["variants"])
        lines += ["", *_shear(results["shear"]["rows"], _how(setting, variants))]
    return "\n".join(lines) + "\n"


def _how(setting: dict[str, Any], variants: list[str]) -> str:
    before = setting.get("rescaled_from_mpa")
    note = f" Carried over from {before:g} MPa (`--rescale`)." if before else ""
    return (
        f"Body {setting['body_mpa']:g} MPa (Young), infill {setting['infill_mpa']:g} MPa (shear), walls of "
        f"{setting['wall_mm']:g} mm, bonded base, nodes {setting['spacing_mm']:g} mm apart below the object, friction "
        f"{setting['friction']:g}. Variants: {', '.join(variants) or 'none yet, so no uncertainty'}.{note}"
    )


def _press(rows: Rows, how: str) -> list[str]:
    found, heads, depths = _by_depth(rows)
    head = ["depth [mm]", *(f"{diameter:g} mm, skin {skin:g}" for diameter, skin in heads)]
    body = [_line([depth, *(_short(found[*pair, depth], "force_n") for pair in heads)]) for depth in depths]
    return ["## Force of a domed cylinder at the stiffness of the readings [N]", "", how, "", *_head(head), *body]


def _timed(rows: Rows) -> list[str]:
    """Force at each speed, between the readings' earliest and latest time."""
    found, heads, depths = _by_depth(rows)
    lines = [
        "## Force of a domed cylinder by speed [N]", "",
        f"The forces above by Fung's quasi-linear viscoelasticity on the shifted master curve of Agilus30 "
        f"(`benchmarks/relaxation_curve.py`): for a reading {READING_S[0]:g} s after contact, in brackets for one "
        f"after {READING_S[1]:g} s. The uncertainty of the table above comes on top.",
    ]  # fmt: skip
    for speed in SPEEDS_MM_S:
        lines += ["", f"### At {speed:g} mm/s", ""]
        lines += _head(["depth [mm]", *(f"{diameter:g} mm, skin {skin:g}" for diameter, skin in heads)])
        ratios = {}
        for pair in heads:
            path = [(each, found[*pair, each]["value"]["force_n"]) for each in depths if found[*pair, each]["value"]]
            ratios[pair] = {
                reading: ramp_ratio(np.array(path), speed_mm_s=speed, reading_s=reading) for reading in READING_S
            }
        for place, depth in enumerate(depths):
            cells: list[Any] = [depth]
            for pair in heads:
                force = found[*pair, depth]["value"]["force_n"]
                early, late = (force * ratios[pair][reading][place] for reading in READING_S)
                cells.append(f"{early:.3g} (to {late:.3g})")
            lines.append(_line(cells))
    return lines


def _effects(effects: dict[str, Rows]) -> list[str]:
    """What walls and mounting change, and the skin's stretch."""
    lines = [
        "## Walls, mounting, and the skin", "",
        "By `python benchmarks/prediction_effects.py`, homogenised core: change of the force with walls of 0.2 mm and "
        "the moduli nearest to both readings, and on a table (friction 0.7); largest stretch and difference of "
        "principal stresses [MPa] of the skin in the nominal case.", "",
    ]  # fmt: skip
    names = ["walls 0.2 mm", "on a table"]
    lines += _head(["indenter", "depth [mm]", "force [N]", *names, "stretch", "stress [MPa]", "cell's shear"])
    for key, rows in effects.items():
        case, variant = key.rsplit(", ", 1)
        if variant != "nominal":
            continue
        for place, row in enumerate(rows):
            if "force_n" not in row:
                lines.append(_line([case, row["depth_mm"], "refused", "", "", "", "", ""]))
                continue
            changes = []
            for name in names:
                other = effects.get(f"{case}, {name}", [])
                force = other[place].get("force_n") if place < len(other) else None
                changes.append("-" if force is None else f"{100 * (force / row['force_n'] - 1):+.0f} %")
            kept = [row[key] for key in ("skin_stretch", "skin_stress_mpa", "cell_shear")]
            lines.append(_line([case, row["depth_mm"], row["force_n"], *changes, *kept]))
    lines += ["", *_flow(effects)]
    return lines


def _flow(effects: dict[str, Rows]) -> list[str]:
    """Where a whole printed cell below the axis has reached a yield strain."""
    lines = [
        "The infill of the uppermost cell flows over the height of the cell where its least shear strain passes the "
        "yield strain, yield stress over modulus, which nobody has published; two that gels have (assumed):", "",
    ]  # fmt: skip
    lines += _head(["indenter", *(f"depth, force at a yield strain of {strain:g}" for strain in YIELD_STRAINS)])
    for key, rows in effects.items():
        case, variant = key.rsplit(", ", 1)
        if variant != "nominal":
            continue
        known = [row for row in rows if "force_n" in row]
        shear, depth, force = (
            np.array([0.0, *(row[name] for row in known)]) for name in ("cell_shear", "depth_mm", "force_n")
        )
        cells = []
        for strain in YIELD_STRAINS:
            if shear.max() < strain:
                cells.append(f"not down to {depth[-1]:g} mm")
                continue
            last = int(np.argmax(shear >= strain))
            at = np.interp(strain, shear[last - 1 : last + 1], depth[last - 1 : last + 1])
            cells.append(f"{at:.2f} mm, {np.interp(at, depth, force):.2f} N")
        lines.append(_line([case, *cells]))
    return lines


def _shear(rows: Rows, how: str) -> list[str]:
    head = ["depth [mm]", "shear [mm]", "along", "Fx", "Fy", "Fz"]
    body = [
        _line([row["depth_mm"], row["shear_mm"], row["axis"], *(_short(row, key) for key in ("fx_n", "fy_n", "fz_n"))])
        for row in rows
    ]
    return ["## Largest forces of a domed cylinder of 6 mm [N]", "", how, "", *_head(head), *body]


def _by_depth(rows: Rows) -> tuple[dict[Any, dict[str, Any]], list[Any], list[float]]:
    found = {(row["diameter_mm"], row["skin_mm"], row["depth_mm"]): row for row in rows}
    return found, list(dict.fromkeys(key[:2] for key in found)), list(dict.fromkeys(key[2] for key in found))


def _short(row: dict[str, Any], key: str) -> str:
    """Value and uncertainty, or that it was refused."""
    if row["value"] is None:
        return "refused"
    return (
        f"{row['value'][key]:.3g} ± {row['uncertainty'][key]:.2g}"
        if row.get("uncertainty")
        else f"{row['value'][key]:.3g}"
    )


def _head(names: list[str]) -> list[str]:
    return [_line(names), "|---" * len(names) + "|"]


def _line(cells: Iterable[Any]) -> str:
    written = [f"{cell:.3g}" if isinstance(cell, float) else "" if cell is None else str(cell) for cell in cells]
    return "| " + " | ".join(written) + " |"
