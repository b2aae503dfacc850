"""The paths of the stress grid on all cores, within processor seconds each; what a killed run has done is kept."""

import json
import logging
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path

from magicsim.bench.stress.cases import StressPath, every_path
from magicsim.bench.stress.grid import CRASHED, TIMED_OUT, StressRow, run_path, unsolved
from magicsim.bench.stress.limit import OutOfProcessorTimeError, processor_limit
from magicsim.workers.options import WorkerOptions, usable_cores
from magicsim.workers.outcome import FailureKind
from magicsim.workers.tasks import run_tasks

LOGGER = logging.getLogger(__name__)
SLOW = frozenset({"sphere 0.5 mm"})
"""What is left to the end: pressed more than its own size deep, it takes minutes a stage."""
LIMIT_S = 1200.0
"""Processor time for all stages of one path; what is not done by then counts as not valid."""
STUCK = 20
"""How many times longer a path may take by the clock: it does not compute any more, or not here alone."""


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
    options = WorkerOptions(workers=usable_cores(), timeout_s=STUCK * LIMIT_S, retries=0)
    tasks = [(number, (numbers[path.key], str(file), LIMIT_S)) for number, (path, file) in enumerate(todo)]
    for done, outcome in enumerate(run_tasks(_solve, tasks, options, prepare=_use_threads), 1):
        path, file = todo[outcome.key]
        if outcome.failures:
            failure = outcome.failures[-1]
            kind = TIMED_OUT if failure.kind == FailureKind.TIMEOUT else CRASHED
            for stage in path.stages[len(_read(file)) :]:
                _append(file, unsolved(path, stage, kind, failure.message))
        rows = _read(file)
        LOGGER.info(
            "%d of %d: %s, contrast %s, nu %s: %s, %.1f s", done, len(todo), path.label, path.contrast,
            path.poisson_ratio, [row.outcome for row in rows], sum(row.seconds for row in rows),
        )  # fmt: skip
    return [row for file in files for row in _read(file)]


def remove_parts(folder: Path) -> None:
    """Removes the files of all paths, and their folder where it holds nothing else.

    Args:
        folder: What `pooled_rows` was given.
    """
    for number, path in enumerate(every_path()):
        file = folder / f"{number:03d}.jsonl"
        if len(_read(file)) == len(path.stages):
            file.unlink(missing_ok=True)
    with suppress(OSError):  # somebody else's file is in it
        folder.rmdir()


def _use_threads(threads: int) -> None:
    """As many processes as cores share the machine best when each has one thread."""
    from magicsim.deform.solve import pardiso

    pardiso.THREADS = threads


def _solve(task: tuple[int, str, float]) -> int:
    """Solves one path into its file within processor seconds; returns the number of stages."""
    path, file, limit_s = every_path()[task[0]], Path(task[1]), task[2]
    file.unlink(missing_ok=True)
    try:
        with processor_limit(limit_s):
            for row in run_path(path):
                _append(file, row)
    except OutOfProcessorTimeError as error:
        for stage in path.stages[len(_read(file)) :]:
            _append(file, unsolved(path, stage, TIMED_OUT, str(error)))
    return len(path.stages)


def _append(file: Path, row: StressRow) -> None:
    with file.open("a", encoding="utf-8") as lines:
        lines.write(json.dumps(asdict(row)) + "\n")


def _read(file: Path) -> list[StressRow]:
    if not file.exists():
        return []
    lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
    return [StressRow(**json.loads(line)) for line in lines if line.endswith("\n")]
