"""Predictions of what decides damage: stretch and stress of the skin, flow of the infill, lateral and sheared forces.

    python benchmarks/prediction_limits.py RUNS            # runs the studies below RUNS, or goes on with them
    python benchmarks/prediction_limits.py RUNS --table    # from what is there: docs/predictions.json and its tables
    python benchmarks/prediction_limits.py RUNS --missing  # only what docs/predictions.json has no result for

Each part is a run of `magicsim study limits` with settings, below RUNS: presses for the skin, those above and beside
the middle of a cell, sheared ones, and variants that change one thing, computed for the skin of 0.6 mm. Walls of 0.2 mm
come with the moduli that read nearest to the two fitted hardness samples, 33 and 21 Shore A instead of 33.25 and 17.1:
no infill is soft enough for both. Nothing is fitted to results.
"""

import argparse
import hashlib
import json
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from laboratory.prediction_tables import write_tables
from magicsim_experiments.study.mechanics.limit_press import CellPress, LimitPress, LimitShear
from magicsim_experiments.study.mechanics.limits import Limits, flow_rows
from magicsim_experiments.study.running import run_study
from magicsim_experiments.study.study_file import load_study
from predictions import RESULT, TABLES

from magicsim.folder import result_file
from magicsim.workers.attempt import choose_workers

NO_BESIDE, NO_SHEAR = "beside.skins_mm=[]", "sheared.paths_mm=[]"
ONE_SKIN = ["skins_mm=[0.6]", NO_BESIDE]
LIGHT, LIGHT_CELLS = "depths_mm=[0.2]", "cells.depths_mm=[0.2]"
LEAST = ["diameters_mm=[2.0]", "skins_mm=[0.6]", LIGHT, LIGHT_CELLS]
"""A study of one light press beside what it is run for."""
PARTS: dict[str, list[str]] = {
    "skin": [LIGHT_CELLS, NO_BESIDE, NO_SHEAR],
    "cells": [LIGHT, NO_BESIDE, NO_SHEAR],
    "beside": [*LEAST, NO_SHEAR],
    "sheared": [*LEAST, NO_BESIDE],
    "walls 0.2 mm": [
        *ONE_SKIN, "design.wall_mm=0.2", "design.materials.body.youngs_modulus_mpa=1.4",
        "design.materials.infill.shear_modulus_mpa=0.002",
    ],
    "friction 0.5": [*ONE_SKIN, "friction=0.5"],
}  # fmt: skip


def study_of(part: str) -> Limits:
    """The study of a part."""
    study = load_study("limits", PARTS[part])
    assert isinstance(study, Limits)
    return study


def tables_of(study: Limits, folder: Path) -> dict[str, Any]:
    """Rows of all tables, from the pieces that a folder has."""
    return {table.name: [dict(row) for row in table.rows] for table in study.conclude(folder).tables}


def missing(limits: dict[str, Any]) -> Iterator[tuple[list[dict[str, Any]], int, Any, Any]]:
    """Rows without a result, those of one variant and table after those of another: table, place, function and task."""
    for variant, tables in limits.items():
        for name in ("presses", "cells", "beside", "sheared"):
            rows = tables.get(name, [])
            part = {"presses": "skin"}.get(name, name) if variant == "nominal" else variant
            stage = getattr(study_of(part), name)
            left = [task for task in stage.tasks if not any(_belongs(row, task) for row in rows)]
            places = [place for place, row in enumerate(rows) if row["refused"] == "no result"]
            for place, task in reversed(list(zip(places, left, strict=True))):
                yield rows, place, stage.function, task


def _belongs(row: dict[str, Any], task: LimitPress | CellPress | LimitShear) -> bool:
    at = (task.depth_mm,) if isinstance(task, LimitShear) else task.depths_mm
    return (row["diameter_mm"], row["skin_mm"]) == (task.diameter_mm, task.design.skin_mm) and row["depth_mm"] in at


def compute_missing(runs: Path) -> None:
    """Computes what has no result, a file each below `runs`, and puts every piece into the JSON when it is there."""
    runs.mkdir(parents=True, exist_ok=True)
    results = json.loads(RESULT.read_text())
    for rows, place, function, task in missing(results["limits"]):
        path = runs / f"{function.__name__}-{hashlib.sha256(repr(task).encode()).hexdigest()[:16]}.json"
        if not path.is_file():
            with result_file(path) as partial:
                partial.write_bytes(function(task))
        rows[place : place + 1] = json.loads(path.read_text())
        RESULT.write_text(json.dumps(results, indent=1) + "\n")
        sys.stderr.write(f"{function.__name__}, {task.diameter_mm:g} mm, skin {task.design.skin_mm:g}: done\n")


def main() -> None:
    """Runs what is left, and writes JSON and tables."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("runs", type=Path)
    parser.add_argument("--only", choices=tuple(PARTS), help="run one part, write nothing")
    parser.add_argument("--table", action="store_true", help="take what is there")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--missing", action="store_true", help="compute rows without a result")
    options = parser.parse_args()
    if options.missing:
        compute_missing(options.runs)
        write_tables(json.loads(RESULT.read_text()), TABLES)
        return
    chosen = [options.only] if options.only else list(PARTS)
    for part in () if options.table else chosen:
        folder = options.runs / part.replace(" ", "-")
        workers = choose_workers(options.workers, timeout_s=6 * 3600.0)
        summary = run_study(study_of(part), folder, options=workers, resume=folder.is_dir())
        sys.stderr.write(f"{part}: {summary.headline}\n")
    if options.only:
        return
    results = json.loads(RESULT.read_text())
    found = {part: tables_of(study_of(part), options.runs / part.replace(" ", "-")) for part in PARTS}
    nominal = {"presses": found.pop("skin")["presses"]}
    nominal |= {part: found.pop(part).get(part, []) for part in ("cells", "beside", "sheared")}
    nominal["flow"] = flow_rows(nominal["presses"], nominal["cells"], study_of("cells").config)
    results["limits"] = {"nominal": nominal} | found
    RESULT.write_text(json.dumps(results, indent=1) + "\n")
    write_tables(results, TABLES)


if __name__ == "__main__":
    main()
