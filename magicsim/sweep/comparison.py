"""From a sweep to its folder: designs judged on many processes, the table and the explorer.

The unit of work: one design, filmed and measured in whatever process, as the bytes of its result.
"""

import base64
import time
from collections.abc import Callable, Sequence
from contextlib import closing
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.config.program import versions
from magicsim.folder.ledger import RESUMABLE, Ledger
from magicsim.folder.target import output_errors, sole_writer
from magicsim.sweep import result as files
from magicsim.sweep.designs import SweptDesign, count_designs, list_designs, value_at
from magicsim.sweep.explorer import render_explorer, rows_of, table_csv, table_parquet
from magicsim.sweep.measures import DURABILITY
from magicsim.sweep.result import FOLDER, DesignResult, SweepIndex, printability, read_result, read_results, result_name
from magicsim.sweep.search import costs_of, optuna_version, pareto_front, search_designs
from magicsim.sweep.sweep_file import SweepConfig
from magicsim.sweep.verdicts import check_trends, leaders, verdicts
from magicsim.waiting import Told, on_stderr, unheard, waiting
from magicsim.workers.attempt import Outcome, Work, WorkerOptions, choose_workers
from magicsim.workers.run_folder import log_failures
from magicsim.workers.tasks import run_tasks

FROM_FILM = frozenset(
    {
        "force_1mm_n", "stiffness_n_per_mm", "sensitivity_per_mm", "sensitivity_per_n", "proximity_range_mm",
        "contact_auc", "contact_accuracy", "localisation_mm", "frame_seconds", "unknowns",
    }
)  # fmt: skip
"""Measures that need the film."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DesignTask:
    """One design and how it is judged."""

    design: SweptDesign
    sweep: SweepConfig


def judge_design(task: DesignTask) -> bytes:
    """Judges one design and returns its `DesignResult` as JSON."""
    from magicsim.light.records.untouched import shared_states
    from magicsim.sweep import parts
    from magicsim.sweep.designs import renderings_of, rows_of_renderings
    from magicsim.sweep.mechanics import durability, hardness

    start = time.perf_counter()
    design, sweep = task.design, task.sweep
    wanted = frozenset(sweep.measures)
    block = parts.block_of(design.sensor.design)
    gathered = parts.Parts()
    if "printability" in wanted:
        gathered.measures["printability"] = printability(block)
    if wanted & FROM_FILM:
        gathered.add(parts.filmed(design.sensor, sweep, shared_states()))
    if wanted & set(parts.SPACING_MEASURES.values()):
        gathered.add(parts.textured(design.sensor, sweep, shared_states()))
    if "shore_a" in wanted:
        gathered.measures["shore_a"] = hardness(design.sensor.design, sweep.quality)
    if wanted & DURABILITY.keys():
        gathered.measures |= durability(design.sensor.design, sweep.object, wanted)
    return DesignResult(
        index=design.index, values=design.values, is_extra=design.is_extra, block=block,
        measures={name: gathered.measures[name] for name in sweep.measures if name in gathered.measures},
        curves=gathered.curves, pictures=gathered.pictures, profile=gathered.profile,
        room=", ".join(sweep.rooms) or design.sensor.rig.room,
        passes=design.sensor.rig.moving is not None,
        drawn=rows_of_renderings(renderings_of(design.sensor, sweep)),
        seconds=time.perf_counter() - start,
    ).to_json()  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class SweepSummary:
    """What `magicsim sweep` reports."""

    designs: int
    """Designs with a result."""
    failed: int
    """Designs without one; `sweep.json` says why."""
    best: dict[str, Any] | None
    """Number, values and first objective of the best design; None where none is clearly ahead of the others."""
    leaders: list[int]
    """Designs that are not clearly behind another one in the first objective, nor of those in the second, and so on."""
    verdicts: dict[str, str]
    """What each measure says of the designs: `told apart`, `indistinguishable` by their intervals, or `saturated`,
    all at one bound or value."""
    front: list[int]
    """Designs in the Pareto front of all objectives."""
    trends: list[dict[str, Any]]
    """Trends, published and our own reading, and how many rows of designs bear them out."""
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
    judge: Work | None = None,
    progress: Callable[[int, int, int], None] | None = None,
    told: Told = on_stderr,
) -> SweepSummary:
    """Judges every design of a sweep, or those that an earlier run left, and writes the folder of results.

    Args:
        sweep: What to compare.
        out: Folder of the results.
        options: Where and how to compute; all cores by default. Never changes a result but its times.
        resume: Whether to go on with the sweep in the folder.
        judge: What judges designs.
        progress: Told after every design: how many ended, how many there are, how many failed.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        ConfigError: A field does not exist, or a value is out of its range.
        OutputError: The folder is not ours, holds another sweep, or cannot be written; what is finished is kept.
    """
    designs, chooser, is_search = list_designs(sweep), dict[str, str](), sweep.sampling == "search"
    if is_search:
        for each in sweep.swept:
            value_at(sweep, each.field)  # refuses what is not there
        chooser = {"optuna": optuna_version()}
    FOLDER.check(out, resume=resume)
    start, judge = time.perf_counter(), judge or Work(function=judge_design)
    options = options or choose_workers(None, timeout_s=sweep.timeout_s)
    heard = waiting("comparing designs", told if progress is None else unheard)
    with heard as share, output_errors(out, then=RESUMABLE), sole_writer(out):
        ledger = FOLDER.open_ledger(out)
        index = SweepIndex(
            config_hash=sweep.config_hash(), versions=versions() | chooser, variant=judge.variant(),
            designs=count_designs(sweep),
        )  # fmt: skip
        earlier = FOLDER.read_index(out)
        if earlier is not None:
            FOLDER.refuse_another(out, earlier, index)
        FOLDER.write_config(ledger, sweep)
        kept = earlier.failed if earlier is not None and is_search else {}
        FOLDER.write_index(ledger, index.model_copy(update={"failed": kept}))
        judged = partial(_judge_all, sweep, ledger, options, judge, progress or share)
        left = [each for each in designs if read_result(out, each.index) is None]
        failed = judged(left, len(designs) - len(left), 0)
        if is_search:
            known, also = failed, len(sweep.also)
            failed = known | search_designs(
                sweep,
                ledger,
                lambda chosen, ended, count: judged(chosen, also + ended, len(known) + count),
                earlier=kept,
                record=lambda now: FOLDER.write_index(ledger, index.model_copy(update={"failed": known | now})),
            )
        results = read_results(out, count_designs(sweep))
        summary = write_results(sweep, ledger, results, failed, seconds=time.perf_counter() - start)
        hashes = {name: ledger.listed(name).sha256 for name in ledger.names() if name != files.INDEX}
        FOLDER.write_index(ledger, index.model_copy(update={"is_complete": True, "failed": failed, "files": hashes}))
        ledger.close()
        return summary


def write_results(
    sweep: SweepConfig, ledger: Ledger, results: list[DesignResult], failed: dict[str, str], *, seconds: float
) -> SweepSummary:
    """Writes table, pictures and explorer of judged designs."""
    kept = [sweep.search is None or sweep.search.keeps(result) for result in results]
    costs = np.where(np.array(kept, bool)[:, None], costs_of(results, sweep.objectives), np.nan)
    front = pareto_front(costs).tolist()
    ahead = leaders([result for result, is_kept in zip(results, kept, strict=True) if is_kept], sweep.objectives)
    told, trends = verdicts(results, sweep.measures), check_trends(results)
    rows = rows_of(results, front)
    ledger.place(files.CSV, table_csv(rows))
    ledger.place(files.PARQUET, table_parquet(rows, sweep.quality))
    for result in results:
        for number, address in enumerate(result.pictures.values()):
            name = f"{files.FRAMES}/{result.index:05d}-{number:02d}.webp"
            ledger.place(name, base64.b64decode(address.partition(",")[2]))
    page = render_explorer(sweep, results, front=front, trends=trends, failed=failed, verdicts=told)
    ledger.place(files.REPORT, page.encode())
    return SweepSummary(
        designs=len(results),
        failed=len(failed),
        best=_best(sweep, ahead[0]) if len(ahead) == 1 else None,
        leaders=[each.index for each in ahead],
        verdicts=told,
        front=[result.index for result, in_front in zip(results, front, strict=True) if in_front],
        trends=[asdict(each) | {"holds": each.holds} for each in trends],
        seconds=round(seconds, 3),
        report=str(ledger.out / files.REPORT),
        out=str(ledger.out),
    )


def _best(sweep: SweepConfig, best: DesignResult) -> dict[str, Any]:
    name = sweep.objectives[0].measure
    measured = best.measures[name]
    ends = {"low": measured.low, "high": measured.high}
    return {"design": best.index, "values": best.values, "measure": name, "value": measured.value} | ends


def _judge_all(
    sweep: SweepConfig, ledger: Ledger, options: WorkerOptions, judge: Work, progress: Callable[[int, int, int], None],
    designs: Sequence[SweptDesign], ended: int, failed_before: int,
) -> dict[str, str]:  # fmt: skip
    """Judges designs; returns why some have no result."""
    failed: dict[str, str] = {}
    if not designs:
        return failed
    tasks = ((design.index, DesignTask(design=design, sweep=sweep)) for design in designs)
    with closing(run_tasks(judge.function, tasks, options, prepare=judge.prepare)) as outcomes:
        outcome: Outcome[bytes]
        for done, outcome in enumerate(outcomes, ended + 1):
            log_failures(ledger.out, "design", outcome.key, outcome.failures)
            if outcome.result is not None:
                ledger.place(result_name(outcome.key), outcome.result)
            else:
                failed[str(outcome.key)] = outcome.failures[-1].message
            progress(done, count_designs(sweep), failed_before + len(failed))
    return failed
