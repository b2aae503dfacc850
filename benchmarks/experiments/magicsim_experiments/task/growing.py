"""A run of episodes into a folder: each is written whole, and a run that was stopped goes on where it was."""

import hashlib
import importlib.metadata
import io
import json
from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import pyarrow as pa
from matplotlib.figure import Figure
from PIL import Image

from magicsim.arrays import Frame
from magicsim.config.models import Config
from magicsim.config.named_files import file_hashes
from magicsim.config.program import versions
from magicsim.dataset.shard import parquet_bytes
from magicsim.errors import OutputError
from magicsim.folder.ledger import RESUMABLE
from magicsim.folder.target import output_errors, sole_writer
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
    left_out: Any = {"object": True, "contact": {"friction"}}
    fingers = next(iter(scenes.values())).model_dump(mode="json", exclude_none=True, exclude=left_out)
    files = {name: file_hashes(scene.model_dump(mode="json")) for name, scene in scenes.items()}
    content = {
        "profile": dict(profile),
        "items": {name: item.model_dump(mode="json", exclude_none=True) for name, item in items.items()},
        "fingers": fingers, "sha256": {name: found for name, found in files.items() if found},
    }  # fmt: skip
    return config.model_dump(mode="json", exclude_none=True) | {"resolved": content}


def digest_of(settings: Mapping[str, Any]) -> str:
    """SHA-256 of a run's settings, so that a folder is not continued with another task."""
    return hashlib.sha256(json.dumps(settings, sort_keys=True).encode()).hexdigest()


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
Played = tuple[Mapping[str, Any], Mapping[str, bytes]]
"""What an episode leaves: the content of its file, as JSON, and further files by their names below the folder."""


def grow(
    out: Path, settings: Mapping[str, Any], play: Callable[[int], Played],
    conclude: Callable[[Sequence[dict[str, Any]]], tuple[SummaryT, Mapping[str, bytes]]], *, task: str, episodes: int,
    order: Iterable[int], resume: bool, progress: Progress | None, variant: Callable[[], str],
    packages: Sequence[str] = (),
) -> SummaryT:  # fmt: skip
    """Plays episodes, or what an earlier run left of them, and writes their folder.

    Args:
        settings: What episodes depend on; they are written beside the result.
        conclude: The summary, and the result's files by name, from the content of all episodes in the order of their
            numbers.
        order: Numbers of all episodes in the order in which they are played.
        variant: Names the renderer's variant, and makes it active.
        packages: Those that results depend on, beside the program.

    Raises:
        OutputError: The folder is not ours, holds another run or more episodes, or cannot be written.
    """
    FOLDER.check(out, resume=resume)
    with output_errors(out, then=RESUMABLE), sole_writer(out):
        out.mkdir(parents=True, exist_ok=True)
        ledger = FOLDER.open_ledger(out)
        index = TaskIndex(
            task=task, config_hash=digest_of(settings), variant=variant(), episodes=episodes,
            versions=versions("magicsim_experiments") | {name: importlib.metadata.version(name) for name in packages},
        )  # fmt: skip
        earlier = FOLDER.read_index(out)
        if earlier is not None:
            FOLDER.refuse_another(out, earlier, index)
        _refuse_fewer(out, ledger.names(), episodes)
        FOLDER.write_config(ledger, settings)
        FOLDER.write_index(ledger, index)
        for done, episode in enumerate(order):
            if progress is not None:
                progress(done, episodes, f"episode {episode}")
            if ledger.is_intact(episode_name(episode)):
                continue
            values, pictures = play(episode)
            for name, content in pictures.items():
                ledger.place(name, content)
            ledger.place(episode_name(episode), as_json(values, indent=None))
        summary, results = conclude([_read(out, episode) for episode in range(episodes)])
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


def as_png(picture: Frame | Figure) -> bytes:
    """An image, or a drawing, as a PNG file's content."""
    file = io.BytesIO()
    if isinstance(picture, Figure):
        picture.savefig(file, format="png", dpi=110, metadata={"Software": None})
    else:
        Image.fromarray(picture).save(file, format="PNG")
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
