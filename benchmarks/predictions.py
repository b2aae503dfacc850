"""Predictions made before anyone compared them: Shore A hardness, force against depth, largest forces under shear.

    python benchmarks/predictions.py                 # computes benchmarks/predictions.json; an hour on two cores
    python benchmarks/predictions.py --only shear    # one part; the others are kept
    python benchmarks/predictions.py --table         # writes docs/predictions.md from the JSON, without computing

The moduli are those of `geometry/mini-magictac.toml`, fitted to two hardness readings by `geometry/calibrate_moduli.py`
and to nothing else. Every case is computed with a nominal setting and with variants that change one thing at a time;
the uncertainty is the root of the sum of their squared differences. What the variants do not contain (the law of the
materials, the printed geometry, the rate of the test) is not in it.
"""

import argparse
import json
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.config import load_preset
from magicsim.deform.durometer import durometer
from magicsim.deform.face import point_spacing_mm
from magicsim.deform.lattice import build_lattice
from magicsim.deform.path import ContactSolver
from magicsim.deform.zone import contact_zone
from magicsim.errors import MagicsimError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.indenter import place_object
from magicsim.geometry.objects import ObjectBase, parse_object

HERE = Path(__file__).resolve().parent
RESULT, TABLE = HERE / "predictions.json", HERE.parent / "docs" / "predictions.md"
HARDNESS = ((10.0, 2.0), (10.0, 1.5), (10.0, 1.0), (2.0, 0.5), (5.0, 0.5), (15.0, 0.5), (20.0, 0.5))
"""(Total height, skin) [mm]."""
DEPTHS_MM = (*np.round(np.arange(0.2, 4.5, 0.2), 1).tolist(), 4.5)
DOMES_MM, SKINS_MM = (2.0, 4.0), (0.3, 0.6, 0.8)
"""Diameters of the domed cylinders, and skins on a core of 5 mm."""
SHEARS = ((1.2, 1.0), (1.6, 1.5))
"""(Depth, shear) of the domed cylinder of 6 mm on a skin of 0.3 mm [mm]."""
SHEAR_STEPS = 4
NOMINAL: dict[str, dict[str, Any]] = {
    "hardness": {"spacing_mm": 0.3, "friction": 0.0, "moduli": 1.0},
    "press": {"spacing_mm": 0.4, "friction": 0.0, "moduli": 1.0},
    "shear": {"spacing_mm": 0.5, "friction": 1.0, "moduli": 1.0},
}
VARIANTS: dict[str, dict[str, dict[str, Any]]] = {
    "hardness": {"spacing": {"spacing_mm": 0.24}, "friction": {"friction": 0.5}, "infill": {"moduli": 1.2}},
    "press": {"spacing": {"spacing_mm": 0.6}, "friction": {"friction": 0.5, "spacing_mm": 0.6}},
    "shear": {"spacing": {"spacing_mm": 0.7}, "friction": {"friction": 0.5}},
}
"""What each variant changes; `moduli` is a factor on the shear modulus of the infill."""


def design(core_mm: float, skin_mm: float, setting: dict[str, Any]) -> ElastomerDesign:
    """The default design with another core and skin."""
    block = load_preset(ElastomerDesign, "design", "mini-magictac", [f"skin_mm={skin_mm}", f"core_mm={core_mm}"])
    infill = block.materials.infill
    assert infill is not None
    softer = infill.model_copy(update={"shear_modulus_mpa": infill.shear_modulus_mpa * setting["moduli"]})
    return block.model_copy(update={"materials": block.materials.model_copy(update={"infill": softer})})


def hardness(case: tuple[float, float], setting: dict[str, Any]) -> list[dict[str, Any]]:
    """Shore A of one block."""
    total, skin = case
    block = design(total - 2 * skin, skin, setting)
    found = durometer(block, spacing_mm=setting["spacing_mm"], friction=setting["friction"])
    return [
        {"total_mm": total, "skin_mm": skin, "value": {"shore_a": found.shore_a}, "depth_mm": found.depth_mm,
         "min_jacobian": found.min_jacobian}
    ]  # fmt: skip


def press(case: tuple[float, float], setting: dict[str, Any]) -> list[dict[str, Any]]:
    """Force of a domed cylinder at every depth; a depth that is refused keeps its message."""
    diameter, skin = case
    dome = parse_object(f"domed_cylinder:radius_mm={diameter / 2}")
    solver, rows, state = _solver(design(5.0, skin, setting), dome, [(d, 0, 0) for d in DEPTHS_MM], setting), [], None
    for depth in DEPTHS_MM:
        row: dict[str, Any] = {"diameter_mm": diameter, "skin_mm": skin, "depth_mm": depth}
        try:
            state = solver.solve(place_object(dome, gap_mm=-depth), state)
            row |= {"value": {"force_n": float(state.force_n[2])}, "min_jacobian": state.min_jacobian}
        except MagicsimError as error:
            row |= {"value": None, "refused": str(error)}
        rows.append(row)
    return rows


def shear(case: tuple[float, float, str], setting: dict[str, Any]) -> list[dict[str, Any]]:
    """Largest forces of a domed cylinder of 6 mm that is pressed and then sheared along one axis."""
    depth, motion, axis = case
    dome = parse_object("domed_cylinder:radius_mm=3")
    ways = [motion * step / SHEAR_STEPS for step in range(SHEAR_STEPS + 1)]
    poses = [(depth, way if axis == "x" else 0.0, way if axis == "y" else 0.0) for way in ways]
    solver = _solver(design(5.0, 0.3, setting), dome, poses, setting)
    state, forces = None, []
    for deep, x, y in poses:
        state = solver.solve(place_object(dome, gap_mm=-deep, x_mm=x, y_mm=y), state)
        forces.append(np.abs(state.force_n))
    largest = np.max(forces, axis=0).tolist()
    value = dict(zip(("fx_n", "fy_n", "fz_n"), largest, strict=True))
    return [{"depth_mm": depth, "shear_mm": motion, "axis": axis, "value": value}]


def _solver(
    block: ElastomerDesign, thing: ObjectBase, poses: Iterable[tuple[float, ...]], setting: dict[str, Any]
) -> ContactSolver:
    options = block.lattice.model_copy(update={"spacing_mm": setting["spacing_mm"]})
    block = block.model_copy(update={"lattice": options})
    placed = [place_object(thing, gap_mm=-depth, x_mm=x, y_mm=y) for depth, x, y in poses]
    return ContactSolver(
        build_lattice(block, zone=contact_zone(placed, block)),
        friction=setting["friction"],
        point_spacing_mm=point_spacing_mm(thing.shape()),
    )


CASES: dict[str, tuple[Callable[..., list[dict[str, Any]]], list[Any]]] = {
    "hardness": (hardness, list(HARDNESS)),
    "press": (press, [(diameter, skin) for diameter in DOMES_MM for skin in SKINS_MM]),
    "shear": (shear, [(*each, axis) for each in SHEARS for axis in "xy"]),
}


def run(task: tuple[str, Any, dict[str, Any]]) -> list[dict[str, Any]]:
    """One case with one setting; a refusal of the whole case is a row of its own."""
    part, case, setting = task
    try:
        return CASES[part][0](case, setting)
    except MagicsimError as error:
        return [{"case": list(case), "value": None, "refused": str(error)}]


def predict(part: str, pool: ProcessPoolExecutor) -> list[dict[str, Any]]:
    """All cases of a part: nominal values, the difference that each variant makes, and the uncertainty."""
    settings = {"nominal": NOMINAL[part], **{name: NOMINAL[part] | change for name, change in VARIANTS[part].items()}}
    tasks = [(part, case, setting) for setting in settings.values() for case in CASES[part][1]]
    found = list(pool.map(run, tasks))
    count = len(CASES[part][1])
    by_setting = {
        name: [row for rows in found[number * count : (number + 1) * count] for row in rows]
        for number, name in enumerate(settings)
    }
    return [
        _combined(row, {name: by_setting[name][place] for name in VARIANTS[part]})
        for place, row in enumerate(by_setting["nominal"])
    ]


def _combined(row: dict[str, Any], variants: dict[str, dict[str, Any]]) -> dict[str, Any]:
    if row["value"] is None:
        return row
    usable = {name: other["value"] for name, other in variants.items() if other["value"] is not None}
    differences = {
        name: {key: value[key] - row["value"][key] for key in row["value"]} for name, value in usable.items()
    }
    spread = {key: float(np.sqrt(sum(each[key] ** 2 for each in differences.values()))) for key in row["value"]}
    return row | {"differences": differences, "uncertainty": spread}


def table(results: dict[str, Any]) -> str:
    """The predictions as Markdown."""
    lines = [
        "# Predictions", "",
        "Written by `python benchmarks/predictions.py` before any comparison; its docstring says what the uncertainty",
        "contains. Nominal settings: " + "; ".join(f"{part}: {setting}" for part, setting in NOMINAL.items()) + ".", "",
        "## Shore A (long-term moduli, virtual durometer)", "",
        "| total height [mm] | skin [mm] | Shore A | uncertainty | finer lattice | friction 0.5 | infill +20 % |",
        "|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    lines += [
        _line([row["total_mm"], row["skin_mm"], *_value(row, "shore_a", ("spacing", "friction", "infill"))])
        for row in results.get("hardness", [])
    ]
    lines += ["", "## Force of a domed cylinder [N], frictionless", ""]
    presses = results.get("press", [])
    heads = [(diameter, skin) for diameter in DOMES_MM for skin in SKINS_MM]
    lines.append("| depth [mm] | " + " | ".join(f"{d:g} mm, skin {s:g}" for d, s in heads) + " |")
    lines.append("|---" * (len(heads) + 1) + "|")
    for depth in DEPTHS_MM:
        cells = []
        for diameter, skin in heads:
            found = [r for r in presses if (r["diameter_mm"], r["skin_mm"], r["depth_mm"]) == (diameter, skin, depth)]
            cells.append(_short(found[0], "force_n") if found else "")
        lines.append(_line([depth, *cells]))
    lines += [
        "", "## Largest forces of a domed cylinder of 6 mm on a skin of 0.3 mm [N], friction 1", "",
        "| depth [mm] | shear [mm] | along | Fx | Fy | Fz |", "|---|---|---|---|---|---|",
    ]  # fmt: skip
    lines += [
        _line([row["depth_mm"], row["shear_mm"], row["axis"], *(_short(row, key) for key in ("fx_n", "fy_n", "fz_n"))])
        for row in results.get("shear", [])
    ]
    return "\n".join(lines) + "\n"


def _value(row: dict[str, Any], key: str, variants: tuple[str, ...]) -> list[str]:
    if row["value"] is None:
        return ["refused", "", *("" for _ in variants)]
    changes = [row["differences"].get(name) for name in variants]
    return [
        f"{row['value'][key]:.1f}", f"{row['uncertainty'][key]:.1f}",
        *(f"{change[key]:+.1f}" if change else "refused" for change in changes),
    ]  # fmt: skip


def _short(row: dict[str, Any], key: str) -> str:
    return "refused" if row["value"] is None else f"{row['value'][key]:.2f} ± {row['uncertainty'][key]:.2f}"


def _line(cells: list[Any]) -> str:
    return "| " + " | ".join(str(cell) for cell in cells) + " |"


def main() -> None:
    """Computes the parts that are asked for and writes JSON and table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=list(CASES), nargs="+", default=list(CASES))
    parser.add_argument("--table", action="store_true", help="only write the table again")
    options = parser.parse_args()
    results = json.loads(RESULT.read_text()) if RESULT.exists() else {}
    if not options.table:
        with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
            for part in options.only:
                results[part] = predict(part, pool)
                RESULT.write_text(json.dumps(results, indent=1) + "\n")
    TABLE.write_text(table(results))


if __name__ == "__main__":
    main()
