"""From a study to its folder: stages in order, each of which goes on where it was, then tables and the page."""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from magicsim.folder.ledger import RESUMABLE
from magicsim.folder.lock import sole_writer
from magicsim.folder.target import output_errors
from magicsim.light.variant import activate_variant
from magicsim.workers.options import WorkerOptions, choose_workers
from magicsim.workers.run_folder import versions
from magicsim_experiments.study.protocol import FOLDER, INDEX, REPORT, Stage, Study, StudyIndex, Workshop
from magicsim_experiments.study.study_file import package_versions
from magicsim_experiments.study.writing import write_result

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
    """Its kind."""
    headline: dict[str, Any]
    """Few numbers that sum it up."""
    seconds: float
    """Time from the first stage to the last file [s]."""
    report: str
    """The page."""
    out: str


def estimate_study(study: Study, *, processes: int, folder: Path | None = None) -> list[StageEstimate]:
    """What a study, or the rest of one, will take.

    Args:
        folder: Where a part of it is done already.
    """
    return [
        StageEstimate(stage=stage.name, core_seconds=0.0 if _is_done(stage, folder) else stage.core_seconds(processes))
        for stage in study.stages()
    ]


def run_study(
    study: Study,
    out: Path,
    *,
    options: WorkerOptions | None = None,
    resume: bool = False,
    announce: Callable[[Sequence[StageEstimate]], None] | None = None,
    progress: Progress | None = None,
    variant: Callable[[], str] = activate_variant,
) -> StudySummary:
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
            kind=study.config.kind,
            config_hash=study.config.config_hash(),
            versions=versions() | packages,
            variant=variant(),
        )
        earlier = FOLDER.read_index(out)
        if earlier is not None:
            FOLDER.refuse_another(out, earlier, index)
        left = estimate_study(study, processes=options.workers, folder=out)
        if announce is not None:
            announce(left)
        FOLDER.write_config(ledger, study.config)
        FOLDER.write_index(ledger, index)
        told = _Told(progress=progress, total=max(sum(each.core_seconds for each in left), 1e-9))
        for stage, cost in zip(stages, left, strict=True):
            if not stage.is_done(out):
                stage.run(Workshop(ledger=ledger, options=options, tell=told.of(cost.core_seconds)))
            told.end(cost.core_seconds)
        found = study.conclude(out)
        write_result(ledger, study, found)
        files = {name: ledger.listed(name).sha256 for name in ledger.names() if name != INDEX}
        FOLDER.write_index(ledger, index.model_copy(update={"is_complete": True, "files": files}))
        ledger.close()
    return StudySummary(
        study=study.config.kind,
        headline=dict(found.headline),
        seconds=round(time.perf_counter() - start, 3),
        report=str(out / REPORT),
        out=str(out),
    )


def _is_done(stage: Stage, folder: Path | None) -> bool:
    return folder is not None and stage.is_done(folder)


@dataclass(slots=True, kw_only=True)
class _Told:
    """How far all stages are, in estimated core seconds."""

    progress: Progress | None
    total: float
    done: float = 0.0

    def of(self, seconds: float) -> Callable[[float, str], None]:
        """What a stage of so many seconds reports to."""

        def tell(share: float, note: str) -> None:
            if self.progress is not None:
                self.progress(self.done + seconds * min(max(share, 0.0), 1.0), self.total, note)

        return tell

    def end(self, seconds: float) -> None:
        """Counts a stage as done."""
        self.done += seconds
