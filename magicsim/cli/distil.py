"""The command that makes models of the fast tier: `distil`."""

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, app, fields_of, print_result
from magicsim.errors import ConfigError


@app.command
def distil(
    design: str, *, out: Out,
    work: Annotated[
        Path | None, Parameter(help="Folder of examples and checkpoints; beside the model by default.")
    ] = None,
    recipe: Annotated[str, Parameter(help="Recipe of the touches.")] = "distil",
    steps: Annotated[int, Parameter(help="Steps of the training.")] = 12_000,
    workers: Annotated[int | None, Parameter(help="Processes; one for each core by default.")] = None,
    cluster: Annotated[str | None, Parameter(help="Address of a dask.distributed scheduler.")] = None,
    resume: Annotated[bool, Parameter(negative="", help="Go on with the folder's examples, or let them grow.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Make a model of a design's touches for the fast tier (render.tier = "fast"), and measure how far off it is.

    Renders touches of a recipe truly, trains a network on them, and judges it by touches that it never saw. A run that
    was stopped or killed goes on with --resume.
    """
    from magicsim.cli.progress import show_progress
    from magicsim.config.named_files import MODEL_SUFFIX
    from magicsim.config.ranges import check_number
    from magicsim.dataset.recipes.recipe import load_recipe
    from magicsim.distil.distillation import distil as make
    from magicsim.distil.training import Training
    from magicsim.workers.attempt import choose_workers

    check_number("steps", steps, 1, 10_000_000, whole=True)
    if out.suffix.lower() != MODEL_SUFFIX:
        raise ConfigError(f"out = '{out}' is not allowed: a model ends with {MODEL_SUFFIX}")
    config = load_recipe(recipe, [f"design={design}", *(settings or [])], seed=seed)
    options = choose_workers(workers, cluster=cluster, timeout_s=config.timeout_s)
    with show_progress(f"{design}: {config.episodes} episodes of touches") as progress:
        summary = make(
            config, out, work or out.with_name(f"{out.stem}.examples"), options=options,
            training=Training(steps=steps), resume=resume,
            progress=lambda what, done, total, note: progress(done, total, f"{what} {note}".strip()),
        )  # fmt: skip
    print_result(fields_of(summary), as_json=json)
