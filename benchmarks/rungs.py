"""Which rungs of the solver's ladder rescue stress paths: each path in full, and again without every rung that ran.

    python benchmarks/rungs.py [--paths 0,17,50] [--every 8] [--limit 120] [--rows FILE.jsonl] [--out FILE.json]

A rung rescues a path if the path passes through fewer of its stages without it. Only rungs on which a
result stands are left out one by one; the others cannot matter. Every path is a line of `--rows`, and
a run with the same file goes on where the last one stopped. `--limit` is in processor seconds of one path; a path that
takes more counts as ended there. Prints one JSON object: on how many paths each rung ran and how many it rescued.
"""

import argparse
import json
from collections import Counter
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

from magicsim.bench.stress.cases import StressPath, every_path
from magicsim.bench.stress.limit import OutOfProcessorTimeError, processor_limit
from magicsim.deform.contact.face import point_spacing_mm
from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.solve import condensed, line_search, load_step, newton, path, strides
from magicsim.deform.solve.ladder import WHY_PLAIN, Rung
from magicsim.deform.solve.problem import Problem
from magicsim.errors import MagicsimError

LEFT_OUT = frozenset(Rung) - (WHY_PLAIN - {Rung.PATIENT})
"""Rungs that are left out one by one; why a step is plain is told with `PLAIN`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One stress path."""

    number: int
    label: str
    stages: int
    """That the path has."""
    passed: int
    """Stages that were solved in full."""
    ran: list[str]
    """Rungs on which its results stand."""
    without: dict[str, int]
    """Stages that were solved without each of `LEFT_OUT`."""


def _ablated(rung: Rung) -> list[Any]:
    """Patches that take a rung away."""
    search, plain = line_search.search, newton.step

    def unstretched(problem: Any, surface: Any, start: Any, direction: Any) -> Any:  # noqa: ANN401
        return search(problem, surface, start, replace(direction, is_stiffened=False))

    def stuck(problem: Any, surface: Any, iterate: Any) -> Any:  # noqa: ANN401
        ends = problem.options.is_condensed
        return replace(iterate, stuck=True) if ends else plain(problem, surface, iterate)

    unshifted = replace(newton.NewtonOptions(), last_shift=1e-12)
    taken: dict[Rung, Callable[[], list[Any]]] = {
        Rung.SHIFTED: lambda: [patch.object(path, "NewtonOptions", lambda **given: replace(unshifted, **given))],
        Rung.PLAIN: lambda: [patch.object(load_step.newton, "step", stuck)],
        Rung.STRETCHED: lambda: [patch.object(each, "search", unstretched) for each in (condensed, newton)],
        Rung.HALVED: lambda: [patch.object(strides, "SHORTEST", 0.9)],
        Rung.CAREFUL: lambda: [patch.object(Problem, "careful", lambda self: self)],
        Rung.PATIENT: lambda: [patch.object(strides, "NEARLY_FOLDED", 2.0)],
        Rung.LEAP: lambda: [patch.object(strides, "FOLDED", 2.0)],
        Rung.FEWER: lambda: [patch.object(path, "RESTARTS", (4,))],
        Rung.MORE: lambda: [patch.object(path, "RESTARTS", (1 / 4,))],
    }
    return taken[rung]()


def stages_passed(stress: StressPath, limit_s: float, without: Rung | None = None) -> tuple[int, set[str]]:
    """Stages that are solved, and the rungs on which they stand."""
    rungs: set[str] = set()
    done = 0
    with ExitStack() as stack:
        for each in _ablated(without) if without is not None else ():
            stack.enter_context(each)
        try:
            with processor_limit(limit_s):
                poses = stress.indenters()
                options: dict[str, Any] = {}
                if stress.max_step_mm is not None:
                    options["max_step_mm"] = stress.max_step_mm
                lattice = stress.lattice()
                branches = stress.branches(lattice)
                timing: dict[str, Any] = {} if branches is None else {"dt_s": stress.stage_s}
                solver = path.ContactSolver(
                    lattice,
                    branches=branches,
                    friction=stress.friction,
                    point_spacing_mm=point_spacing_mm(poses[0].shape),
                    **options,
                )
                state = None
                for pose in poses:
                    state = solver.solve(pose, state, **timing)
                    rungs |= set(state.rungs)
                    done += 1
        except (MagicsimError, OutOfProcessorTimeError):
            pass
    return done, rungs


def run(number: int, stress: StressPath, limit_s: float) -> Row:
    """One path in full, and without each rung that ran."""
    passed, ran = stages_passed(stress, limit_s)
    without = {name: stages_passed(stress, limit_s, Rung(name))[0] for name in sorted(ran) if Rung(name) in LEFT_OUT}
    material = "" if stress.contrast is None else f", contrast {stress.contrast:g}, nu {stress.poisson_ratio:g}"
    return Row(
        number=number, label=stress.label + material, stages=len(stress.stages), passed=passed, ran=sorted(ran),
        without=without,
    )  # fmt: skip


def summary(rows: list[Row]) -> dict[str, Any]:
    """Paths, and for each rung on how many it ran and how many it rescued."""
    ran = Counter(name for row in rows for name in row.ran)
    rescued = Counter(name for row in rows for name, stages in row.without.items() if stages < row.passed)
    return {
        "paths": len(rows),
        "stages": sum(row.stages for row in rows),
        "passed": sum(row.passed for row in rows),
        "rungs": {
            each.value: {"ran": ran[each.value], "rescued": rescued[each.value] if each in LEFT_OUT else None}
            for each in Rung
        },
        "rows": [asdict(row) for row in rows],
    }


def main() -> None:
    """Prints one JSON object."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--paths", type=lambda text: [int(each) for each in text.split(",")])
    parser.add_argument("--every", type=int, default=1)
    parser.add_argument("--limit", type=float, default=120.0)
    parser.add_argument("--rows", type=Path)
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    compile_kernels()
    paths, rows = every_path(), []
    if chosen.rows is not None and chosen.rows.exists():
        rows = [
            Row(**json.loads(line)) for line in chosen.rows.read_text().splitlines(keepends=True) if line.endswith("\n")
        ]
    done = {row.number for row in rows}
    for number in chosen.paths or range(0, len(paths), chosen.every):
        if number in done:
            continue
        rows.append(run(number, paths[number], chosen.limit))
        if chosen.rows is not None:
            with chosen.rows.open("a") as file:
                file.write(json.dumps(asdict(rows[-1])) + "\n")
    text = json.dumps(summary(rows), indent=1)
    print(text)
    if chosen.out is not None:
        chosen.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
