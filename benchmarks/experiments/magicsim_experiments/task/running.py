"""Many episodes into one folder: each is written whole, and a run that was stopped goes on where it was."""

import io
from collections.abc import Callable, Sequence
from dataclasses import asdict
from itertools import pairwise
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from magicsim.arrays import Frame
from magicsim.config.models import validate
from magicsim.detectors.profile import load_profile
from magicsim.errors import ConfigError
from magicsim.light.variant import activate_variant
from magicsim.robot.gripper import Gripper
from magicsim.robot.live import MAX_SEED
from magicsim.scenes.rig import in_room
from magicsim.scenes.scene import SceneConfig, load_scene
from magicsim_experiments.task.episode import GraspFrame, GraspRecord, play
from magicsim_experiments.task.growing import (
    EPISODES_TABLE,
    FRAMES_TABLE,
    RESULTS,
    Played,
    Progress,
    as_json,
    as_parquet,
    grow,
    resolved,
)
from magicsim_experiments.task.settings import GraspConfig, Item, load_item
from magicsim_experiments.task.story import draw_story
from magicsim_experiments.task.summary import GraspOutcome, TaskSummary, judge_episode, summarise
from magicsim_experiments.task.world import World, build_gripper, check_room_for

BAR_PX = 46
"""Height of the text below each image."""
COLUMNS, MOST = 8, 24
"""Images in a row of a contact sheet, and in all of it."""
SCALE = 0.35


def captioned(image: Frame, row: GraspFrame) -> Frame:
    """An image with its line of text."""
    lines = (
        f"{row.time_s:5.2f} s  {row.stage}" + (f"  {row.event}" if row.event else ""),
        f"E {row.entropy:.1f}  C {row.correlation:.2f}  S {row.similarity:.2f}  {max(row.upper_n, row.lower_n):.1f} N",
    )
    bar = np.full((BAR_PX, image.shape[1], 3), 255, np.uint8)
    for number, line in enumerate(lines):
        cv2.putText(bar, line, (4, 18 + 20 * number), cv2.FONT_HERSHEY_SIMPLEX, SCALE, (20, 20, 20), 1, cv2.LINE_AA)
    return np.concatenate([image, bar])


def contact_sheet(frames: Sequence[tuple[Frame, GraspFrame]]) -> bytes:
    """A JPEG with the frames in which something changes, and others evenly between them, in order."""
    chosen = _telling([row for _, row in frames])
    tiles = [np.pad(captioned(*frames[k]), ((0, 6), (0, 6), (0, 0)), constant_values=255) for k in chosen]
    tiles += [np.full_like(tiles[0], 255)] * (-len(tiles) % min(COLUMNS, len(tiles)))
    across = min(COLUMNS, len(tiles))
    sheet = np.vstack([np.hstack(tiles[k : k + across]) for k in range(0, len(tiles), across)])
    encoded = cv2.imencode(".jpg", np.ascontiguousarray(sheet[:, :, ::-1]), [cv2.IMWRITE_JPEG_QUALITY, 80])[1]
    return bytes(encoded.tobytes())


def film(frames: Sequence[tuple[Frame, GraspFrame]], *, frames_per_second: float) -> bytes:
    """An animated WebP of an episode, at the rate of its frames [1/s]."""
    first, *others = (Pillow.fromarray(captioned(image, row)) for image, row in frames)
    file = io.BytesIO()
    first.save(
        file, format="WEBP", save_all=True, append_images=others, duration=round(1000 / frames_per_second), quality=40,
        method=4, loop=0,
    )  # fmt: skip
    return file.getvalue()


def _telling(rows: Sequence[GraspFrame]) -> npt.NDArray[np.int64]:
    """Numbers of the frames of a contact sheet."""
    marked = [0, len(rows) - 1]
    for number, (before, row) in enumerate(pairwise(rows), 1):
        if row.stage != before.stage or row.event or row.light != before.light:
            marked.append(number)
    chosen = sorted(set(marked))[:MOST]
    while len(chosen) < min(MOST, len(rows)):
        gaps = np.diff(chosen)
        widest = int(gaps.argmax())
        if gaps[widest] < 2:  # noqa: PLR2004 - neighbours
            break
        chosen = sorted([*chosen, chosen[widest] + int(gaps[widest]) // 2])
    return np.array(chosen)


NOISE = 31
"""Keeps the seeds of the frames' noise apart from others."""


def task_scene(config: GraspConfig, item: Item) -> SceneConfig:
    """The fingers and what is between them."""
    scene = load_scene("grip", [f"design={config.design}", f"rig={config.rig}", *config.scene])
    if scene.design.is_opaque:
        msg = f"design = {config.design} is not allowed with task grasp, which sees items come: design.coat is opaque"
        raise ConfigError(msg)
    contact = scene.contact.model_copy(update={"friction": item.friction})
    rig = in_room(scene.rig, config.room)
    values = scene.model_dump() | {
        "object": item.object.model_dump(), "rig": rig.model_dump(), "contact": contact.model_dump(),
        "seed": config.seed, "frames_per_second": config.frames_per_second,
    }  # fmt: skip
    return validate(SceneConfig, values, source="task grasp")


class GraspPlayer:
    """Builds a gripper for the item of an episode, and plays further ones of the item with it."""

    def __init__(self, config: GraspConfig) -> None:
        """Checks everything that a run needs before it begins."""
        self.config, self.profile = config, load_profile(config.detector)
        self.items = {name: load_item(name) for name in config.items}
        self._scenes = {name: task_scene(config, item) for name, item in self.items.items()}
        for name, item in self.items.items():
            check_room_for(item, name, config)
        self._built: tuple[str, Gripper] | None = None

    def settings(self) -> dict[str, Any]:
        """What episodes depend on, with the content of every file."""
        return resolved(self.config, items=self.items, scenes=self._scenes, profile=asdict(self.profile))

    def play(
        self, episode: int, *, seen: Callable[[Frame, GraspFrame], None] | None = None
    ) -> tuple[GraspRecord, GraspOutcome]:
        """One episode, and what became of it."""
        config, story = self.config, draw_story(self.config, episode)
        seed = int(np.random.SeedSequence([config.seed, NOISE, episode]).generate_state(1)[0] % MAX_SEED)
        world = World(self._gripper(story.item), self.items[story.item], story, config)
        recorded = play(world, self.profile, episode=episode, seed=seed, seen=seen)
        item, rate = self.items[story.item], config.frames_per_second
        return recorded, judge_episode(recorded, item, story, frames_per_second=rate)

    def order(self, episodes: int) -> list[int]:
        """Numbers of all episodes, those of an item one after the other: one gripper at a time is alive.

        Each further sensor makes every frame slower, for the renderer prepares its kernels for all shapes that there
        are.
        """
        items = list(self.items)
        return sorted(range(episodes), key=lambda number: (items.index(draw_story(self.config, number).item), number))

    def _gripper(self, item: str) -> Gripper:
        if self._built is None or self._built[0] != item:
            if self._built is not None:
                self._built[1].release()
            self._built = (item, build_gripper(self._scenes[item], self.config))
        self._built[1].reset()
        return self._built[1]


def run_grasps(
    config: GraspConfig, out: Path, *, episodes: int, resume: bool = False, with_film: bool = False,
    progress: Progress | None = None, variant: Callable[[], str] = activate_variant,
) -> TaskSummary:  # fmt: skip
    """Plays episodes, or what an earlier run left of them, and writes their folder.

    Args:
        episodes: How many; a finished folder grows by more.
        resume: Whether to go on with the run in the folder.
        with_film: Whether to keep a film and a contact sheet of each episode that is played now.
        progress: Told how far it is: episodes done, all of them, a note.

    Raises:
        MagicsimError: The task cannot be played, or the folder is not ours or holds another task.
    """
    stage = GraspPlayer(config)

    def played(episode: int) -> Played:
        frames: list[tuple[Frame, GraspFrame]] = []
        recorded, outcome = stage.play(episode, seen=(lambda *each: frames.append(each)) if with_film else None)
        values = {"outcome": asdict(outcome), "rows": [asdict(row) for row in recorded.rows]}
        pictures = {
            f"films/{episode:05d}.jpg": contact_sheet(frames),
            f"films/{episode:05d}.webp": film(frames, frames_per_second=config.frames_per_second),
        } if with_film else {}  # fmt: skip
        return values, pictures

    def concluded(episodes: Sequence[dict[str, Any]]) -> tuple[TaskSummary, dict[str, bytes]]:
        found = [GraspOutcome(**each["outcome"]) for each in episodes]
        rows = [row for each in episodes for row in each["rows"]]
        summary = summarise(found, rows, detector=config.detector, room=config.room, out=str(out))
        return summary, {
            FRAMES_TABLE: as_parquet(rows),
            EPISODES_TABLE: as_parquet([_flat(each["outcome"]) for each in episodes]),
            RESULTS: as_json(asdict(summary)),
        }

    return grow(
        out, stage.settings(), played, concluded, task="grasp", episodes=episodes, order=stage.order(episodes),
        resume=resume, progress=progress, variant=variant,
    )  # fmt: skip


def _flat(outcome: dict[str, Any]) -> dict[str, Any]:
    """An outcome as a row: seconds in each stage as columns."""
    times = {f"seconds_{stage.lower()}": value for stage, value in outcome["seconds_in"].items()}
    return {name: value for name, value in outcome.items() if name != "seconds_in"} | times
