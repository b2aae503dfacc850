"""The predictions as Markdown."""

from collections.abc import Iterable
from typing import Any

import numpy as np
from prediction_limit_tables import limit_tables
from relaxation_curve import READING_S, SPEEDS_MM_S, ramp_ratio

Rows = list[dict[str, Any]]
TOGETHER_MM = (0.2, 1.0, 2.0, 3.0, 4.0)
"""Depths at which all uncertainties stand together [mm]."""
TOGETHER = (
    "What one assumption at a time changes in the force of a press, where all of them were computed (skin of 0.6 mm): "
    "the lattice, friction of 0.5 instead of 1, walls of 0.2 mm with the moduli that go with them (by the effective "
    "core), and an infill that carries no shear at all, the most that one can that yields: minus four times what 25 % "
    "more of its modulus add. Together is the root of the sum of squares of what lowers and of what raises, the "
    "lattice's on both sides. Forces at a speed run from those of a reading after {:g} s, lowered, to those of one "
    "after {:g} s, raised."
)
STIFFER_TO_NONE = 4.0
"""A change of -100 % of the infill's modulus in units of one of +25 %."""
HEAD = """# Predictions

Written before any comparison by `python benchmarks/predictions.py` (forces of presses and of sheared presses) and
`python benchmarks/prediction_limits.py` (skin, infill, lateral forces: variants of `magicsim study limits`); their
docstrings say what is computed. The moduli meet two hardness readings and nothing else ([Validation](validation.md));
they are the stiffness some seconds after contact, and the tables by speed say what time does to them. Nothing was
fitted to results.

What is here: force of domed cylinders of 2 and 4 mm on skins of 0.3, 0.6 and 0.8 mm from 0.2 to 4.5 mm deep, at the
stiffness of the readings and at 1 and 0.1 mm/s; largest forces of a dome of 6 mm under shear; largest stretch and
stress of the skin at each half millimetre; where the infill below the indenter begins to flow over the height of a
cell; lateral forces of an indenter that is not above the middle of a cell. Variants change one thing: reading time
and speed, walls of 0.2 mm, friction, infill, the yield stress of the infill, the lattice. There is no column for
measurements yet.
"""


def markdown(results: dict[str, Any]) -> str:
    """All parts that were computed, each with its setting."""
    lines = [HEAD]
    if "press" in results:
        setting, variants = results["press"]["setting"], list(results["press"]["variants"])
        lines += _press(results["press"]["rows"], _how(setting, variants))
        lines += ["", *_timed(results["press"]["rows"])]
    if "shear" in results:
        setting, variants = results["shear"]["setting"], list(results["shear"]["variants"])
        lines += ["", *_shear(results["shear"]["rows"], _how(setting, variants))]
    if "limits" in results:
        lines += ["", *limit_tables(results["limits"], results.get("press", {}).get("rows", []))]
    if {"press", "limits"} <= results.keys():
        lines += ["", *_together(results["press"]["rows"], results["limits"])]
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


def _together(rows: Rows, variants: dict[str, dict[str, Rows]]) -> list[str]:
    """What each assumption does to the force of a press, and all of them at two speeds."""
    found, heads, depths = _by_depth(rows)
    walls = {
        (row["diameter_mm"], row["skin_mm"], row["depth_mm"]): row["fz_n"]
        for row in variants["walls 0.2 mm"]["presses"]
    }
    plain = {
        (row["diameter_mm"], row["skin_mm"], row["depth_mm"]): row["fz_n"] for row in variants["nominal"]["presses"]
    }
    speeds = [f"at {speed:g} mm/s [N]" for speed in SPEEDS_MM_S]
    lines = [
        "## All uncertainties together", "",
        TOGETHER.format(*READING_S),
        "",
        *_head(
            ["indenter, depth [mm]", "force [N]", "lattice", "friction", "walls", "infill", "together", *speeds]
        ),
    ]  # fmt: skip
    for pair in heads:
        path = np.array([(each, found[*pair, each]["value"]["force_n"]) for each in depths])
        ratios = {
            (speed, reading): ramp_ratio(path, speed_mm_s=speed, reading_s=reading)
            for speed in SPEEDS_MM_S for reading in READING_S
        }  # fmt: skip
        for place, (depth, force) in enumerate(path):
            case = (*pair, float(depth))
            if case not in walls or float(depth) not in TOGETHER_MM:
                continue
            changes = {name: each["force_n"] / force for name, each in found[case]["differences"].items()}
            parts = [
                changes["finer lattice"], changes["friction 0.5"], walls[case] / plain[case] - 1,
                -STIFFER_TO_NONE * changes["infill +25 %"],
            ]  # fmt: skip
            down, up = (
                float(np.hypot.reduce([abs(parts[0]), *(each for each in parts[1:] if sign * each > 0)]))
                for sign in (-1, 1)
            )
            ends = [
                f"{force * ratios[speed, READING_S[0]][place] * (1 - down):.2g} to "
                f"{force * ratios[speed, READING_S[-1]][place] * (1 + up):.2g}"
                for speed in SPEEDS_MM_S
            ]
            told = [f"{100 * each:+.0f} %" for each in parts]
            lines.append(
                _line(
                    [f"{pair[0]:g} mm, {depth:g}", float(force), *told, f"-{100 * down:.0f}, +{100 * up:.0f} %", *ends]
                )
            )
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
