"""A run of episodes into a folder: each is written whole, and a run that was stopped goes on where it was."""

import hashlib
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pyarrow as pa
from PIL import Image

from magicsim.arrays import Frame
from magicsim.config.models import Config
from magicsim.config.named_files import file_hashes
from magicsim.config.program import versions
from magicsim.dataset.shard import parquet_bytes
from magicsim.errors import OutputError
from magicsim.folder.ledger import RESUMABLE
from magicsim.folder.target import output_errors, sole_writer
from magicsim.light.variant import activate_variant
from magicsim.scenes.scene import SceneConfig
from magicsim.workers.run_folder import RunFolder, RunIndex
from magicsim_experiments.task.settings import Item


def resolved(
    config: Config, *, items: Mapping[str, Item], scenes: Mapping[str, SceneConfig], profile: Mapping[str, Any]
) -> dict[str, Any]:
    """Settings of a task, and under `resolved` what their names stand for.

    Args:
        scenes: Fingers and item, by the item's name; they differ in what the item says alone.
        profile: What reads the frames; empty where the settings say it by themselves.

    Returns:
        Plain values, as TOML and JSON take them.
    """
    fingers = next(iter(scenes.values())).model_dump(mode="json", exclude={"object": True, "contact": {"friction"}})
    files = {name: file_hashes(scene.model_dump(mode="json")) for name, scene in scenes.items()}
    content = {
        "profile": dict(profile), "items": {name: item.model_dump(mode="json") for name, item in items.items()},
        "fingers": fingers, "sha256": {name: found for name, found in files.items() if found},
    }  # fmt: skip
    return plain_values(config.model_dump(mode="json") | {"resolved": content})


def resolved_scene(scene: SceneConfig) -> dict[str, Any]:
    """A scene with everything in place, and the SHA-256 of every file that it names."""
    values = scene.model_dump(mode="json")
    found = file_hashes(values)
    return {"scene": values} | ({"sha256": found} if found else {})


def plain_values(settings: Mapping[str, Any]) -> dict[str, Any]:
    """Settings as TOML and JSON take them: without keys that have no value."""
    plain: dict[str, Any] = _without_none(settings)
    return plain


def digest_of(settings: Mapping[str, Any]) -> str:
    """SHA-256 of a run's settings, so that a folder is not continued with another task."""
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()


def _without_none(value: Any) -> Any:  # noqa: ANN401 - plain values of any kind
    """Tables without keys that have no value, which TOML cannot say."""
    if isinstance(value, Mapping):
        return {key: _without_none(each) for key, each in value.items() if each is not None}
    return [_without_none(each) for each in value] if isinstance(value, list | tuple) else value


INDEX, RESULTS, EPISODES = "task.json", "results.json", "episodes"
FRAMES_TABLE, EPISODES_TABLE = "frames.parquet", "episodes.parquet"


class TaskIndex(RunIndex):
    """What a folder's episodes belong to."""

    task: str = "grasp"
    episodes: int


FOLDER = RunFolder(
    index=INDEX, model=TaskIndex, noun="task", content="run of a task",
    title="Settings of a task of magicsim, everything in place",
)  # fmt: skip


def episode_name(episode: int) -> str:
    """Name of an episode's file below the folder."""
    return f"{EPISODES}/{episode:05d}.json"


SummaryT = TypeVar("SummaryT")
Progress = Callable[[float, float, str], None]
"""Takes episodes done, all of them, and a note."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Played:
    """What an episode leaves."""

    values: Mapping[str, Any]
    """Content of the episode's file, as JSON."""
    pictures: Mapping[str, bytes] = field(default_factory=dict)
    """Further files by their names below the folder."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Run:
    """How a task's episodes are kept."""

    task: str
    episodes: int
    order: Iterable[int]
    """Numbers of all episodes in the order in which they are played."""
    resume: bool = False
    packages: Mapping[str, str] = field(default_factory=dict)
    """Versions that results depend on, beside those of the program."""
    progress: Progress | None = None
    variant: Callable[[], str] = activate_variant
    """Names the renderer's variant, and makes it active."""


def grow(
    out: Path, settings: Mapping[str, Any], run: Run, play: Callable[[int], Played],
    conclude: Callable[[Sequence[dict[str, Any]]], tuple[SummaryT, Mapping[str, bytes]]],
) -> SummaryT:  # fmt: skip
    """Plays episodes, or what an earlier run left of them, and writes their folder.

    Args:
        settings: What episodes depend on, see `magicsim_experiments.task.growing`; they are written beside the result.
        conclude: The summary, and the result's files by name, from the content of all episodes in the order of their
            numbers.

    Raises:
        OutputError: The folder is not ours, holds another run or more episodes, or cannot be written.
    """
    FOLDER.check(out, resume=run.resume)
    with output_errors(out, then=RESUMABLE), sole_writer(out):
        out.mkdir(parents=True, exist_ok=True)
        ledger = FOLDER.open_ledger(out)
        index = TaskIndex(
            task=run.task, config_hash=digest_of(settings), variant=run.variant(), episodes=run.episodes,
            versions=versions("magicsim_experiments") | dict(run.packages),
        )  # fmt: skip
        earlier = FOLDER.read_index(out)
        if earlier is not None:
            FOLDER.refuse_another(out, earlier, index)
        _refuse_fewer(out, ledger.names(), run.episodes)
        FOLDER.write_config(ledger, settings)
        FOLDER.write_index(ledger, index)
        for done, episode in enumerate(run.order):
            if run.progress is not None:
                run.progress(done, run.episodes, f"episode {episode}")
            if ledger.is_intact(episode_name(episode)):
                continue
            played = play(episode)
            for name, content in played.pictures.items():
                ledger.place(name, content)
            ledger.place(episode_name(episode), as_json(played.values, indent=None))
        summary, results = conclude([_read(out, episode) for episode in range(run.episodes)])
        for name, content in results.items():
            ledger.place(name, content)
        files = {name: ledger.listed(name).sha256 for name in ledger.names() if name != INDEX}
        FOLDER.write_index(ledger, index.model_copy(update={"is_complete": True, "files": files}))
        ledger.close()
    return summary


def as_json(values: Mapping[str, Any], *, indent: int | None = 1) -> bytes:
    """Values as a JSON file's content."""
    return (json.dumps(values, allow_nan=False, indent=indent) + "\n").encode()


def as_parquet(rows: list[dict[str, Any]]) -> bytes:
    """Rows as a Parquet file's content."""
    return parquet_bytes(pa.Table.from_pylist(rows))


def as_png(rows: Sequence[Frame]) -> bytes:
    """Images above each other as a PNG file's content."""
    file = io.BytesIO()
    Image.fromarray(np.concatenate(rows)).save(file, format="PNG")
    return file.getvalue()


def _refuse_fewer(out: Path, names: Iterable[str], episodes: int) -> None:
    last = max((int(Path(name).stem) for name in names if Path(name).parent.as_posix() == EPISODES), default=-1)
    if last >= episodes:
        msg = f"'{out}' holds episodes up to number {last} already: it goes on with {last + 1} or more, not {episodes}"
        raise OutputError(msg)


def _read(out: Path, episode: int) -> dict[str, Any]:
    path = out / episode_name(episode)
    try:
        found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        msg = f"'{path}' is not an episode of a task: {error}; without it, --resume plays it again"
        raise OutputError(msg) from None
    return found
