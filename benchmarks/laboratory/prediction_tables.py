"""The predictions as CSV files, one a table, written from `docs/predictions.json`."""

import csv
from pathlib import Path
from typing import Any

import numpy as np
from relaxation_curve import READING_S, SPEEDS_MM_S, ramp_ratio

Row = dict[str, Any]
TOGETHER_MM = (0.2, 1.0, 2.0, 3.0, 4.0)
"""Depths at which all uncertainties stand together [mm]."""
STIFFER_TO_NONE = 4.0
"""A change of -100 % of the infill's modulus in units of one of +25 %."""
SKIN = ("skin_stretch", "skin_von_mises_mpa", "fz_n")


def write_tables(results: dict[str, Any], folder: Path) -> None:
    """Write every table that was computed into `folder`, numbers with three digits or two of an uncertainty."""
    presses, variants = results.get("press", {}).get("rows", []), results.get("limits", {})
    tables = {
        "press": _presses(presses), "shear": _largest(results.get("shear", {}).get("rows", [])),
        "skin": _skin(variants), "flow": _flow(variants, presses), "beside": _tables(variants, "beside"),
        "sheared": _tables(variants, "sheared"),
        "together": _together(presses, variants) if presses and variants else [],
    }  # fmt: skip
    folder.mkdir(exist_ok=True)
    for name, rows in tables.items():
        if rows:
            with (folder / f"{name}.csv").open("w", newline="", encoding="utf-8") as file:
                writer = csv.DictWriter(file, list(dict.fromkeys(key for row in rows for key in row)))
                writer.writeheader()
                writer.writerows({key: _short(value) for key, value in row.items()} for row in rows)


def _presses(presses: list[Row]) -> list[Row]:
    """Force of a domed cylinder with its uncertainty, and at each speed for the earliest and latest reading."""
    found = []
    for case, path in _paths(presses).items():
        ratios = _ratios(path)
        for place, row in enumerate(each for each in presses if _case(each) == case and each["value"]):
            force = row["value"]["force_n"]
            told = {
                "diameter_mm": case[0], "skin_mm": case[1], "depth_mm": row["depth_mm"], "force_n": force,
                "uncertainty_n": f"{row['uncertainty']['force_n']:.2g}" if row.get("uncertainty") else "",
            }  # fmt: skip
            found.append(told | {name: force * ratio[place] for name, ratio in ratios.items()})
    return found


def _largest(rows: list[Row]) -> list[Row]:
    """Largest forces of a sheared dome of 6 mm, each with its uncertainty."""
    found = []
    for row in rows:
        told = {"depth_mm": row["depth_mm"], "shear_mm": row["shear_mm"], "along": row["axis"]}
        for key in ("fx_n", "fy_n", "fz_n"):
            told |= {key: row["value"][key], f"{key}_uncertainty": f"{row['uncertainty'][key]:.2g}"}
        found.append(told)
    return found


def _skin(variants: dict[str, Any]) -> list[Row]:
    """Largest stretch and stress of the skin and force of the effective core, by variant."""
    return [
        {"variant": variant, "diameter_mm": row["diameter_mm"], "skin_mm": row["skin_mm"]}
        | {"depth_mm": row["depth_mm"], **{key: row[key] for key in SKIN}}
        for variant, tables in variants.items()
        for row in tables.get("presses", [])
        if row.get("fz_n") is not None
    ]


def _flow(variants: dict[str, Any], presses: list[Row]) -> list[Row]:
    """Where the infill begins to flow; without a depth where it does not down to `deepest_mm`."""
    paths, found = _paths(presses), []
    for variant, tables in variants.items():
        for row in tables.get("flow", []):
            told = {
                "variant": variant, "diameter_mm": row["diameter_mm"], "skin_mm": row["skin_mm"],
                "yield_kpa": 1000 * row["yield_mpa"], "deepest_mm": row["deepest_mm"], "depth_mm": row["depth_mm"],
                **{key: row[key] for key in SKIN},
            }  # fmt: skip
            if row["depth_mm"] is not None and _case(row) in paths:
                path = paths[_case(row)]
                told |= {
                    name: row["fz_n"] * float(np.interp(row["depth_mm"], path[:, 0], ratio))
                    for name, ratio in _ratios(path).items()
                }
            found.append(told)
    return found


def _tables(variants: dict[str, Any], name: str) -> list[Row]:
    """Rows of one table of the study `limits`, as they are, by variant."""
    return [{"variant": variant, **row} for variant, tables in variants.items() for row in tables.get(name, [])]


def _together(presses: list[Row], variants: dict[str, Any]) -> list[Row]:
    """What each assumption does to the force of a press, and all of them at two speeds."""
    walls, plain = (
        {_place(row): row["fz_n"] for row in variants[name]["presses"]} for name in ("walls 0.2 mm", "nominal")
    )
    differences = {_place(row): row["differences"] for row in presses}
    found = []
    for case, path in _paths(presses).items():
        ratios = _ratios(path)
        for place, (depth, force) in enumerate(path):
            if (*case, depth) not in walls or depth not in TOGETHER_MM:
                continue
            changes = {name: each["force_n"] / force for name, each in differences[*case, depth].items()}
            parts = {
                "lattice": changes["finer lattice"], "friction": changes["friction 0.5"],
                "walls": walls[*case, depth] / plain[*case, depth] - 1,
                "infill": -STIFFER_TO_NONE * changes["infill +25 %"],
            }  # fmt: skip
            lattice, *others = parts.values()
            down, up = (
                float(np.hypot.reduce([abs(lattice), *(each for each in others if sign * each > 0)]))
                for sign in (-1, 1)
            )
            told: Row = {"diameter [mm]": case[0], "depth [mm]": depth, "force [N]": force}
            told |= {name: f"{100 * each:+.0f} %" for name, each in parts.items()}
            told["together"] = f"-{100 * down:.0f}, +{100 * up:.0f} %"
            for speed in SPEEDS_MM_S:
                least, most = (
                    force * ratios[_timed(speed, reading)][place] * (1 + change)
                    for reading, change in ((READING_S[0], -down), (READING_S[-1], up))
                )
                told[f"at {speed:g} mm/s [N]"] = f"{least:.2g} to {most:.2g}"
            found.append(told)
    return found


def _paths(presses: list[Row]) -> dict[tuple[float, float], np.ndarray]:
    """Depth and force of each indenter and skin, shape [count, 2]."""
    cases = dict.fromkeys(_case(row) for row in presses)
    rows = [(_case(row), (row["depth_mm"], row["value"]["force_n"])) for row in presses if row["value"]]
    return {case: np.array([point for each, point in rows if each == case]) for case in cases}


def _ratios(path: np.ndarray) -> dict[str, np.ndarray]:
    return {
        _timed(speed, reading): ramp_ratio(path, speed_mm_s=speed, reading_s=reading)
        for speed in SPEEDS_MM_S
        for reading in READING_S
    }


def _timed(speed: float, reading: float) -> str:
    return f"force_n_at_{speed:g}_mm_s_read_at_{reading:g}_s"


def _case(row: Row) -> tuple[float, float]:
    return row["diameter_mm"], row["skin_mm"]


def _place(row: Row) -> tuple[float, float, float]:
    return (*_case(row), row["depth_mm"])


def _short(value: Any) -> Any:  # noqa: ANN401
    return f"{value:.3g}" if isinstance(value, float) else "" if value is None else value
