"""Predictions made before anyone compared them: force against depth and speed, largest forces under shear.

    python benchmarks/predictions.py                 # computes docs/predictions.json and its tables; an hour
    python benchmarks/predictions.py --only shear    # one part; the others are kept
    python benchmarks/predictions.py --cases DIR     # keeps every case there, and goes on from what a killed run left
    python benchmarks/predictions.py --rescale       # carries what is there over to the present moduli
    python benchmarks/predictions.py --table         # writes docs/predictions/*.csv from the JSON, without computing

The moduli are fitted to two hardness readings by `calibrate_moduli.py` and to nothing else; what they say of the seven
other readings is in `docs/validation.md`. Every case is computed with a nominal setting and with variants that change
one thing at a time; the uncertainty is the root of the sum of their squared differences, along a press the largest
within 0.4 mm of depth. `prediction_limits.py` adds what decides damage, with walls of 0.2 mm.

Forces scale with the moduli where all of them are scaled (the infill's bulk modulus is beyond feeling), so a result
at one body's stiffness is one at another's with another infill's, and the variant with a stiffer infill says how much
that matters: `--rescale`. For a press the same was computed with 1.523 MPa; to 1.557 that is 2.2 % of scaling and 2.2 %
of the infill's modulus.
"""

import argparse
import hashlib
import json
import sys
import time
from collections.abc import Callable, Iterable
from concurrent.futures import ProcessPoolExecutor
from dataclasses import asdict, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from laboratory.hardness import Setting, sample, workers
from laboratory.prediction_tables import write_tables

from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.lattice.spot import resolved_lattice
from magicsim.deform.lattice.structure import Lattice, build_lattice
from magicsim.deform.lattice.zone import Zone, contact_zone
from magicsim.deform.solve.path import ContactSolver
from magicsim.errors import MagicsimError
from magicsim.folder import result_file
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.grid import symmetric_place
from magicsim.geometry.indenter import Indenter, place_object
from magicsim.geometry.objects.kinds import parse_object
from magicsim.geometry.objects.rigid_object import ObjectBase

HERE = Path(__file__).resolve().parent
DOCS = HERE.parent / "docs"
RESULT, TABLES = DOCS / "predictions.json", DOCS / "predictions"
DEPTHS_MM = (*np.round(np.arange(0.2, 4.5, 0.2), 1).tolist(), 4.5)
DOMES_MM, SKINS_MM, CORE_MM = (2.0, 4.0), (0.3, 0.6, 0.8), 5.0
"""Diameters of the domed cylinders, skins, core."""
SHEARS = ((1.2, 1.0), (1.6, 1.5))
"""(Depth, shear) of the domed cylinder of 6 mm on a skin of 0.3 mm [mm]."""
SHEAR_STEPS = 5
RESOLVED_MARGIN_MM, RESOLVED_GROWTH = 0.85, 2.2
NOMINAL = Setting(body_mpa=1.557, infill_mpa=0.0157, wall_mm=0.1, base="bonded")
"""Of the default design, from `calibrate_moduli.py`; the sensor is bonded."""
SPACINGS_MM = {"press": 0.4, "shear": 0.5}
VARIANTS: dict[str, dict[str, dict[str, Any]]] = {
    "press": {
        "finer lattice": {"spacing_mm": 0.3},
        "friction 0.5": {"friction": 0.5},
        "infill +25 %": {"infill_mpa": 1.25 * NOMINAL.infill_mpa},
    },
    "shear": {
        "coarser lattice": {"spacing_mm": 1.0},
        "infill +25 %": {"infill_mpa": 1.25 * NOMINAL.infill_mpa},
    },
}
"""What each variant changes."""
NEAR_MM = 0.41
"""Depths of a path up to here apart share the largest of their uncertainties."""
Rows = list[dict[str, Any]]


def press(case: tuple[float, float], setting: Setting) -> Rows:
    """Force of a domed cylinder at every depth above a cell's centre; a depth that is refused keeps its message."""
    diameter, skin = case
    dome = parse_object(f"domed_cylinder:radius_mm={diameter / 2}")
    block = sample(CORE_MM + 2 * skin, skin, setting).mounted(setting.mounting)
    x, y = symmetric_place(block, "cell")
    spot = Zone(low_mm=(x, y), high_mm=(x, y)).grown(diameter / 2)
    lattice = resolved_lattice(
        block, spot, margin_mm=RESOLVED_MARGIN_MM, spacing_mm=setting.spacing_mm, growth=RESOLVED_GROWTH, mirrored=True
    )
    solver, state, rows = _solver(lattice, dome, setting), None, []
    for depth in DEPTHS_MM:
        row: dict[str, Any] = {"diameter_mm": diameter, "skin_mm": skin, "depth_mm": depth}
        if rows and rows[-1]["value"] is None:
            rows.append(row | {"value": None, "refused": "deeper than a depth that was refused"})
            continue
        try:
            state = solver.solve(place_object(dome, gap_mm=-depth, x_mm=x, y_mm=y), state)
            row |= {"value": {"force_n": 4 * float(state.force_n[2])}, "min_jacobian": state.min_jacobian}
        except MagicsimError as error:
            row |= {"value": None, "refused": str(error)}
        rows.append(row)
    return rows


def shear(case: tuple[float, float, str], setting: Setting) -> Rows:
    """Largest forces of a domed cylinder of 6 mm that is pressed and then sheared along one axis."""
    depth, motion, axis = case
    dome = parse_object("domed_cylinder:radius_mm=3")
    ways = [motion * step / SHEAR_STEPS for step in range(SHEAR_STEPS + 1)]
    poses = [
        place_object(dome, gap_mm=-depth, x_mm=way if axis == "x" else 0.0, y_mm=way if axis == "y" else 0.0)
        for way in ways
    ]
    solver, state, forces = (
        _solver(_graded(sample(CORE_MM + 0.6, 0.3, setting).mounted(setting.mounting), poses, setting), dome, setting),
        None,
        [],
    )
    for pose in poses:
        state = solver.solve(pose, state)
        forces.append(np.abs(state.force_n))
    largest = np.max(forces, axis=0).tolist()
    value = dict(zip(("fx_n", "fy_n", "fz_n"), largest, strict=True))
    return [{"depth_mm": depth, "shear_mm": motion, "axis": axis, "value": value}]


def _graded(block: ElastomerDesign, poses: Iterable[Indenter], setting: Setting) -> Lattice:
    options = block.lattice.model_copy(update={"spacing_mm": setting.spacing_mm})
    block = block.model_copy(update={"lattice": options})
    return build_lattice(block, zone=contact_zone(poses, block))


def _solver(lattice: Lattice, thing: ObjectBase, setting: Setting) -> ContactSolver:
    return ContactSolver(lattice, friction=setting.friction, point_spacing_mm=point_spacing_mm(thing.shape()))


CASES: dict[str, tuple[Callable[..., Rows], list[Any]]] = {
    "press": (press, [(diameter, skin) for diameter in DOMES_MM for skin in SKINS_MM]),
    "shear": (shear, [(*each, axis) for each in SHEARS for axis in "xy"]),
}


def run(part: str, case: Any, setting: Setting) -> Rows:  # noqa: ANN401
    """One case with one setting; a refusal of the whole case is a row of its own."""
    try:
        return CASES[part][0](case, setting)
    except MagicsimError as error:
        return [{"case": list(case), "value": None, "refused": str(error)}]


def kept(folder: Path, part: str, case: Any, setting: Setting) -> Rows:  # noqa: ANN401
    """The same, read from the folder if it was computed before."""
    key = [part, list(case), asdict(setting)]
    path = folder / f"{hashlib.sha256(json.dumps(key).encode()).hexdigest()[:16]}.json"
    if path.is_file():
        return json.loads(path.read_text())["rows"]  # type: ignore[no-any-return]
    start = time.perf_counter()
    rows = run(part, case, setting)
    seconds = time.perf_counter() - start
    with result_file(path) as partial:
        partial.write_text(json.dumps({"key": key, "seconds": seconds, "rows": rows}))
    sys.stderr.write(f"{part} {case}, nodes {setting.spacing_mm:g} mm apart: {seconds:.0f} s\n")
    return rows


def predict(part: str, pool: ProcessPoolExecutor, folder: Path) -> dict[str, Any]:
    """All cases of a part: nominal values, the difference that each variant makes, and the uncertainty."""
    nominal = replace(NOMINAL, spacing_mm=SPACINGS_MM[part])
    settings = {"nominal": nominal, **{name: replace(nominal, **change) for name, change in VARIANTS[part].items()}}
    jobs = {
        name: [pool.submit(kept, folder, part, case, setting) for case in CASES[part][1]]
        for name, setting in settings.items()
    }
    found = {name: [row for job in own for row in job.result()] for name, own in jobs.items()}
    variants = [name for name in settings if name != "nominal"]
    rows = [
        _combined(row, {name: found[name][place] for name in variants}) for place, row in enumerate(found["nominal"])
    ]
    if part == "press":
        rows = _widened(rows)
    return {"setting": asdict(nominal), "variants": VARIANTS[part], "rows": rows}


def _widened(rows: Rows) -> Rows:
    """Paths whose uncertainty is the largest nearby: where a difference changes its sign it says nothing."""

    def beside(row: dict[str, Any]) -> list[float]:
        return [
            other["uncertainty"]["force_n"] for other in rows
            if all(other[key] == row[key] for key in ("diameter_mm", "skin_mm"))
            and other.get("uncertainty") and abs(other["depth_mm"] - row["depth_mm"]) < NEAR_MM
        ]  # fmt: skip

    return [
        row | {"uncertainty": {"force_n": max(near)}} if row["value"] is not None and (near := beside(row)) else row
        for row in rows
    ]


def _combined(row: dict[str, Any], variants: dict[str, dict[str, Any]]) -> dict[str, Any]:
    if row["value"] is None:
        return row
    usable = {name: other["value"] for name, other in variants.items() if other.get("value") is not None}
    differences = {
        name: {key: value[key] - row["value"][key] for key in row["value"]} for name, value in usable.items()
    }
    if not differences:
        return row
    spread = {key: float(np.sqrt(sum(each[key] ** 2 for each in differences.values()))) for key in row["value"]}
    return row | {"differences": differences, "uncertainty": spread}


def rescaled(part: dict[str, Any]) -> dict[str, Any]:
    """A part at the present moduli from one at others, see above."""
    before, ratio = part["setting"], NOMINAL.body_mpa / part["setting"]["body_mpa"]
    softer = np.log(NOMINAL.infill_mpa / before["infill_mpa"] / ratio) / np.log(1.25)

    def value(row: dict[str, Any]) -> dict[str, float]:
        change = row["differences"]["infill +25 %"]
        return {key: float(ratio * (force + softer * change[key])) for key, force in row["value"].items()}

    def scaled(values: dict[str, float]) -> dict[str, float]:
        return {key: ratio * each for key, each in values.items()}

    rows = [
        row
        | {
            "value": value(row),
            "differences": {name: scaled(each) for name, each in row["differences"].items()},
            "uncertainty": scaled(row["uncertainty"]),
        }
        for row in part["rows"]
    ]
    setting = before | {"body_mpa": NOMINAL.body_mpa, "infill_mpa": NOMINAL.infill_mpa}
    return part | {"setting": setting | {"rescaled_from_mpa": before["body_mpa"]}, "rows": rows}


def main() -> None:
    """Computes what was asked for and writes JSON and tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=tuple(CASES), help="one part")
    parser.add_argument("--table", action="store_true", help="only write the tables again")
    parser.add_argument("--rescale", action="store_true", help="carry the results over to the present moduli")
    parser.add_argument("--cases", type=Path, help="folder that keeps every case, for a run that goes on")
    options = parser.parse_args()
    results = json.loads(RESULT.read_text()) if RESULT.is_file() else {}
    if options.rescale:
        results |= {part: rescaled(results[part]) for part in CASES if part in results}
        RESULT.write_text(json.dumps(results, indent=1) + "\n")
    elif not options.table:
        with workers() as pool, TemporaryDirectory() as temporary:
            for part in [options.only] if options.only else list(CASES):
                results[part] = predict(part, pool, options.cases or Path(temporary))
                RESULT.write_text(json.dumps(results, indent=1) + "\n")
    write_tables(results, TABLES)


if __name__ == "__main__":
    main()
