"""The command that compares designs: `sweep`."""

from collections.abc import Callable
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, app, fields_of, print_result


@app.command
def sweep(
    sweep: str, *, out: Out,
    workers: Annotated[int | None, Parameter(help="Processes; one for each core by default.")] = None,
    cluster: Annotated[str | None, Parameter(help="Address of a dask.distributed scheduler.")] = None,
    resume: Annotated[bool, Parameter(negative="", help="Go on with the folder's sweep.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Judge many designs by the same measures, and write a table and a page to explore them.

    A run that was stopped or killed goes on with --resume. A design that fails is reported and stops no other.
    """
    from magicsim.sweep.result import FOLDER
    from magicsim.sweep.sweep_file import load_sweep
    from magicsim.workers.options import choose_workers

    config = load_sweep(sweep, settings or [], seed=seed)
    options = choose_workers(workers, cluster=cluster, timeout_s=config.timeout_s)
    FOLDER.check(out, resume=resume)
    from magicsim.cli.progress import show_progress
    from magicsim.sweep.comparison import run_sweep
    from magicsim.sweep.designs import count_designs

    with show_progress(f"{sweep}: {count_designs(config)} designs") as progress:
        summary = run_sweep(config, out, options=options, resume=resume, progress=_told(progress))
    print_result(fields_of(summary), as_json=json)


def _told(progress: Callable[..., None]) -> Callable[[int, int, int], None]:
    return lambda done, total, failed: progress(done, total, f"{failed} failed" if failed else "")
