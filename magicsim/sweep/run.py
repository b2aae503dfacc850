"""From a sweep to its folder: designs judged on many processes, the table and the explorer."""

import base64
import errno
import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from magicsim.dataset.folder import log_failures, sole_writer
from magicsim.dataset.generate import versions
from magicsim.dataset.sample import bound_threads
from magicsim.dataset.shard import place
from magicsim.errors import OutputError
from magicsim.scenes.variant import activate_variant
from magicsim.sweep.designs import SweptDesign, list_designs
from magicsim.sweep.explorer import render_explorer
from magicsim.sweep.folder import (
    CSV,
    FRAMES,
    PARQUET,
    REPORT,
    SweepIndex,
    check_folder,
    read_index,
    read_results,
    refuse_another,
    result_file,
    write_config,
    write_index,
)  # fmt: skip
from magicsim.sweep.judge import DesignTask, judge_design
from magicsim.sweep.pareto import best_of, costs_of, pareto_front
from magicsim.sweep.result import DesignResult
from magicsim.sweep.sweep_file import SweepConfig
from magicsim.sweep.table import rows_of, table_csv, table_parquet
from magicsim.sweep.trends import check_trends
from magicsim.workers.attempt import Prepare
from magicsim.workers.options import WorkerOptions, choose_workers
from magicsim.workers.outcome import Outcome
from magicsim.workers.run import run_tasks


@dataclass(frozen=True, slots=True, kw_only=True)
class Judge:
    """What judges designs."""

    function: Callable[[DesignTask], bytes] = judge_design
    prepare: Prepare | None = bound_threads
    variant: Callable[[], str] = activate_variant


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepSummary:
    """What `magicsim sweep` reports."""

    designs: int
    """Designs with a result."""
    failed: int
    """Designs without one; `sweep.json` says why."""
    best: dict[str, Any] | None
    """Number, values and first objective of the best design."""
    front: list[int]
    """Designs in the Pareto front of all objectives."""
    trends: list[dict[str, Any]]
    """Published trends and how many rows of designs bear them out."""
    seconds: float
    """Time from the first design to the last file [s]."""
    report: str
    """The explorer."""
    out: str


def run_sweep(
    sweep: SweepConfig,
    out: Path,
    *,
    options: WorkerOptions | None = None,
    resume: bool = False,
    judge: Judge | None = None,
    progress: Callable[[int, int, int], None] | None = None,
) -> SweepSummary:
    """Judges every design of a sweep, or those that an earlier run left, and writes the folder of results.

    Args:
        sweep: What to compare.
        out: Folder of the results.
        options: Where and how to compute; all cores by default. Never changes a result but its times.
        resume: Whether to go on with the sweep in the folder.
        judge: What judges designs.
        progress: Told after every design: how many ended, how many there are, how many failed.

    Raises:
        ConfigError: A field does not exist, or a value is out of its range.
        OutputError: The folder is not ours, holds another sweep, or cannot be written; what is finished is kept.
    """
    options = options or choose_workers(None, timeout_s=sweep.timeout_s)
    judge = judge or Judge()
    designs = list_designs(sweep)
    check_folder(out, resume=resume)
    start = time.perf_counter()
    try:
        with sole_writer(out):
            index = SweepIndex(
                config_hash=sweep.config_hash(), versions=versions(), variant=judge.variant(), designs=len(designs)
            )
            earlier = read_index(out)
            if earlier is not None:
                refuse_another(out, earlier, index)
            write_config(out, sweep)
            write_index(out, index)
            failed = _judge_all(sweep, designs, out, options, judge, progress)
            results = read_results(out, len(designs))
            write_index(out, index.model_copy(update={"is_complete": True, "failed": failed}))
            return write_results(sweep, out, results, failed, seconds=time.perf_counter() - start)
    except OSError as error:
        reason = "no space left on the disk" if error.errno == errno.ENOSPC else error.strerror or str(error)
        msg = f"cannot write {out}: {reason}; what is finished is kept, and --resume goes on from there"
        raise OutputError(msg) from None


def write_results(
    sweep: SweepConfig, out: Path, results: list[DesignResult], failed: dict[str, str], *, seconds: float
) -> SweepSummary:
    """Writes table, pictures and explorer of judged designs."""
    front = pareto_front(costs_of(results, sweep.objectives)).tolist()
    best, trends = best_of(results, sweep.objectives), check_trends(results)
    rows = rows_of(results, front)
    place(out / CSV, table_csv(rows))
    place(out / PARQUET, table_parquet(rows))
    for result in results:
        for number, address in enumerate(result.pictures.values()):
            place(out / FRAMES / f"{result.index:05d}-{number:02d}.webp", base64.b64decode(address.partition(",")[2]))
    page = render_explorer(sweep, results, front=front, trends=trends, failed=failed)
    place(out / REPORT, page.encode())
    return SweepSummary(
        designs=len(results),
        failed=len(failed),
        best=_best(sweep, best),
        front=[result.index for result, in_front in zip(results, front, strict=True) if in_front],
        trends=[asdict(each) | {"holds": each.holds} for each in trends],
        seconds=round(seconds, 3),
        report=str(out / REPORT),
        out=str(out),
    )


def _best(sweep: SweepConfig, best: DesignResult | None) -> dict[str, Any] | None:
    if best is None:
        return None
    measure = sweep.objectives[0].measure
    found = best.measures[measure]
    ends = {"low": found.low, "high": found.high}
    return {"design": best.index, "values": best.values, "measure": measure, "value": found.value} | ends


def _judge_all(
    sweep: SweepConfig,
    designs: list[SweptDesign],
    out: Path,
    options: WorkerOptions,
    judge: Judge,
    progress: Callable[[int, int, int], None] | None,
) -> dict[str, str]:
    """Judges what has no result yet; returns why some have none."""
    have = {result.index for result in read_results(out, len(designs))}
    left = [each for each in designs if each.index not in have]
    failed: dict[str, str] = {}
    with closing(run_tasks(judge.function, _tasks(sweep, left), options, prepare=judge.prepare)) as outcomes:
        outcome: Outcome[bytes]
        for done, outcome in enumerate(outcomes if left else (), len(have) + 1):
            log_failures(out, outcome.key, outcome.failures, unit="design")
            if outcome.result is not None:
                place(result_file(out, outcome.key), outcome.result)
            else:
                failed[str(outcome.key)] = outcome.failures[-1].message
            if progress is not None:
                progress(done, len(designs), len(failed))
    return failed


def _tasks(sweep: SweepConfig, designs: list[SweptDesign]) -> Iterator[tuple[int, DesignTask]]:
    for design in designs:
        yield design.index, DesignTask(design=design, sweep=sweep)
