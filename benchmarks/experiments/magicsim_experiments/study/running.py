"""From a study to its folder: stages in order, each of which goes on where it was, then tables and the page."""

import json
import math
import re
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
from markupsafe import Markup

from magicsim.config.documents import without_nan
from magicsim.config.program import versions
from magicsim.dataset.shard import parquet_bytes
from magicsim.folder.ledger import RESUMABLE, Ledger
from magicsim.folder.target import output_errors, sole_writer
from magicsim.light.variant import activate_variant
from magicsim.report.text import MISSING, number, page_template
from magicsim.workers.attempt import WorkerOptions, choose_workers
from magicsim_experiments.study.protocol import (
    FOLDER,
    INDEX,
    REPORT,
    RESULTS,
    TABLES,
    Cell,
    Column,
    Study,
    StudyIndex,
    StudyResult,
    Table,
    Workshop,
)
from magicsim_experiments.study.study_file import package_versions

UNIT_ENDS = {"mm": "mm", "n": "N", "deg": "deg"}
"""Ends of headline keys that are units, as a page writes them."""
MANY = 13
"""Columns of a matrix from which its cells are small."""


def render_page(study: Study, found: StudyResult) -> str:
    """A whole HTML document."""
    config = study.config
    return page_template("study.html.jinja", "magicsim_experiments.study", "magicsim.report").render(
        title=f"Study: {config.kind.replace('-', ' ')}", facts={**found.facts, "Seed": str(config.seed)},
        headline={headed(name): shown(value) for name, value in found.headline.items()}, tables=found.tables,
        matrices=[(each, each.counts / np.maximum(each.counts.sum(1, keepdims=True), 1)) for each in found.matrices],
        many=MANY, head=head, shown=shown,
        figures=[(each.title, each.note, Markup(each.svg)) for each in found.figures], notes=found.notes,
    )  # fmt: skip


def shown(value: Cell, digits: int = 3) -> str:
    """A value as text; numbers below what the digits show get three significant ones."""
    if value is None:
        return MISSING
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, float):
        small = math.isfinite(value) and 0 < abs(value) < 10.0**-digits
        return f"{value:.2e}" if small else number(value, digits)
    return str(value)


def in_words(name: str) -> str:
    """A key as words, such as `error of x mm`; points within numbers stay."""
    return re.sub(r"(?<!\d)\.|\.(?!\d)", " ", name.replace("_", " "))


def headed(name: str) -> str:
    """A key of the headline as words, its unit in brackets where the key ends with one."""
    head, _, end = name.rpartition("_")
    is_unit = end in UNIT_ENDS and head != "" and not head[-1].isdigit()
    return f"{in_words(head)} [{UNIT_ENDS[end]}]" if is_unit else in_words(name)


def head(column: Column) -> str:
    """Head of a column, its unit in brackets."""
    title = column.title or in_words(column.name.removesuffix(f"_{column.unit}") if column.unit else column.name)
    return f"{title} [{column.unit}]" if column.unit else title


def write_result(ledger: Ledger, study: Study, found: StudyResult) -> None:
    """Writes everything that a reader opens; what is not a number is null in the JSON."""
    tables = [*found.tables, *(matrix.as_table() for matrix in found.matrices)]
    for table in tables:
        ledger.place(f"{TABLES}/{table.name}.parquet", table_parquet(table))
    values = {
        "study": study.config.kind, "seed": study.config.seed, "headline": without_nan(found.headline),
        "facts": dict(found.facts), "tables": {table.name: without_nan(list(table.rows)) for table in tables},
        "notes": list(found.notes),
    }  # fmt: skip
    ledger.place(RESULTS, (json.dumps(values, allow_nan=False, indent=1) + "\n").encode())
    ledger.place(REPORT, render_page(study, found).encode())


def table_parquet(table: Table) -> bytes:
    """A table as a Parquet file, title and unit of every column in its metadata."""
    fields = []
    for each in table.columns:
        about = {name: value for name, value in (("title", each.title), ("unit", each.unit)) if value}
        fields.append(pa.field(each.name, _kind(row.get(each.name) for row in table.rows), metadata=about or None))
    rows = [{each.name: row.get(each.name) for each in table.columns} for row in table.rows]
    return parquet_bytes(pa.Table.from_pylist(rows, schema=pa.schema(fields)))


def _kind(values: Iterable[object]) -> pa.DataType:
    present = [value for value in values if value is not None]
    if any(isinstance(value, float) for value in present) or not present:
        return pa.float64()
    return pa.array(present).type


Progress = Callable[[float, float, str], None]
"""Takes work done and all work [core seconds as estimated], and a note."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StageEstimate:
    """What a stage will take, roughly."""

    stage: str
    core_seconds: float
    """Time on one core [s]; 0 where it is done."""


@dataclass(frozen=True, slots=True, kw_only=True)
class StudySummary:
    """What `magicsim study` reports."""

    study: str
    """Kind of the study."""
    headline: dict[str, Any]
    """Few numbers that sum it up."""
    seconds: float
    """Time from the first stage to the last file [s]."""
    report: str
    """The page."""
    out: str


def estimate_study(study: Study, *, processes: int, folder: Path | None = None) -> list[StageEstimate]:
    """What a study will take, or the rest of one of which a folder holds a part."""
    done = {stage.name for stage in study.stages() if folder is not None and stage.is_done(folder)}
    return [
        StageEstimate(stage=stage.name, core_seconds=0.0 if stage.name in done else stage.core_seconds(processes))
        for stage in study.stages()
    ]


def run_study(
    study: Study, out: Path, *, options: WorkerOptions | None = None, resume: bool = False,
    announce: Callable[[Sequence[StageEstimate]], None] | None = None, progress: Progress | None = None,
    variant: Callable[[], str] = activate_variant,
) -> StudySummary:  # fmt: skip
    """Runs a study, or what an earlier run left of it, and writes its folder.

    Args:
        study: What to do, see `magicsim_experiments.study.study_file.load_study`.
        options: Where and how to compute; all cores by default. Changes no byte of the result.
        resume: Whether to go on with the study in the folder.
        announce: Told what is left to do, before it is begun.

    Raises:
        ConfigError: The design cannot do this study, or a package that it needs is not installed.
        OutputError: The folder is not ours, holds another study, or cannot be written; what is finished is kept.
    """
    options = options or choose_workers(None, timeout_s=study.config.timeout_s)
    study.refuse()
    packages = package_versions(study)
    FOLDER.check(out, resume=resume)
    stages = study.stages()
    start = time.perf_counter()
    with output_errors(out, then=RESUMABLE), sole_writer(out):
        out.mkdir(parents=True, exist_ok=True)
        ledger = FOLDER.open_ledger(out, owned=lambda name: any(stage.owns(name) for stage in stages))
        index = StudyIndex(
            kind=study.config.kind, config_hash=study.config.config_hash(),
            versions=versions("magicsim_experiments") | packages, variant=variant(),
        )  # fmt: skip
        earlier = FOLDER.read_index(out)
        if earlier is not None:
            FOLDER.refuse_another(out, earlier, index)
        left = estimate_study(study, processes=options.workers, folder=out)
        if announce is not None:
            announce(left)
        FOLDER.write_config(ledger, study.config)
        FOLDER.write_index(ledger, index)
        total, done = max(sum(each.core_seconds for each in left), 1e-9), 0.0
        for stage, cost in zip(stages, left, strict=True):

            def tell(share: float, note: str, done: float = done, seconds: float = cost.core_seconds) -> None:
                if progress is not None:
                    progress(done + seconds * min(max(share, 0.0), 1.0), total, note)

            if not stage.is_done(out):
                stage.run(Workshop(ledger=ledger, options=options, tell=tell))
            done += cost.core_seconds
        found = study.conclude(out)
        write_result(ledger, study, found)
        files = {name: ledger.listed(name).sha256 for name in ledger.names() if name != INDEX}
        FOLDER.write_index(ledger, index.model_copy(update={"is_complete": True, "files": files}))
        ledger.close()
    return StudySummary(
        study=study.config.kind, headline=dict(found.headline), seconds=round(time.perf_counter() - start, 3),
        report=str(out / REPORT), out=str(out),
    )  # fmt: skip
