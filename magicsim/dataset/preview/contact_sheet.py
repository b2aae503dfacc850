"""A look at a recipe before a long run: a contact sheet of coarse frames, and statistics."""

import math
import textwrap
import time
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.arrays import Frame
from magicsim.dataset.preview.preview_files import SHEET, check_preview, write_preview
from magicsim.dataset.preview.representative import ENLARGE, metering_scene, preview_scene, quality, telling_state
from magicsim.dataset.recipes.draw import DrawnEpisode, draw_episodes
from magicsim.dataset.recipes.estimate import estimate, odd_step
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.recipes.statistics import recipe_statistics
from magicsim.scenes.scene import SceneConfig
from magicsim.workers.options import WorkerOptions, usable_cores
from magicsim.workers.tasks import run_tasks
from magicsim.workers.threads import bound_threads

COUNTED = 10_000
"""Most episodes that are counted."""
MARGIN, LINE, LETTER, TEXT_PX = 6, 14, 7, 0.36
PAPER, INK = 255, (30, 30, 30)


@dataclass(frozen=True, slots=True, kw_only=True)
class Preview:
    """What `magicsim dataset --preview` reports."""

    samples: int
    """Frames on the sheet."""
    shards: int
    """None are written."""
    failed: int
    """Frames that have no coarse answer."""
    seconds: float
    preview: str
    """The contact sheet."""
    statistics: dict[str, Any]


def preview_recipe(recipe: Recipe, out: Path, count: int, options: WorkerOptions) -> Preview:
    """Renders the most telling frame of some episodes, evenly spread, and writes sheet and statistics.

    Args:
        recipe: What to look at.
        out: Folder for `preview.png` and `preview.json`; may hold a dataset.
        count: How many episodes.
        options: Where to compute.

    Raises:
        ConfigError: Drawn values are not allowed together.
        OutputError: The folder cannot be written.
    """
    start = time.perf_counter()
    check_preview(out)
    episodes = draw_episodes(recipe)
    places = np.linspace(0, len(episodes) - 1, min(count, len(episodes))).round().astype(int)
    chosen = [episodes[int(place)] for place in places]
    images: dict[int, Frame] = {}
    metering = metering_scene(recipe, chosen[0])
    tasks = ((each.index, PreviewTask(scene=preview_scene(each), metering=metering)) for each in chosen)
    for outcome in run_tasks(preview_frame, tasks, options, prepare=bound_threads):
        if outcome.result is not None:
            images[outcome.key] = outcome.result
    cost = estimate(recipe, episodes, processes=options.workers)
    step = odd_step(len(episodes), COUNTED)
    counted = quality() if step == 1 else f"{quality()} Statistics of every {step}th episode."
    statistics = recipe_statistics(recipe, episodes[::step]) | {
        "preview": counted,
        "estimated_hours": round(cost.seconds(usable_cores()) / 3600, 3),
        "estimated_megabytes": round(cost.bytes / 1e6, 1),
    }
    camera = metering.rig.camera
    tiles = [(_enlarged(images.get(each.index)), captions(each)) for each in chosen]
    sheet = contact_sheet(tiles, ENLARGE * camera.rows, ENLARGE * camera.columns, note=quality())
    write_preview(out, cv2.imencode(".png", sheet[:, :, ::-1])[1].tobytes(), statistics)
    return Preview(
        samples=len(images),
        shards=0,
        failed=len(chosen) - len(images),
        seconds=round(time.perf_counter() - start, 3),
        preview=str(out / SHEET),
        statistics=statistics,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class PreviewTask:
    """One frame to render."""

    scene: SceneConfig
    metering: SceneConfig
    """The untouched sensor that its exposure is metered on."""


def preview_frame(task: PreviewTask) -> Frame:
    """The coarse frame of one episode, shape (rows, columns, 3)."""
    from magicsim.camera.exposure import expose, meter
    from magicsim.scenes.timeline import timeline
    from magicsim.simulation.plan import can_touch
    from magicsim.simulation.sensor import Sensor

    sensor, state = Sensor.for_scene(task.scene), timeline(task.scene)[0]
    deformation = sensor.deform(state, sensor.rest) if can_touch(state) else sensor.rest
    radiance, camera = sensor.radiance(state, deformation), task.scene.rig.camera
    exposure = meter(_untouched(task.metering.model_dump_json()), camera, task.metering.rig.lit)
    return expose(radiance, exposure, camera, seed=task.scene.seed, frame=0)


@lru_cache(maxsize=1)
def _untouched(scene: str) -> npt.NDArray[np.float32]:
    """Radiance of an untouched sensor, rendered once in each process."""
    from magicsim.scenes.timeline import UNTOUCHED
    from magicsim.simulation.sensor import Sensor

    sensor = Sensor.for_scene(SceneConfig.model_validate_json(scene))
    return sensor.radiance(UNTOUCHED, sensor.rest)


def captions(episode: DrawnEpisode) -> list[str]:
    """Lines below a frame."""
    state, thing = telling_state(episode.scene), episode.scene.object
    where = "no object"
    if state.gap_mm is not None:
        where = f"gap {state.gap_mm:.2f} mm" if state.gap_mm >= 0 else f"{-state.gap_mm:.2f} mm deep"
    return [f"{episode.index}: {episode.path_kind}", thing.kind if thing is not None else "", where]


def _enlarged(image: Frame | None) -> Frame | None:
    return None if image is None else image.repeat(ENLARGE, 0).repeat(ENLARGE, 1)


def contact_sheet(tiles: list[tuple[Frame | None, list[str]]], rows: int, columns: int, *, note: str = "") -> Frame:
    """Frames side by side with their captions and a note below, RGB; a cross stands for a frame that is missing."""
    across = math.ceil(math.sqrt(len(tiles) * 1.5))
    lines = max(len(text) for _, text in tiles)
    width, height = max(columns, 110) + MARGIN, rows + MARGIN + lines * LINE
    letters = max(20, (across * width) // LETTER)
    notes = textwrap.wrap(note, letters)
    tall = math.ceil(len(tiles) / across) * height + MARGIN
    sheet = np.full((tall + len(notes) * LINE, across * width + MARGIN, 3), PAPER, np.uint8)
    for line, words in enumerate(notes):
        _write(sheet, words, (MARGIN, tall + (line + 1) * LINE - 4))
    for number, (image, text) in enumerate(tiles):
        top, left = MARGIN + number // across * height, MARGIN + number % across * width
        if image is not None:
            sheet[top : top + rows, left : left + columns] = image
        else:
            cv2.line(sheet, (left, top), (left + columns, top + rows), INK, 1)
            cv2.line(sheet, (left + columns, top), (left, top + rows), INK, 1)
        for line, words in enumerate(text):
            _write(sheet, words, (left, top + rows + (line + 1) * LINE - 2))
    return sheet


def _write(sheet: Frame, words: str, at: tuple[int, int]) -> None:
    cv2.putText(sheet, words, at, cv2.FONT_HERSHEY_SIMPLEX, TEXT_PX, INK, 1, cv2.LINE_AA)
