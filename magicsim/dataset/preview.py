"""A look at a recipe before a long run: a contact sheet of coarse frames, and statistics."""

import hashlib
import json
import math
import textwrap
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from magicsim.arrays import Frame
from magicsim.dataset.assembly import split_of
from magicsim.dataset.manifest import PREVIEW_FILES, SHEET, STATISTICS
from magicsim.dataset.recipes.draw import DrawnEpisode, draw_episodes
from magicsim.dataset.recipes.estimate import estimate, odd_step
from magicsim.dataset.recipes.recipe import Recipe
from magicsim.dataset.rows import at_force
from magicsim.folder.listing import is_sealed, sealed, sha256_of
from magicsim.folder.result import result_file
from magicsim.folder.target import output_errors, refuse_foreign
from magicsim.frame_class import LIGHT_TOUCH, FrameClass, classify_frame, frame_label
from magicsim.notebook.screen import on_screen
from magicsim.scenes.scene import OutputSettings, SceneConfig
from magicsim.scenes.timeline import UNTOUCHED, FrameState, timeline
from magicsim.workers.attempt import WorkerOptions, bound_threads, usable_cores
from magicsim.workers.tasks import run_tasks

SAMPLES, PARTICLES = 3, 10_000
SHRINK, ENLARGE = 4, 2
"""Factors by which a preview is rendered with fewer rows and columns, and shown larger."""
SPACING_MM = 2.0
"""Lattice of a preview: forces are rough, contact is where it will be."""
COUNTED = 10_000
"""Most episodes that are counted."""
QUALITY = (
    f"Preview: 1/{SHRINK} of the pixels a side, {SAMPLES} samples, {PARTICLES:,} particles, lattice nodes "
    f"{SPACING_MM:g} mm apart, no friction, exposure of the sensor without tolerances."
)
"""What a preview leaves out, in a line."""
MARGIN, LINE, LETTER, TEXT_PX = 6, 14, 7, 0.36
PAPER, INK = 255, (30, 30, 30)
SHEETS = "sheet_sha256"
"""Key of the statistics: hashes of the sheet and, in case a run is killed between both files, of the one before."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Preview:
    """What `magicsim dataset --preview` reports."""

    samples: int
    """Frames on the sheet."""
    shards: int
    failed: int
    """Frames that have no coarse answer."""
    seconds: float
    preview: str
    """The contact sheet."""
    statistics: dict[str, Any]


def preview_recipe(recipe: Recipe, out: Path, count: int, options: WorkerOptions) -> Preview:
    """Renders the most telling frame of some episodes, evenly spread, and writes `preview.png` and `preview.json`.

    The folder may hold a dataset; an `OutputError` says that it cannot be written.
    """
    start = time.perf_counter()
    check_preview(out)
    episodes = draw_episodes(recipe)
    places = np.linspace(0, len(episodes) - 1, min(count, len(episodes))).round().astype(int)
    chosen = [episodes[int(place)] for place in places]
    metering = metering_scene(recipe, chosen[0])
    tasks = ((each.index, (replace(each, scene=preview_scene(each)), metering)) for each in chosen)
    outcomes = run_tasks(preview_frame, tasks, options, prepare=bound_threads)
    images = {
        each.key: each.result.repeat(ENLARGE, 0).repeat(ENLARGE, 1) for each in outcomes if each.result is not None
    }
    cost = estimate(recipe, episodes, processes=options.workers)
    step = odd_step(len(episodes), COUNTED)
    counted = QUALITY if step == 1 else f"{QUALITY} Statistics of every {step}th episode."
    statistics = recipe_statistics(recipe, episodes[::step]) | {
        "preview": counted,
        "estimated_hours": round(cost.seconds(usable_cores()) / 3600, 3),
        "estimated_megabytes": round(cost.bytes / 1e6, 1),
    }
    window = metering.rig.camera.window
    tiles = [(images.get(each.index), captions(each)) for each in chosen]
    sheet = contact_sheet(tiles, ENLARGE * window.rows, ENLARGE * window.columns, note=QUALITY)
    write_preview(out, cv2.imencode(".png", sheet[:, :, ::-1])[1].tobytes(), statistics)
    return Preview(
        samples=len(images),
        shards=0,
        failed=len(chosen) - len(images),
        seconds=round(time.perf_counter() - start, 3),
        preview=str(out / SHEET),
        statistics=statistics,
    )


def preview_frame(scenes: tuple[DrawnEpisode, SceneConfig]) -> Frame:
    """The coarse frame of one episode as a screen shows it, shape (rows, columns, 3)."""
    from magicsim.camera.exposure import expose, meter
    from magicsim.simulation.sensor import Sensor

    episode, metering = scenes
    scene = at_force(episode)[0].scene
    sensor, state = Sensor.for_scene(scene), timeline(scene)[0]
    deformation = sensor.deform(state, sensor.rest) if state.can_touch else sensor.rest
    radiance, camera = sensor.radiance(state, deformation), scene.rig.camera
    exposure = meter(_untouched(metering.model_dump_json()), camera, metering.lit)
    return on_screen(expose(radiance, exposure, camera, seed=scene.seed, frame=0), gamma=camera.gamma)


@lru_cache(maxsize=1)
def _untouched(scene: str) -> npt.NDArray[np.float32]:
    """Radiance of an untouched sensor, rendered once in each process."""
    from magicsim.simulation.sensor import Sensor

    sensor = Sensor.for_scene(SceneConfig.model_validate_json(scene))
    return sensor.radiance(UNTOUCHED, sensor.rest)


def captions(episode: DrawnEpisode) -> list[str]:
    """Lines below a frame."""
    state, indenter = telling_state(episode.scene), episode.scene.object
    where = "no object"
    if state.gap_mm is not None:
        where = f"gap {state.gap_mm:.2f} mm" if state.gap_mm >= 0 else f"{-state.gap_mm:.2f} mm deep"
        if state.gap_mm < 0 and episode.force_n is not None:
            where = f"up to {episode.force_n:.2g} N"
    return [f"{episode.index}: {episode.path_kind}", indenter.kind if indenter is not None else "", where]


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


def recipe_statistics(recipe: Recipe, episodes: Sequence[DrawnEpisode]) -> dict[str, Any]:
    """Counts of episodes and frames by what they show, and the spread of every drawn value.

    The class of a frame supposes that what is pressed touches.
    """
    frames: Counter[str] = Counter()
    for episode in episodes:
        frames["Reference"] += recipe.references
        frames.update(_class(state, by_force=episode.force_n is not None) for state in timeline(episode.scene))
    drawn: dict[str, list[float]] = {}
    for episode in episodes:
        for name, value in episode.values.items():
            drawn.setdefault(name, []).append(value)
    kinds = [episode.scene.object.kind if episode.scene.object is not None else "none" for episode in episodes]
    return {
        "episodes": len(episodes),
        "frames": sum(frames.values()),
        "sensors": len({episode.sensor for episode in episodes}),
        "frames_by_class": dict(sorted(frames.items())),
        "episodes_by_path": dict(sorted(Counter(episode.path_kind for episode in episodes).items())),
        "episodes_by_object": dict(sorted(Counter(kinds).items())),
        "episodes_by_split": dict(sorted(Counter(split_of(recipe, each.index) for each in episodes).items())),
        "drawn": {name: _spread(drawn[name]) for name in sorted(drawn)},
    }


def _class(state: FrameState, *, by_force: bool) -> str:
    touching = state.gap_mm is not None and state.gap_mm < 0
    if touching and by_force:  # how deep, is known once it is pressed
        return f"{FrameClass.CONTACT} or {LIGHT_TOUCH}"
    found = classify_frame(gap_mm=state.gap_mm, force_n=float(touching), light_on=state.flashlight)
    return frame_label(found, touches=touching) or "between"


def _spread(values: list[float]) -> dict[str, float]:
    low, middle, high = np.quantile(values, [0, 0.5, 1]).round(6).tolist()
    return {"count": len(values), "min": low, "median": middle, "max": high}


def telling_state(scene: SceneConfig) -> FrameState:
    """The last of the deepest (or nearest) states, or the middle one without an object."""
    states = timeline(scene)
    near = [state for state in states if state.gap_mm is not None]
    if not near:
        return states[len(states) // 2]
    deepest = min(state.gap_mm for state in near if state.gap_mm is not None)
    return [state for state in near if state.gap_mm == deepest][-1]


def preview_scene(episode: DrawnEpisode) -> SceneConfig:
    """One coarse frame of an episode: small, without friction, without the anchor that makes frames clean."""
    state = telling_state(episode.scene)
    keyframe = {"frame": 0, "flashlight": state.flashlight, "light_x_mm": state.light_x_mm}
    if state.gap_mm is not None:
        keyframe |= {name: getattr(state, name) for name in ("gap_mm", "x_mm", "y_mm", "twist_deg")}
    return _coarse(episode.scene.model_dump() | {"keyframes": [keyframe]})


def metering_scene(recipe: Recipe, episode: DrawnEpisode) -> SceneConfig:
    """The untouched sensor without tolerances, as coarse, which the exposure of all previews is metered on."""
    own = {"design": recipe.design.model_dump(), "rig": recipe.rig.model_dump(), "object": None, "seed": recipe.seed}
    return _coarse(episode.scene.model_dump() | own | {"keyframes": [{"frame": 0}]})


def _coarse(data: dict[str, Any]) -> SceneConfig:
    camera, lattice, render = data["rig"]["camera"], data["design"]["lattice"], data["render"]
    camera |= {"compression": None, "region_px": None}  # blocks of 8 pixels are large here; whole images are shown
    camera |= {"rows": max(8, camera["rows"] // SHRINK), "columns": max(8, camera["columns"] // SHRINK)}
    camera["principal_offset_px"] = tuple(each / SHRINK for each in camera["principal_offset_px"])
    lattice |= {"spacing_mm": max(SPACING_MM, lattice["spacing_mm"] or 0.0), "cells_across": 0}
    samples, particles = min(SAMPLES, render["samples"]), min(PARTICLES, render["particles"])
    render |= {"samples": samples, "particles": particles, "anchor_samples": 0}
    data["contact"]["friction"] = 0.0
    data["output"] = OutputSettings.nothing()
    return SceneConfig.model_validate(data | {"references": 0})


def check_preview(out: Path) -> None:
    """Refuses (`OutputError`) to replace a picture or a file of that name that magicsim did not write."""
    with output_errors(out):
        refuse_foreign(out, changed_preview(out))


def changed_preview(out: Path) -> list[str]:
    """Names of a folder's preview files that are not as they were written."""
    sheet, statistics = out / SHEET, out / STATISTICS
    if not statistics.exists():
        return [SHEET] if sheet.exists() else []
    if not is_sealed(statistics.read_bytes()):
        return [name for name in sorted(PREVIEW_FILES) if (out / name).exists()]
    known = json.loads(statistics.read_bytes()).get(SHEETS, [])
    return [SHEET] if sheet.exists() and sha256_of(sheet) not in known else []


def write_preview(out: Path, sheet: bytes, statistics: Mapping[str, Any]) -> None:
    """Writes both files, each whole or not at all, or raises an `OutputError`, see `check_preview`."""
    check_preview(out)
    hashes = [hashlib.sha256(sheet).hexdigest()]
    if (out / SHEET).exists():
        hashes.append(sha256_of(out / SHEET))
    with result_file(out / STATISTICS) as partial:
        partial.write_bytes(sealed({**statistics, SHEETS: hashes}))
    with result_file(out / SHEET) as partial:
        partial.write_bytes(sheet)
