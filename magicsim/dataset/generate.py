"""From a recipe to a dataset on disk: resumable, and the same bytes however it was computed."""

import math
import time
from collections.abc import Callable, Iterable
from contextlib import closing, suppress
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import pyarrow.parquet as pq
import tomli_w

from magicsim.camera.exposure import check_codec
from magicsim.config.documents import dotted, read_toml
from magicsim.config.program import versions
from magicsim.dataset.assembly import Assembly
from magicsim.dataset.card import dataset_card, tier_sentence
from magicsim.dataset.columns import columns_of
from magicsim.dataset.manifest import CALIBRATION, CARD, CONFIG, FOLDER, SENSORS, Manifest, with_files
from magicsim.dataset.recipes.draw import Drawn, DrawnEpisode, draw_episodes, draw_sensors, sensor_of
from magicsim.dataset.recipes.estimate import Cost, estimate
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.rows import SampleTask, at_force, nominal_calibration, sensors_table, simulate_sample
from magicsim.dataset.shard import Column, schema_of_columns
from magicsim.emulator.emulator import EMULATED, OFF
from magicsim.errors import ConvergenceError, MagicsimError, OutputError, RenderError
from magicsim.folder.ledger import RESUMABLE
from magicsim.folder.target import output_errors, sole_writer
from magicsim.scenes.timeline import TierError
from magicsim.waiting import Told, on_stderr, unheard, waiting
from magicsim.workers.attempt import Work, WorkerOptions, choose_workers
from magicsim.workers.run_folder import log_failures
from magicsim.workers.tasks import dealt, run_tasks

NOT_IN_ROWS, MOST_KEYS = frozenset({"episodes", "license", "timeout_s"}), 8
"""Keys of a recipe that rows do not depend on, and the most that a message names."""
CHECKED_FIRST, CHECKED = 200, 100_000
"""Episodes that are drawn, to see that they can be, before anything is written, and before anything is simulated."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Standing:
    """How far a run has come."""

    done: int
    """Episodes that have ended in this run."""
    episode: int
    """Number of the one that ended just now."""
    total: int
    """Episodes that this run simulates."""
    failed: int
    frames: int
    """Frames that the ended episodes have."""
    episode_frames: int
    """Frames of the last one; 0 where it failed."""
    episode_seconds: float
    """How long it took in its process [s]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DatasetSummary:
    """What `magicsim dataset` reports."""

    samples: int
    """Rows in the dataset."""
    shards: int
    failed: int
    """Episodes without rows; `errors.jsonl` says why."""
    seconds: float
    """Time from the first task to the last shard [s]."""
    frames_per_second: float
    """Frames simulated in this run, per second of that time; 0 where none were."""
    bytes: int
    """Size of all shards."""
    out: str


def generate_dataset(
    recipe: Recipe,
    out: Path,
    *,
    options: WorkerOptions | None = None,
    resume: bool = False,
    simulator: Work | None = None,
    announce: Callable[[Cost], None] | None = None,
    phase: Callable[[str], None] = unheard,
    progress: Callable[[Standing], None] | None = None,
    told: Told = on_stderr,
) -> DatasetSummary:
    """Writes a dataset, or the rest of one.

    Args:
        recipe: What to draw.
        out: Folder of the dataset.
        options: Where and how to compute; all cores by default. Never changes the content.
        resume: Whether to go on with the dataset in the folder, which may also grow that way.
        simulator: What makes rows.
        announce: Told what is left to do, before it is begun.
        phase: Told what is done, whenever something else is begun.
        progress: Told after every episode.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        ConfigError: Drawn values are not allowed together, or the camera's codec is not installed.
        OutputError: The folder is not ours, holds another dataset, or cannot be written; what is finished is kept.
        RenderError: An emulated frame was farther off a true one than its model says.
    """
    simulator, options = (
        simulator or Work(function=simulate_sample),
        options or choose_workers(None, timeout_s=recipe.timeout_s),
    )
    with waiting("making a dataset", told if progress is None else unheard) as share:
        check_codec(recipe.rig.camera.compression)
        episodes = draw_episodes(recipe)
        checked = iter(range(min(len(episodes), CHECKED)))
        first = [episodes[number] for number in islice(checked, CHECKED_FIRST)]
        FOLDER.check(out, resume=resume)
        if FOLDER.begun(out) is None:
            _check_forces(first)
        with output_errors(out, then=RESUMABLE), sole_writer(out):
            out.mkdir(parents=True, exist_ok=True)
            is_new = FOLDER.begun(out) is None
            if is_new:  # what refuses an earlier dataset is one line alone
                phase("drawing episodes")
            if announce is not None and is_new:  # the sensors are drawn later, which takes a while where they are many
                announce(estimate(recipe, episodes, processes=options.workers))
            for number in checked:
                episodes[number]
            columns = columns_of(recipe)
            if is_new:
                phase("drawing printed sensors")
            assembly = _begin(recipe, out, columns, simulator.variant())
            left = assembly.episodes_to_simulate()
            if announce is not None and not is_new:
                announce(estimate(recipe, episodes, left, processes=options.workers))
            constants = assembly.manifest.constants() | {"variant": assembly.manifest.variant}
            tasks = (
                (index, SampleTask(episode=episodes[index], columns=columns, constants=constants))
                for index in dealt(map(int, left), lambda number: sensor_of(recipe, number), options.workers)
            )
            phase("the untouched image of the first unit, then touches")
            heard = progress or (lambda now: share(now.done, now.total))
            return _complete(recipe, assembly, episodes, len(left), options, simulator, columns, tasks, heard)


def _begin(recipe: Recipe, out: Path, columns: list[Column], variant: str) -> Assembly:
    earlier = FOLDER.begun(out)
    manifest = Manifest(
        config_hash=recipe.config_hash(),
        versions=versions(),
        variant=variant,
        seed=recipe.seed,
        episodes=recipe.episodes,
        shards=earlier.shards if earlier is not None else (),
        failed=earlier.failed if earlier is not None else (),
        files={},
    )
    if earlier is not None:
        FOLDER.refuse_another(out, earlier, manifest, other=_another(recipe, out))
        if recipe.episodes < earlier.episodes:
            msg = f"episodes = {recipe.episodes} is not allowed: '{out}' holds a dataset of {earlier.episodes} already"
            raise OutputError(msg)
    ledger = FOLDER.open_ledger(out)
    sensors = draw_sensors(recipe, sensor_of(recipe, recipe.episodes - 1) + 1)
    config = tomli_w.dumps(recipe.model_dump(mode="json", exclude_none=True))
    contents = {
        CONFIG: f"# A recipe of magicsim, everything in place: `magicsim dataset {CONFIG}`\n{config}".encode(),
        CARD: dataset_card(recipe, columns, manifest.versions).encode(),
        CALIBRATION: nominal_calibration(recipe),
        SENSORS: sensors_table(sensors),
    }
    return Assembly(ledger, recipe, with_files(manifest, ledger, contents), schema_of_columns(columns))


def _check_forces(episodes: Iterable[DrawnEpisode]) -> None:
    """Refuses (`ConfigError`) forces that an object does not reach; of each kind the largest is pressed."""
    hardest: dict[str, DrawnEpisode] = {}
    for each in episodes:
        if each.must_reach and each.force_n is not None and each.scene.object is not None:
            known = hardest.get(each.scene.object.kind)
            if known is None or each.force_n > (known.force_n or 0.0):
                hardest[each.scene.object.kind] = each
    for each in hardest.values():
        with suppress(ConvergenceError):  # is told of that episode when its turn comes
            at_force(each)


def _another(recipe: Recipe, out: Path) -> str:
    """What a folder with another recipe holds, with the keys that differ."""
    try:
        before = dotted(read_toml(out / CONFIG))
    except MagicsimError:
        return ""
    now = dotted(recipe.model_dump(mode="json", exclude_none=True))
    keys = [key for key in sorted({*before, *now} - NOT_IN_ROWS) if before.get(key) != now.get(key)]
    more = f" and {len(keys) - MOST_KEYS} more" if len(keys) > MOST_KEYS else ""
    what = f"differs in {', '.join(keys[:MOST_KEYS])}{more}" if keys else "names files that have changed"
    return f"a dataset of another recipe, which {what}; without RECIPE --resume takes its {CONFIG}"


def _tell_tier(recipe: Recipe, assembly: Assembly, columns: list[Column]) -> None:
    """Puts into the card how many touches were emulated, and how far those that were checked are off true ones."""
    names = ["contact", "image_way", *(f"tier_{name}" for name in TierError._fields)]
    tables = [pq.read_table(assembly.out / entry.file, columns=names) for entry in assembly.manifest.shards]
    rows = [row for table in tables for row in zip(*(table[name].to_pylist() for name in names), strict=True)]
    ways = [way for is_touch, way, *_ in rows if is_touch]
    checked = [TierError(*error) for _, _, *error in rows if not math.isnan(error[0])]
    tier = tier_sentence(ways.count(EMULATED.image), len(ways), list(dict.fromkeys(checked)))  # held frames are one
    card = dataset_card(recipe, columns, assembly.manifest.versions, tier).encode()
    assembly.manifest = with_files(assembly.manifest, assembly.ledger, {CARD: card})


def _complete(
    recipe: Recipe,
    assembly: Assembly,
    episodes: Drawn[DrawnEpisode],
    total: int,
    options: WorkerOptions,
    simulator: Work,
    columns: list[Column],
    tasks: Iterable[tuple[int, SampleTask]],
    progress: Callable[[Standing], None],
) -> DatasetSummary:
    start = time.perf_counter()
    assembly.write_manifest()
    assembly.close_ready_shards()
    frames = 0
    with closing(run_tasks(simulator.function, tasks, options, prepare=simulator.prepare)) as outcomes:
        for done, outcome in enumerate(outcomes if total else (), 1):
            if not outcome.succeeded and outcome.failures[-1].message.startswith(OFF):
                log_failures(assembly.out, "episode", outcome.key, outcome.failures)  # no episode that is done with
                raise RenderError(f"episode {outcome.key}: {outcome.failures[-1].message}")
            assembly.take(outcome)
            added = recipe.references + episodes[outcome.key].scene.frame_count if outcome.succeeded else 0
            frames += added
            progress(
                Standing(
                    done=done, episode=outcome.key, total=total, failed=len(assembly.failed), frames=frames,
                    episode_frames=added, episode_seconds=outcome.seconds,
                )
            )  # fmt: skip
    if recipe.render.tier == "fast":
        _tell_tier(recipe, assembly, columns)
    assembly.write_manifest()
    assembly.ledger.close()
    seconds = time.perf_counter() - start
    return DatasetSummary(
        samples=assembly.manifest.rows,
        shards=len(assembly.manifest.shards),
        failed=len(assembly.failed),
        seconds=round(seconds, 3),
        frames_per_second=round(frames / seconds, 4) if frames else 0.0,
        bytes=sum(entry.size for entry in assembly.manifest.shards),
        out=str(assembly.out),
    )
