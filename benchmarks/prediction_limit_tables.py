"""The predictions of skin, infill and lateral forces as Markdown."""

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np
from relaxation_curve import READING_S, SPEEDS_MM_S, ramp_ratio

Rows = list[dict[str, Any]]
Variants = Mapping[str, Mapping[str, Rows]]
SKIN = {"skin_stretch": "largest stretch", "skin_von_mises_mpa": "largest von Mises stress [MPa]"}


def limit_tables(variants: Variants, presses: Rows) -> list[str]:
    """All tables, as far as they were computed.

    Args:
        variants: Tables of `magicsim study limits` by variant, `nominal` among them.
        presses: Rows of `predictions.json` with the force at each depth, for its ratio at a speed.
    """
    nominal = variants["nominal"]
    lines = _skin(variants) if nominal.get("presses") else []
    if nominal.get("flow"):
        lines += ["", *_flow(variants, presses)]
    if nominal.get("beside"):
        lines += ["", *_beside(nominal["beside"])]
    sheared = [(name, rows) for name, found in variants.items() if (rows := found.get("sheared", []))]
    if sheared:
        lines += ["", *_sheared(sheared)]
    return lines


def _skin(variants: Variants) -> list[str]:
    lines = [
        "## Skin", "",
        "Of the skin's cells at their Gauss points, two or more layers, effective core, friction 1. In brackets "
        "the change with walls of 0.2 mm and with friction 0.5, where computed (skin of 0.6 mm).",
    ]  # fmt: skip
    rows = variants["nominal"]["presses"]
    depths = list(dict.fromkeys(row["depth_mm"] for row in rows if row.get("depth_mm") is not None))
    heads = list(dict.fromkeys((row["diameter_mm"], row["skin_mm"]) for row in rows))
    for name, title in {**SKIN, "fz_n": "force, effective core [N]"}.items():
        lines += ["", f"### {title[0].upper()}{title[1:]}", ""]
        lines += _head(["depth [mm]", *(f"{diameter:g} mm, skin {skin:g}" for diameter, skin in heads)])
        for depth in depths:
            lines.append(_line([depth, *(_with_changes(variants, (*case, depth), name) for case in heads)]))
    return lines


def _with_changes(variants: Variants, place: tuple[float, float, float], name: str) -> str:
    found = {variant: _value(tables.get("presses", []), place, name) for variant, tables in variants.items()}
    value = found.pop("nominal")
    if value is None:
        refused = [row for row in variants["nominal"]["presses"] if _case(row) == place[:2] and row["refused"]]
        return "not converged" if refused else "not computed"
    changes = [f"{100 * (other / value - 1):+.0f} %" for other in found.values() if other is not None]
    return f"{value:.3g}" + (f" ({', '.join(changes)})" if changes else "")


def _value(rows: Rows, place: tuple[float, float, float], name: str) -> float | None:
    return next((row.get(name) for row in rows if (*_case(row), row.get("depth_mm")) == place), None)


def _case(row: Mapping[str, Any]) -> tuple[float, float]:
    return row["diameter_mm"], row["skin_mm"]


def _flow(variants: Variants, presses: Rows) -> list[str]:
    speeds = [f"force at {speed:g} mm/s [N]" for speed in SPEEDS_MM_S]
    lines = [
        "## Where the infill begins to flow", "",
        "Depth and normal force at which every layer of the uppermost cube of infill below the indenter has reached "
        "the yield stress, walls resolved, above the middle of a cell. The yield stress is assumed: nobody published "
        f"one. Forces at a speed as above, for a reading after {READING_S[0]:g} s (to {READING_S[1]:g} s). Stretch and "
        "stress are those of the skin at that depth. The infill that goes with walls of 0.2 mm has a modulus of 2 kPa: "
        "its yield strains are 2.3 and more.", "",
    ]  # fmt: skip
    lines += _head(
        ["variant", "indenter", "yield stress [kPa]", "depth [mm]", "force [N]", *speeds, "stretch", "stress [MPa]"]
    )
    for variant, tables in variants.items():
        for row in tables.get("flow", []):
            case = f"{row['diameter_mm']:g} mm, skin {row['skin_mm']:g}"
            told = [variant, case, f"{1000 * row['yield_mpa']:.3g}"]
            if row.get("depth_mm") is None:
                none = f"none down to {row['deepest_mm']:g}" if row["deepest_mm"] else "not computed"
                lines.append(_line([*told, none, "", *("" for _ in speeds), "", ""]))
                continue
            at_speed = [_at_speed(presses, row, speed) for speed in SPEEDS_MM_S]
            values = [f"{row[key]:.3g}" if row.get(key) is not None else "" for key in ("depth_mm", "fz_n")]
            skin = [f"{row[key]:.3g}" if row.get(key) is not None else "" for key in SKIN]
            lines.append(_line([*told, *values, *at_speed, *skin]))
    return lines


def _at_speed(presses: Rows, row: Mapping[str, Any], speed: float) -> str:
    path = np.array(
        [
            (each["depth_mm"], each["value"]["force_n"])
            for each in presses
            if _case(each) == _case(row) and each["value"]
        ]
    )
    if len(path) == 0:
        return ""
    ratios = [
        float(np.interp(row["depth_mm"], path[:, 0], ramp_ratio(path, speed_mm_s=speed, reading_s=reading)))
        for reading in READING_S
    ]
    early, late = (row["fz_n"] * ratio for ratio in ratios)
    return f"{early:.3g} (to {late:.3g})"


def _beside(rows: Rows) -> list[str]:
    lines = [
        "## Lateral forces beside the middle of a cell", "",
        "The axis of the indenter is 0.2 mm from the middle of a cell, 0.173 mm along x and 0.1 mm along y; walls "
        "resolved below it on the whole block, nodes 0.45 mm apart at most, friction 1. Above the middle such forces "
        "vanish by symmetry. Those of 4 mm are of the code of commit 0efec25.", "",
    ]  # fmt: skip
    names = ("fx_n", "fy_n", "fz_n", "least_infill_shear")
    lines += _head(["indenter", "depth [mm]", "Fx [N]", "Fy [N]", "Fz [N]", "least shear of a layer of the infill"])
    for row in rows:
        case = f"{row['diameter_mm']:g} mm, skin {row['skin_mm']:g}"
        if row["refused"]:
            lines.append(_line([case, row.get("depth_mm"), _reason(row), "", "", ""]))
            continue
        values = [f"{row[name]:.3g}" if row.get(name) is not None else "" for name in names]
        lines.append(_line([case, row["depth_mm"], *values]))
    return lines


def _sheared(variants: Iterable[tuple[str, Rows]]) -> list[str]:
    lines = [
        "## Sheared presses of a domed cylinder of 6 mm, step by step", "",
        "Skin of 0.3 mm with one layer of cells, nodes 0.5 mm apart, effective core, sheared along x. One layer tells "
        "less than the stretch and stress at the surface. Those with friction 0.5 are of the code of commit 0efec25.",
        "",
    ]  # fmt: skip
    keys = ("fx_n", "fz_n", "skin_stretch", "skin_von_mises_mpa", "infill_shear")
    lines += _head(
        ["variant", "depth [mm]", "shear [mm]", "Fx [N]", "Fz [N]", "stretch", "stress [MPa]", "shear of the infill"]
    )
    for variant, rows in variants:
        for row in rows:
            if row["refused"]:
                lines.append(_line([variant, row.get("depth_mm"), row.get("shear_mm"), _reason(row), "", "", "", ""]))
                continue
            lines.append(_line([variant, row["depth_mm"], row["shear_mm"], *(f"{row[key]:.3g}" for key in keys)]))
    return lines


def _reason(row: Mapping[str, Any]) -> str:
    return "not computed" if row["refused"] == "no result" else f"not converged: {row['refused']}"


def _head(names: list[str]) -> list[str]:
    return [_line(names), "|---" * len(names) + "|"]


def _line(cells: Iterable[Any]) -> str:
    written = [f"{cell:.3g}" if isinstance(cell, float) else "" if cell is None else str(cell) for cell in cells]
    return "| " + " | ".join(written) + " |"
