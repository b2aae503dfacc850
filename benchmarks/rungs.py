"""Which rungs of the solver's ladder rescue stress paths: each path without every rung on which its results stand.

    python benchmarks/rungs.py STRESS.json [--paths 0,17,50] [--rows FILE.jsonl] [--out FILE.json]

`STRESS.json` is what `python benchmarks/stress.py` writes: what is valid with all rungs, and which ones ran. A rung
rescues a path if fewer of its stages are valid without it. The others cannot matter, so only rungs on which a result
stands are left out, one by one. Without a rung a path may take `PATIENCE` times the processor time that it took with
all, and `LEAST_S` more; what is not done by then counts as not valid. Every path is a line of `--rows`, and a run with
the same file goes on where the last one stopped; paths that `STRESS.json` does not have are left out. Prints one JSON
object: on how many paths each rung ran, and how many paths and stages it rescued.
"""

import argparse
import json
from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any
from unittest.mock import patch

from laboratory.stress.cases import StressPath, every_path
from laboratory.stress.grid import VALID, OutOfProcessorTimeError, processor_limit, run_path

from magicsim.deform.indentation.press import compile_kernels
from magicsim.deform.quality import NewtonOptions
from magicsim.deform.solve import ladder, load_step, path
from magicsim.deform.solve.ladder import WHY_PLAIN, Rung
from magicsim.deform.solve.problem import Problem

LEFT_OUT = frozenset(Rung) - WHY_PLAIN
"""Rungs that are left out one by one; why a step is plain is told with `PLAIN`."""
PATIENCE, LEAST_S = 3.0, 30.0
"""Processor time without a rung, in times of that with all of them, and what is added [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One stress path."""

    number: int
    label: str
    stages: int
    """That the path has."""
    valid: int
    """Stages that are valid with all rungs."""
    ran: list[str]
    """Rungs on which these stand."""
    seconds: float
    """That the path took with all of them."""
    without: dict[str, int]
    """Stages that are valid without each of `LEFT_OUT`."""


def ablated(rung: Rung) -> list[Any]:
    """Patches that take a rung away."""
    follow = path.ContactSolver._follow_path

    def stuck(problem: Any, surface: Any, iterate: Any) -> Any:  # noqa: ANN401
        return replace(iterate, stuck=True)

    def once(solver: Any, *given: Any, longer: float = 1) -> Any:  # noqa: ANN401
        return follow(solver, *given) if longer == 1 else None

    unshifted = replace(NewtonOptions(), last_shift=1e-12)
    taken: dict[Rung, Callable[[], list[Any]]] = {
        Rung.SHIFTED: lambda: [patch.object(path, "NewtonOptions", lambda **given: replace(unshifted, **given))],
        Rung.PLAIN: lambda: [patch.object(load_step, "newton_step", stuck)],
        Rung.HALVED: lambda: [patch.object(ladder, "SHORTEST", 0.9)],
        Rung.CAREFUL: lambda: [patch.object(Problem, "with_care", lambda problem: problem)],
        Rung.FEWER: lambda: [patch.object(path.ContactSolver, "_follow_path", once)],
    }
    return taken[rung]()


def valid_without(stress: StressPath, rung: Rung, limit_s: float) -> int:
    """Stages that are valid without a rung."""
    valid = 0
    with ExitStack() as stack:
        for each in ablated(rung):
            stack.enter_context(each)
        try:
            with processor_limit(limit_s):
                for row in run_path(stress):
                    valid += row.outcome == VALID
        except OutOfProcessorTimeError:
            pass
    return valid


def run(number: int, stress: StressPath, found: Sequence[Mapping[str, Any]]) -> Row:
    """One path without each rung that ran.

    Args:
        number: Its place in `every_path()`.
        stress: The path.
        found: Its rows with all rungs.
    """
    good = [row for row in found if row["outcome"] == VALID]
    ran = {name for row in good for name in row["rungs"]}
    seconds = sum(row["seconds"] for row in found)
    limit_s = PATIENCE * seconds + LEAST_S
    without = {name: valid_without(stress, Rung(name), limit_s) for name in sorted(ran) if name in LEFT_OUT}
    material = "" if stress.contrast is None else f", contrast {stress.contrast:g}, nu {stress.poisson_ratio:g}"
    return Row(
        number=number, label=stress.label + material, stages=len(stress.stages), valid=len(good), ran=sorted(ran),
        seconds=round(seconds, 1), without=without,
    )  # fmt: skip


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """Paths, and for each rung on how many it ran, and how many paths and stages it rescued."""
    ran = Counter(name for row in rows for name in row.ran)
    rescued = {name: [row for row in rows if row.without.get(name, row.valid) < row.valid] for name in LEFT_OUT}
    return {
        "paths": len(rows),
        "stages": sum(row.stages for row in rows),
        "valid": sum(row.valid for row in rows),
        "rungs": {
            each.value: {"ran": ran[each.value]} | (_rescued(each, rescued[each]) if each in LEFT_OUT else {})
            for each in Rung
        },
        "rows": [asdict(row) for row in rows],
    }


def _rescued(rung: Rung, rows: Sequence[Row]) -> dict[str, int]:
    return {"paths": len(rows), "stages": sum(row.valid - row.without[rung.value] for row in rows)}


def by_path(rows: Iterable[Mapping[str, Any]]) -> dict[tuple[Any, ...], list[Mapping[str, Any]]]:
    """Rows of a stress grid by the key of their path."""
    found: dict[tuple[Any, ...], list[Mapping[str, Any]]] = {}
    for row in rows:
        found.setdefault(tuple(row[name] for name in ("group", "label", "contrast", "poisson_ratio")), []).append(row)
    return found


def main() -> None:
    """Prints one JSON object."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("stress", type=Path)
    parser.add_argument("--paths", type=lambda text: [int(each) for each in text.split(",")])
    parser.add_argument("--rows", type=Path)
    parser.add_argument("--out", type=Path)
    chosen = parser.parse_args()
    compile_kernels()
    paths, rows = every_path(), []
    grid = by_path(json.loads(chosen.stress.read_text(encoding="utf-8"))["results"])
    if chosen.rows is not None and chosen.rows.exists():
        rows = [
            Row(**json.loads(line)) for line in chosen.rows.read_text().splitlines(keepends=True) if line.endswith("\n")
        ]
    done = {row.number for row in rows}
    for number in chosen.paths or range(len(paths)):
        if number in done or paths[number].key not in grid:
            continue
        rows.append(run(number, paths[number], grid[paths[number].key]))
        if chosen.rows is not None:
            with chosen.rows.open("a") as file:
                file.write(json.dumps(asdict(rows[-1])) + "\n")
    text = json.dumps(summary(rows), indent=1)
    print(text)
    if chosen.out is not None:
        chosen.out.write_text(text + "\n")


if __name__ == "__main__":
    main()
