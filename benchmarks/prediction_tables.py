"""The predictions as Markdown."""

from collections.abc import Iterable
from typing import Any

Rows = list[dict[str, Any]]


def markdown(results: dict[str, Any]) -> str:
    """All parts that were computed, each with its setting."""
    lines = [
        "# Predictions",
        "",
        "Written by `python benchmarks/predictions.py` before any comparison; its docstring says what the uncertainty",
        "(after each value) contains. Where none stands the variants of that case have not been computed.",
    ]
    for part, write in (("hardness", _hardness), ("press", _press), ("shear", _shear)):
        if part in results:
            setting, variants = results[part]["setting"], list(results[part]["variants"])
            lines += ["", *write(results[part]["rows"], variants, _how(setting, variants))]
    return "\n".join(lines) + "\n"


def _how(setting: dict[str, Any], variants: list[str]) -> str:
    return (
        f"Body {setting['body_mpa']:g} MPa (Young, long term), infill {setting['infill_mpa']:g} MPa (shear), walls of "
        f"{setting['wall_mm']:g} mm, nodes {setting['spacing_mm']:g} mm apart below the object, friction "
        f"{setting['friction']:g}. Variants: {', '.join(variants) or 'none yet, so no uncertainty'}."
    )


def _hardness(rows: Rows, variants: list[str], how: str) -> list[str]:
    head = ["total height [mm]", "skin [mm]", "Shore A", "on a cell", "on a crossing", *variants, "min J", "walls"]
    lines = ["## Shore A", "", how, "", *_head(head)]
    for row in rows:
        differences = [row.get("differences", {}).get(name, {}).get("shore_a") for name in variants]
        places = [row["places"]["cell"], row["places"]["wall"]]
        quality = [row.get("min_jacobian"), row.get("walls")]
        lines.append(_line([row["total_mm"], row["skin_mm"], _short(row, "shore_a"), *places, *differences, *quality]))
    return lines


def _press(rows: Rows, _: list[str], how: str) -> list[str]:
    found = {(row["diameter_mm"], row["skin_mm"], row["depth_mm"]): row for row in rows}
    heads = list(dict.fromkeys(key[:2] for key in found))
    depths = list(dict.fromkeys(key[2] for key in found))
    head = ["depth [mm]", *(f"{diameter:g} mm, skin {skin:g}" for diameter, skin in heads)]
    body = [_line([depth, *(_short(found[*pair, depth], "force_n") for pair in heads)]) for depth in depths]
    return ["## Force of a domed cylinder [N]", "", how, "", *_head(head), *body]


def _shear(rows: Rows, _: list[str], how: str) -> list[str]:
    head = ["depth [mm]", "shear [mm]", "along", "Fx", "Fy", "Fz"]
    body = [
        _line([row["depth_mm"], row["shear_mm"], row["axis"], *(_short(row, key) for key in ("fx_n", "fy_n", "fz_n"))])
        for row in rows
    ]
    return ["## Largest forces of a domed cylinder of 6 mm [N]", "", how, "", *_head(head), *body]


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
