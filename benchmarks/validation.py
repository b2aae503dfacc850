"""Predicted against published hardness of nine printed samples, and what each mechanism would change.

    python benchmarks/validation.py                        # everything that docs/validation.json lacks; an hour
    python benchmarks/validation.py --only nominal --sample 2 0.5
    python benchmarks/validation.py --table                # the tables of docs/validation.md, without computing

Two of the samples fit the two moduli (`calibrate_moduli.py`); the other seven are predicted. Mechanisms are looked at
one at a time at the same moduli: the base, friction, another infill, by secant moduli (`secant_laws`) Gent's law
of the body and walls that carry nothing below the cone, and cores that fail, as one effective solid. These run on a
coarser lattice with longer steps, and only their differences to the usual law with the same lattice count.
"""

import argparse
import json
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import secant_laws
from laboratory.hardness import READINGS, Setting, reading, sample

from magicsim.config.models import load_preset
from magicsim.deform.indentation.durometer import EXTENSION_MM, DurometerTest
from magicsim.errors import MagicsimError
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.limits import CoreFailure

FAILED_N = 1e-3
"""Accuracy of the force of cores that fail [N]: 0.01 units of Shore A."""
RESULT = Path(__file__).resolve().parent.parent / "docs" / "validation.json"
MEASURED = {
    **READINGS, (10.0, 2.0): 26.0, (10.0, 1.5): 22.25, (10.0, 1.0): 20.25, (2.0, 0.5): 30.5, (5.0, 0.5): 18.2,
    (15.0, 0.5): 15.17, (20.0, 0.5): 14.2,
}  # fmt: skip
"""Shore A by total height and skin [mm] (Fan, Li, Zhang, arXiv 2505.24382, Table I)."""
NOMINAL = Setting(body_mpa=1.557, infill_mpa=0.0157, wall_mm=0.1)
"""Of the default design; from `calibrate_moduli.py`."""
TRIED = ((2.0, 0.5), (10.0, 0.5), (10.0, 2.0))
"""Samples at which mechanisms are looked at."""
SETTINGS = {
    "nominal": NOMINAL,
    "bonded": replace(NOMINAL, base="bonded"),
    "base friction 0.3": replace(NOMINAL, base_friction=0.3),
    "base friction 0": replace(NOMINAL, base_friction=0.0),
    "both frictions 0.3": replace(NOMINAL, base_friction=0.3, friction=0.3),
    "infill / 8": replace(NOMINAL, infill_mpa=NOMINAL.infill_mpa / 8),
    "infill bulk 1 MPa": replace(NOMINAL, infill_bulk_mpa=1.0),
}
LAWS = {
    "law usual": secant_laws.usual,
    "law Gent": secant_laws.gent,
    "law no walls": secant_laws.without_walls,
}
CORES = {
    "solid": CoreFailure(),
    "solid, flow 4.7 kPa": CoreFailure(infill_yield_mpa=0.0047),
    "solid, buckling 8 %": CoreFailure(wall_buckling_strain=0.08),
    "solid, tear 80 %": CoreFailure(wall_tear_elongation=0.8),
}
FAILED = ((10.0, 0.5), (5.0, 0.5), (2.0, 0.5))
"""Samples at which cores fail."""
SHOWN = sorted({*TRIED, *FAILED})
COARSE = {"spacing_mm": 0.6, "step_mm": 0.25, "rounds": 1}


def compute(name: str, case: tuple[float, float]) -> dict[str, Any]:
    """One reading with one setting or law, on the centre of a cell; of the nominal one also where walls cross."""
    if name in SETTINGS:
        places = ("cell", "wall") if name == "nominal" else ("cell",)
        return reading(*case, SETTINGS[name], places)
    block = sample(*case, NOMINAL).mounted(NOMINAL.mounting)
    if name in CORES:
        test = DurometerTest(block, "even", spacing_mm=COARSE["spacing_mm"], failure=CORES[name])
        depth, state = test.equilibrium(COARSE["step_mm"], FAILED_N, lambda *_: None)
        torn = int(state.core.torn.sum()) if state.core is not None else 0
        return {"shore_a": [100 * (1 - depth / EXTENSION_MM)], "torn_cells": torn}
    try:
        return secant_laws.reading(block, LAWS[name], "cell", **COARSE)  # type: ignore[arg-type]
    except MagicsimError as error:
        return {"shore_a": None, "refused": str(error)}


def tables(kept: dict[str, Any]) -> str:
    """The results as Markdown."""
    lines = [
        "| height, skin [mm] | published | predicted | on a cell | on a crossing | difference | |",
        "|---|---|---|---|---|---|---|",
    ]
    for case, measured in MEASURED.items():
        found = kept.get(f"nominal {case[0]:g} {case[1]:g}")
        if found is None:
            continue
        use = "fitted" if case in READINGS else "predicted"
        shown = [f"{found[place]:.2f}" if found.get(place) is not None else "-" for place in ("cell", "wall")]
        lines.append(
            f"| {case[0]:g}, {case[1]:g} | {measured:g} | {found['shore_a']:.1f} | {shown[0]} | {shown[1]} | "
            f"{found['shore_a'] - measured:+.1f} | {use} |"
        )
    lines += [
        "",
        "| what is changed | " + " | ".join(f"{a:g}, {b:g}" for a, b in SHOWN) + " |",
        "|---" * (1 + len(SHOWN)) + "|",
    ]
    for name in [*SETTINGS, *LAWS, *CORES]:
        cells, base = [], "solid" if name in CORES else "law usual"
        for case in SHOWN:
            found, usual = (kept.get(f"{each} {case[0]:g} {case[1]:g}") for each in (name, base))
            if found is None or found["shore_a"] is None:
                cells.append("-" if found is None else "refused")
            elif name in SETTINGS:
                cells.append(f"{found['cell']:.2f}")
            else:
                last, first = found["shore_a"][-1], (usual or found)["shore_a"][0]
                cells.append(f"{last:.2f} ({last - first:+.2f})")
        lines.append(f"| {name} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main() -> None:
    """Computes what is missing, or writes the tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--only", choices=[*SETTINGS, *LAWS, *CORES])
    parser.add_argument("--sample", type=float, nargs=2, metavar=("TOTAL", "SKIN"))
    parser.add_argument("--table", action="store_true")
    options = parser.parse_args()
    body = load_preset(ElastomerDesign, "design", "mini-magictac").materials.body
    if body.youngs_modulus_mpa != NOMINAL.body_mpa:
        sys.stderr.write(f"the default design has {body.youngs_modulus_mpa} MPa, these readings {NOMINAL.body_mpa}\n")
    kept: dict[str, Any] = json.loads(RESULT.read_text()) if RESULT.is_file() else {}
    if options.table:
        sys.stdout.write(tables(kept) + "\n")
        return
    for name in [options.only] if options.only else [*SETTINGS, *LAWS, *CORES]:
        usual = list(MEASURED) if name == "nominal" else list(FAILED if name in CORES else TRIED)
        cases = [tuple(options.sample)] if options.sample else usual
        for case in cases:
            key = f"{name} {case[0]:g} {case[1]:g}"
            if key in kept:
                continue
            start = time.perf_counter()
            found = compute(name, case)  # type: ignore[arg-type]
            kept = (json.loads(RESULT.read_text()) if RESULT.is_file() else {}) | {key: found}
            RESULT.write_text(json.dumps(kept, indent=1) + "\n")
            sys.stderr.write(f"{key}: {found['shore_a']}, {time.perf_counter() - start:.0f} s\n")


if __name__ == "__main__":
    main()
