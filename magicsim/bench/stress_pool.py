"""The paths of the stress grid on all cores, each with a limit of time; what a killed run has done is kept."""

import json
import logging
import multiprocessing
import os
from collections.abc import Sequence
from concurrent.futures import TimeoutError as LimitExceeded
from dataclasses import asdict
from pathlib import Path

from pebble import ProcessExpired, ProcessPool

from magicsim.bench.stress import CRASHED, TIMED_OUT, StressRow, run_path, unsolved
from magicsim.bench.stress_cases import StressPath, every_path

LOGGER = logging.getLogger(__name__)
SLOW = frozenset({"sphere 0.5 mm"})
"""What is left to the end: pressed more than its own size deep, it takes minutes a stage."""
LIMIT_S = 1200.0
"""Time for all stages of one path; what is not done by then counts as not valid."""


def pooled_rows(chosen: Sequence[StressPath], folder: Path) -> list[StressRow]:
    """Rows of all paths in order.

    Args:
        chosen: Some of `every_path()`.
        folder: Holds one file a path, a line a stage; complete ones are read instead of solved again.
    """
    folder.mkdir(parents=True, exist_ok=True)
    numbers = {path.key: number for number, path in enumerate(every_path())}
    files = [folder / f"{numbers[path.key]:03d}.jsonl" for path in chosen]
    todo = [(path, file) for path, file in zip(chosen, files, strict=True) if len(_read(file)) < len(path.stages)]
    todo.sort(key=lambda each: each[0].label in SLOW)
    with ProcessPool(
        max_workers=os.cpu_count() or 1, context=multiprocessing.get_context("spawn"), initializer=_one_thread
    ) as pool:
        futures = [
            (path, file, pool.schedule(_solve, args=[numbers[path.key], str(file)], timeout=LIMIT_S))
            for path, file in todo
        ]
        for number, (path, file, future) in enumerate(futures, 1):
            try:
                future.result()
            except LimitExceeded:
                _complete(file, path, TIMED_OUT, f"not done after {LIMIT_S:g} s")
            except ProcessExpired as error:
                _complete(file, path, CRASHED, str(error))
            rows = _read(file)
            LOGGER.info(
                "%d of %d: %s, contrast %s, nu %s: %s, %.1f s", number, len(todo), path.label, path.contrast,
                path.poisson_ratio, [row.outcome for row in rows], sum(row.seconds for row in rows),
            )  # fmt: skip
    return [row for file in files for row in _read(file)]


def _one_thread() -> None:
    """As many processes as cores share the machine best when each has one thread."""
    from magicsim.deform import linear

    linear.THREADS = 1


def _solve(number: int, name: str) -> None:
    file = Path(name)
    file.unlink(missing_ok=True)
    for row in run_path(every_path()[number]):
        _append(file, row)


def _complete(file: Path, path: StressPath, outcome: str, message: str) -> None:
    for stage in path.stages[len(_read(file)) :]:
        _append(file, unsolved(path, stage, outcome, message))


def _append(file: Path, row: StressRow) -> None:
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(asdict(row)) + "\n")


def _read(file: Path) -> list[StressRow]:
    if not file.exists():
        return []
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    return [StressRow(**json.loads(line)) for line in lines if line.endswith("\n")]
