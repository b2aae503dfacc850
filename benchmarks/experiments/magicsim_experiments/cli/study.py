"""The command that runs published experiments on a design: `study`."""

import json as text
import sys
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Seed, Settings, fields_of, print_result, refuse_settings
from magicsim.errors import ConfigError

if TYPE_CHECKING:
    from collections.abc import Sequence

    from magicsim_experiments.study.running import StageEstimate


def estimate(
    model: Annotated[Path, Parameter(help="File, or the name of a model that comes along: localisation.")],
    source: Path, *,
    reference: Annotated[Path | None, Parameter(help="Frames of the untouched sensor.")] = None,
    frames: Annotated[int | None, Parameter(help="Most frames to read.")] = None,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Read frames with a model that a study has learned: one line of JSON, or of text, a frame.

    The source is an image, a folder of images, a video, a camera (by its index), or a finished dataset, which brings
    its own references.
    """
    from magicsim.cli.app import lines_of
    from magicsim_experiments.learn.settings import PACKAGES, need_packages

    refuse_settings(settings, "estimate")
    need_packages(PACKAGES, "estimate")
    from magicsim_experiments.learn.reading import estimate_frames
    from magicsim_experiments.learn.samples import FRAME

    for each in estimate_frames(model, source, reference=reference, frames=frames):
        values = {FRAME: each.frame, **each.values}
        line = text.dumps(values, allow_nan=False) if json else "; ".join(lines_of(values))
        sys.stdout.write(line + "\n")


def study(
    name: str, *,
    out: Annotated[Path | None, Parameter(name="--out", help="Where the result goes.")] = None,
    design: Annotated[str | None, Parameter(help="Design preset or file; the study's own by default.")] = None,
    quick: Annotated[bool, Parameter(negative="", help="The small form: minutes, wide error bars.")] = False,
    plan: Annotated[bool, Parameter(negative="", help="Only say what it would do and take.")] = False,
    workers: Annotated[int | None, Parameter(help="Processes; one for each core by default.")] = None,
    cluster: Annotated[str | None, Parameter(help="Address of a dask.distributed scheduler.")] = None,
    resume: Annotated[bool, Parameter(negative="", help="Go on with the folder's study.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Run a published experiment on a design, and write its tables, figures and a page; `info list studies` names them.

    A run that was stopped or killed goes on with --resume, and ends with the same bytes as one that was not.
    """
    from magicsim.workers.attempt import choose_workers
    from magicsim_experiments.study.study_file import load_study

    found = load_study(name, settings or [], design=design, quick=quick, seed=seed)
    options = choose_workers(workers, cluster=cluster, timeout_s=found.config.timeout_s)
    if plan:
        from magicsim_experiments.study.running import estimate_study

        stages = estimate_study(found, processes=options.workers)
        print_result(_planned(found.config.kind, stages, options.workers), as_json=json)
        return
    if out is None:
        raise ConfigError("--out is missing: where does the result go?")
    from magicsim_experiments.study.protocol import FOLDER

    FOLDER.check(out, resume=resume)
    from magicsim.cli.progress import show_progress
    from magicsim_experiments.study.running import run_study

    announce = partial(_announce, processes=options.workers)
    with show_progress(f"study {Path(name).stem}") as progress:
        summary = run_study(found, out, options=options, resume=resume, announce=announce, progress=progress)
    print_result(fields_of(summary), as_json=json)


def _planned(kind: str, stages: "Sequence[StageEstimate]", processes: int) -> dict[str, object]:
    total = sum(each.core_seconds for each in stages)
    return {
        "study": kind, "stages": [{"stage": each.stage, "core_seconds": round(each.core_seconds)} for each in stages],
        "core_seconds": round(total), "seconds": round(total / processes),
    }  # fmt: skip


def _announce(left: "Sequence[StageEstimate]", processes: int) -> None:
    """Writes the estimate of time, before any work."""
    parts = ", ".join(f"{each.stage} {each.core_seconds / 60:.1f}" for each in left if each.core_seconds)
    minutes = sum(each.core_seconds for each in left) / processes / 60
    if parts:
        about = f"about {minutes:.1f} minutes on {processes} cores (core minutes: {parts}; rough estimates)\n"
        sys.stderr.write(about)
