"""Commands that compute many things on many processes: datasets, design sweeps, models of the fast tier.

`dataset RECIPE`, `dataset import` of recorded frames, `dataset verify`, `dataset export`; `sweep`; `distil`.
"""

import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from cyclopts import App, Parameter

from magicsim.cli.app import Json, Out, Seed, Settings, Tier, app, print_result, refuse_settings, with_tier
from magicsim.errors import ConfigError, OutputError

if TYPE_CHECKING:
    from magicsim.dataset.generate import Standing
    from magicsim.dataset.recipes.estimate import Cost
    from magicsim.dataset.recipes.recipe import Recipe
    from magicsim.workers.attempt import WorkerOptions

dataset_app = App(name="dataset")
app.command(dataset_app)
MOST_FRAMES = 1000
"""On one contact sheet."""
Folder = Annotated[Path, Parameter(help="Folder of a dataset.")]
Workers = Annotated[int | None, Parameter(help="Processes; one for each core by default.")]
Cluster = Annotated[str | None, Parameter(help="Address of a dask.distributed scheduler.")]


@dataset_app.default
def dataset(
    recipe: Annotated[str | None, Parameter(help="Preset or file; with --resume the folder's own by default.")] = None,
    *, out: Out,
    workers: Workers = None, cluster: Cluster = None,
    resume: Annotated[bool, Parameter(negative="", help="Go on with the folder's dataset, or let it grow.")] = False,
    preview: Annotated[
        int | None, Parameter(help="Instead of a dataset, a contact sheet of so many coarse frames, and statistics.")
    ] = None,
    tier: Tier = None, settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Write a labelled dataset from a recipe: Parquet shards that Hugging Face `datasets` reads.

    A run that was stopped or killed goes on with --resume, and ends with the same bytes as one that was not. More
    episodes (--set episodes=1000 --resume) make a finished dataset grow. `dataset verify DIR` checks one.
    """
    from magicsim.dataset.manifest import CONFIG, FOLDER
    from magicsim.dataset.recipes.recipe import load_recipe
    from magicsim.workers.attempt import choose_workers

    own = out / CONFIG
    if recipe is None and not (resume and own.is_file()):
        raise ConfigError("recipe is missing: name a preset or a file; --resume alone goes on with a dataset in --out")
    config = load_recipe(recipe or own, with_tier(settings, tier), seed=seed)
    options = choose_workers(workers, cluster=cluster, timeout_s=config.timeout_s)
    if preview is not None:
        _preview(config, out, preview, options, as_json=json)
        return
    FOLDER.check(out, resume=resume)
    from magicsim.cli.progress import show_progress
    from magicsim.dataset.generate import generate_dataset

    with show_progress(f"{recipe or out}: {config.episodes} episodes") as progress:
        summary = generate_dataset(
            config, out, options=options, resume=resume, announce=_announce(out, options.workers),
            phase=lambda name: progress(0, config.episodes, name), progress=_told(progress),
        )  # fmt: skip
    index = FOLDER.read_index(out) if summary.failed else None
    if index is not None and index.failed:
        first = index.failed[0]
        sys.stderr.write(f"{summary.failed} episodes have no rows; episode {first.episode}: {first.message}\n")
    print_result(summary, as_json=json)


@dataset_app.command
def verify(folder: Folder, *, settings: Settings = None, seed: Seed = None, json: Json = False) -> None:
    """Check every file of a dataset against its manifest; exit code 1 where something is wrong."""
    from magicsim.dataset.verify import verify_dataset

    refuse_settings(settings, "dataset verify")
    found = verify_dataset(folder)
    print_result(found, as_json=json)
    if found.problems:
        sys.exit(1)


@dataset_app.command
def export(
    folder: Folder, *, format: Literal["lerobot", "webdataset", "hdf5", "mcap", "zarr"], out: Out,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Write a finished dataset in the layout of another library."""
    from magicsim.dataset.export.formats import export_dataset

    refuse_settings(settings, "dataset export")
    print_result(export_dataset(folder, out, format), as_json=json)


@dataset_app.command(name="import")
def import_frames(
    description: Path, *,
    out: Annotated[Path | None, Parameter(help="Folder of the dataset; without it frames are only looked at.")] = None,
    resume: Annotated[bool, Parameter(negative="", help="Go on with what a stopped run has left there.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Make a dataset of recorded frames and their labels, or say what a description of them should set.

    The description is a TOML file that names frames (folders or videos), CSV files and their columns. The dataset has
    the columns of a simulated one: `detect`, `evaluate --on`, `fit profile`, `fit optics` and `estimate` read it alike.
    """
    from magicsim.cli.progress import show_progress
    from magicsim.dataset.real.description import load_real
    from magicsim.dataset.real.inspection import inspect_real
    from magicsim.dataset.real.writing import write_real
    from magicsim.detectors.video import quiet_opencv

    source = load_real(description, settings or [])
    with quiet_opencv():
        if out is None:
            print_result(inspect_real(source), as_json=json)
            return
        with show_progress(f"{description}: frames"):
            summary = write_real(source, out, resume=resume)
    print_result(summary, as_json=json)


def _preview(recipe: "Recipe", out: Path, count: int, options: "WorkerOptions", *, as_json: bool) -> None:
    if not 1 <= count <= MOST_FRAMES:
        raise ConfigError(f"preview = {count} is not allowed: must be 1 to {MOST_FRAMES} frames")
    if out.is_file():
        raise OutputError(f"output folder '{out}' is a file; name a new folder")
    from magicsim.dataset.preview import preview_recipe
    from magicsim.folder.target import output_errors

    with output_errors(out):
        out.mkdir(parents=True, exist_ok=True)  # what cannot be written is told before anything is rendered
    print_result(preview_recipe(recipe, out, count, options), as_json=as_json)


def _announce(out: Path, workers: int) -> "Callable[[Cost], None]":
    """Writes the estimate of time and disk, before any work."""
    import shutil

    from magicsim.workers.attempt import usable_cores

    def announce(found: "Cost") -> None:
        cores, free = min(workers, usable_cores()), shutil.disk_usage(out).free
        if found.kept[0]:
            sys.stderr.write(f"{found.kept[0]} of {found.kept[1]} episodes kept\n")
        sys.stderr.write(
            f"about {found.frames} frames to simulate, {found.seconds(cores) / 60:.0f} minutes on {cores} core"
            f"{'s' if cores > 1 else ''} and "
            f"{found.bytes / 1e6:.0f} MB of {free / 1e6:.0f} MB that are free (rough estimates)\n"
        )
        parts = ", ".join(f"{each.name} {_time(each.core_seconds / cores)}" for each in found.phases)
        longest = found.longest
        sys.stderr.write(f"of these {parts}\n")
        sys.stderr.write(
            f"most is {longest.name} ({longest.core_seconds / found.core_seconds:.0%}); shorter by {longest.cut}\n"
        )
        if found.savings:
            sys.stderr.write(f"{'; '.join(found.savings)}\n")
        if found.view:
            sys.stderr.write(f"{found.view}\n")
        if found.bytes > free:
            sys.stderr.write("this will probably not fit; what is finished when the disk is full is kept\n")

    return announce


def _time(seconds: float) -> str:
    return f"{seconds / 60:.0f} min" if seconds >= 90 else f"{seconds:.0f} s"  # noqa: PLR2004


def _told(progress: Callable[..., None]) -> "Callable[[Standing], None]":
    start = time.monotonic()

    def tell(standing: "Standing") -> None:
        rate = standing.frames / (time.monotonic() - start)
        progress(standing.done, standing.total, f"{rate:.2f} frames/s, {standing.failed} failed")

    return tell


@app.command
def sweep(
    sweep: str, *, out: Out,
    workers: Workers = None, cluster: Cluster = None,
    resume: Annotated[bool, Parameter(negative="", help="Go on with the folder's sweep.")] = False,
    settings: Settings = None, seed: Seed = None, json: Json = False,
) -> None:  # fmt: skip
    """Judge many designs by the same measures, and write a table and a page to explore them.

    A run that was stopped or killed goes on with --resume. A design that fails is reported and stops no other.
    """
    from magicsim.sweep.result import FOLDER
    from magicsim.sweep.sweep_file import load_sweep
    from magicsim.workers.attempt import choose_workers

    config = load_sweep(sweep, settings or [], seed=seed)
    options = choose_workers(workers, cluster=cluster, timeout_s=config.timeout_s)
    FOLDER.check(out, resume=resume)
    from magicsim.cli.progress import show_progress
    from magicsim.sweep.comparison import run_sweep
    from magicsim.sweep.designs import count_designs

    with show_progress(f"{sweep}: {count_designs(config)} designs") as progress:
        summary = run_sweep(
            config, out, options=options, resume=resume,
            progress=lambda done, total, failed: progress(done, total, f"{failed} failed" if failed else ""),
        )  # fmt: skip
    print_result(summary, as_json=json)


@app.command
def distil(
    design: str, *, out: Out,
    work: Annotated[
        Path | None, Parameter(help="Folder of examples and checkpoints; beside the model by default.")
    ] = None,
    recipe: Annotated[str, Parameter(help="Recipe of the touches.")] = "distil",
    steps: Annotated[int, Parameter(help="Steps of the training; 0 measures what --start names.")] = 12_000,
    start: Annotated[Path | None, Parameter(help="Model of a like sensor that the network begins as.")] = None,
    workers: Workers = None, cluster: Cluster = None,
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
    from magicsim.emulator.model import TouchModel
    from magicsim.workers.attempt import choose_workers

    check_number("steps", steps, 0 if start else 1, 10_000_000, whole=True)
    if out.suffix.lower() != MODEL_SUFFIX:
        raise ConfigError(f"out = '{out}' is not allowed: a model ends with {MODEL_SUFFIX}")
    config = load_recipe(recipe, [f"design={design}", *(settings or [])], seed=seed)
    options = choose_workers(workers, cluster=cluster, timeout_s=config.timeout_s)
    with show_progress(f"{design}: {config.episodes} episodes of touches") as progress:
        summary = make(
            config, out, work or out.with_name(f"{out.stem}.examples"), options=options,
            training=Training(steps=steps, start=TouchModel.read(start, "start") if start else None), resume=resume,
            progress=lambda what, done, total, note: progress(done, total, f"{what} {note}".strip()),
        )  # fmt: skip
    print_result(summary, as_json=json)
