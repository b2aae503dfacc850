"""From a recipe of touches to a model of the fast tier: examples, training, errors on touches that it never saw."""

import time
from collections.abc import Callable, Iterator
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.camera.exposure import meter
from magicsim.camera.film import blurred_px
from magicsim.config.program import versions
from magicsim.dataset.recipes.draw import draw_episodes, sensor_of
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.distil.examples import HELD_OUT_EVERY, Example, ExampleTask, is_held_out, render_example
from magicsim.distil.network import find_torch, to_onnx
from magicsim.distil.training import Library, Training, train
from magicsim.emulator.emulator import unknown_sensor
from magicsim.emulator.model import ALL, ErrorRow, Interval, ModelFacts, TouchModel, coarse, rest_key, sensor_facts
from magicsim.errors import ConfigError, OutputError
from magicsim.folder.ledger import RESUMABLE, Ledger
from magicsim.folder.result import check_file, result_file
from magicsim.folder.target import output_errors, sole_writer
from magicsim.light.variant import activate_variant
from magicsim.scenes.scene import SceneConfig
from magicsim.scenes.timeline import UNTOUCHED
from magicsim.simulation.sensor import Sensor
from magicsim.workers.attempt import WorkerOptions, bound_threads
from magicsim.workers.run_folder import RunFolder, RunIndex, log_failures
from magicsim.workers.tasks import dealt, run_tasks

FOLDER = RunFolder(
    index="distil.json", model=RunIndex, noun="distillation", content="set of examples",
    title="A recipe of magicsim, everything in place, whose touches a model was distilled from",
)  # fmt: skip
IMAGES = 2
"""Independent images of each touch that errors are measured by."""
FAR_MM = 1.2
"""Depth that parts shallow touches from deep ones in the table of errors [mm]."""
SHALLOW_MM = 0.4
Progress = Callable[[str, int, int, str], None]
"""Told what is done, how much of it, of how much, and a word."""


@dataclass(frozen=True, slots=True, kw_only=True)
class DistilSummary:
    """What `magicsim distil` reports."""

    touches: int
    """Touches that the model learned from."""
    failed: int
    """Episodes without an example; `errors.jsonl` says why."""
    errors: list[dict[str, Any]]
    """How far off the model is on touches that it never saw, see `ErrorRow`."""
    seconds: float
    bytes: int
    out: str


def distil(
    recipe: Recipe, out: Path, work: Path, *, options: WorkerOptions, training: Training, resume: bool = False,
    progress: Progress = lambda *_: None,
) -> DistilSummary:  # fmt: skip
    """Makes a model, or goes on with one.

    Args:
        recipe: Which touches, on which sensor.
        out: File of the model.
        work: Folder of examples and checkpoints.
        options: Where examples are rendered; never changes one.
        training: How the network is trained.
        resume: Whether to go on with what the folder holds; it may grow.
        progress: Told as work ends.

    Raises:
        ConfigError: PyTorch or ONNX is not installed, or the recipe draws what is not allowed, is of the fast tier, or
            of a sensor that no model can know.
        OutputError: A folder is not ours, the file cannot be written, or nothing of the recipe touches.
    """
    find_torch()
    if recipe.render.tier == "fast":
        raise ConfigError("render.tier = 'fast' is not allowed: a model is distilled from true frames")
    if (problem := unknown_sensor(recipe.design, recipe.rig, recipe.contact)) is not None:
        raise ConfigError(f"no model is made of this sensor: {problem}")
    if recipe.episodes < HELD_OUT_EVERY:
        raise ConfigError(
            f"episodes = {recipe.episodes} is not allowed: must be at least {HELD_OUT_EVERY}, of which one judges"
        )
    check_file(out)
    start = time.perf_counter()
    FOLDER.check(work, resume=resume)
    with output_errors(work, then=RESUMABLE), sole_writer(work):
        work.mkdir(parents=True, exist_ok=True)
        ledger = FOLDER.open_ledger(work)
        index = RunIndex(config_hash=recipe.config_hash(), versions=versions(), variant=activate_variant())
        earlier = FOLDER.read_index(work)
        if earlier is not None:
            FOLDER.refuse_another(work, earlier, index)
        FOLDER.write_config(ledger, recipe)
        FOLDER.write_index(ledger, index)
        failed = _render(recipe, ledger, options, progress)
        paths = [work / example_name(number) for number in range(recipe.episodes)]
        kept = [path for number, path in enumerate(paths) if path.is_file() and not is_held_out(number)]
        seen = [path for number, path in enumerate(paths) if path.is_file() and is_held_out(number)]
        if not kept or not seen:
            raise OutputError(f"'{work}' holds too few examples: {len(kept)} to learn from and {len(seen)} to judge by")
        network = train(
            Library(paths=kept),
            training,
            ledger,
            lambda step, steps, loss: progress("training", step, steps, f"loss {loss:.3g}"),
        )
        sensor = Sensor(recipe.design, recipe.rig, render=recipe.render)
        rest = coarse(sensor.radiance(UNTOUCHED, sensor.rest))
        facts = _facts(out.stem, kept, rest_key(recipe.design, recipe.rig))
        model = TouchModel(facts=facts, network=to_onnx(network), rest=rest)
        errors = measure(model, Library(paths=seen))
        model = replace(model, facts=facts.model_copy(update={"errors": errors}))
        content = model.to_bytes()
        with result_file(out) as partial:
            partial.write_bytes(content)
        hashes = {name: ledger.listed(name).sha256 for name in ledger.names() if name != FOLDER.index}
        FOLDER.write_index(ledger, index.model_copy(update={"is_complete": True, "files": hashes}))
        ledger.close()
    return DistilSummary(
        touches=facts.touches, failed=failed, errors=[row.model_dump() for row in model.facts.errors],
        seconds=round(time.perf_counter() - start, 1), bytes=len(content), out=str(out),
    )  # fmt: skip


def example_name(number: int) -> str:
    """File of an example, below the folder."""
    return f"examples/{number:05d}.npz"


def _render(recipe: Recipe, ledger: Ledger, options: WorkerOptions, progress: Progress) -> int:
    """Renders what is missing; how many episodes have no example."""
    episodes = draw_episodes(recipe)
    missing = [number for number in range(recipe.episodes) if not ledger.is_intact(example_name(number))]
    tasks = (
        (number, ExampleTask(number=number, episode=episodes[number], images=IMAGES if is_held_out(number) else 1))
        for number in dealt(missing, lambda number: sensor_of(recipe, number), options.workers)
    )
    failed, done = 0, recipe.episodes - len(missing)
    with closing(run_tasks(render_example, tasks, options, prepare=bound_threads)) as outcomes:
        for outcome in outcomes if missing else ():
            log_failures(ledger.out, "episode", outcome.key, outcome.failures)
            if outcome.result is not None:
                ledger.place(example_name(outcome.key), outcome.result)
            else:
                failed += 1
            done += 1
            progress("rendering", done, recipe.episodes, f"{failed} failed" if failed else "")
    return failed


def _facts(name: str, paths: list[Path], rest: str) -> ModelFacts:
    """What the examples say that the model knows."""
    examples = [each.facts for each in Library(paths=paths)]
    sensors = [sensor_facts(scene.design, scene.rig) for scene in map(_scene, examples)]
    spacings = [each["spacing_mm"] for each in examples if each["spacing_mm"] is not None]
    return ModelFacts(
        name=name,
        sensor={name: _interval([each[name] for each in sensors]) for name in sensors[0]},
        rest_key=rest,
        rooms=sorted({each["room"] for each in examples}),
        kinds=sorted({each["kind"] for each in examples}),
        depth_mm=max(touch["depth_mm"] for each in examples for touch in each["touches"]),
        specular=max(each["specular"] for each in examples),
        spacing_mm=min(spacings, default=0.0),
        blur_px=blurred_px(_scene(examples[0]).rig.camera),
        touches=sum(len(each["touches"]) for each in examples),
        versions=versions(),
    )


def _scene(facts: dict[str, Any]) -> SceneConfig:
    return SceneConfig.model_validate(facts["scene"])


def _interval(values: list[str | float]) -> str | Interval:
    if isinstance(values[0], str):
        return values[0]
    numbers = [float(each) for each in values]
    return min(numbers), max(numbers)


def measure(model: TouchModel, library: Library) -> list[ErrorRow]:
    """Errors on examples that were not learned from: all, by depth, by kind of object, by room."""
    groups: dict[str, list[tuple[float, float, float]]] = {}
    for example in library:
        for touch, row in _errors(model, example, library):
            depth = example.facts["touches"][touch]["depth_mm"]
            band = "shallow" if depth < SHALLOW_MM else "deep" if depth > FAR_MM else "middle"
            for name in (ALL, f"{band} touches", f"object {example.facts['kind']}", f"room {example.facts['room']}"):
                groups.setdefault(name, []).append(row)
    rows = []
    for name, found in groups.items():
        change, error, tier = np.sqrt(np.maximum(np.mean(found, 0), 0))
        rows.append(ErrorRow(states=name, touches=len(found), change=change, error=error, true_tier=tier))
    return rows


def _errors(model: TouchModel, example: Example, library: Library) -> Iterator[tuple[int, tuple[float, float, float]]]:
    """Mean squares of change, error and the true tier's error of each touch, by products of independent images."""
    maker, scene = library.maker(example), _scene(example.facts)
    gain = 255 * meter(example.rest, scene.rig.camera, scene.lit)
    for touch in range(len(example.mask)):
        fields, gate = example.fields(maker, touch)
        answer = gate[..., None] * model.predict(fields)
        first, second = (example.change[touch, image].astype(np.float32) for image in range(IMAGES))
        tier = example.tier[touch].astype(np.float32)

        squares = [float(np.mean(gain**2 * (image - first) * (image - second))) for image in (0 * tier, answer, tier)]
        yield touch, (squares[0], squares[1], squares[2])
