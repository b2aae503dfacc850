"""The folder that a run of grasps grows in: a file an episode, whole or not there, and what they belong to."""

from pathlib import Path

import tomli_w
from pydantic import Field

from magicsim.config.documents import read_json
from magicsim.config.models import Config, validate
from magicsim.errors import OutputError
from magicsim.folder.hashing import sha256_of
from magicsim.folder.ledger import Ledger, is_begun
from magicsim.folder.listing import Listed
from magicsim.folder.result import names_in, output_errors, refuse_foreign, refuse_others
from magicsim.folder.sealing import is_sealed, sealed
from magicsim.task.settings import GraspConfig
from magicsim.workers.versions import changed_versions

INDEX, CONFIG, RESULTS, EPISODES = "task.json", "config.toml", "results.json", "episodes"
FRAMES_TABLE, EPISODES_TABLE = "frames.parquet", "episodes.parquet"


class TaskIndex(Config):
    """What a folder's episodes belong to."""

    schema_version: int = 1
    task: str = "grasp"
    config_hash: str
    """SHA-256 of what episodes depend on."""
    versions: dict[str, str]
    variant: str
    episodes: int
    is_complete: bool = False
    files: dict[str, str] = Field(default_factory=dict)
    """SHA-256 of every other file of a finished run."""
    sha256: str = ""
    """Hash of this index itself, see `magicsim.folder.sealing`."""


def check_folder(out: Path, *, resume: bool) -> None:
    """Refuses a folder that is not ours, or holds a run that nobody asked to go on with.

    Raises:
        OutputError: With what to do instead.
    """
    with output_errors(out):
        names = set(names_in(out))
        index = read_index(out)
    if index is None and not is_begun(out):
        refuse_others(out, names)
    if index is not None and not resume:
        state = "a" if index.is_complete else "an unfinished"
        msg = f"output folder '{out}' holds {state} run of a task already; --resume goes on with it"
        raise OutputError(msg)


def read_index(out: Path) -> TaskIndex | None:
    """The index of a folder, None where there is none.

    Raises:
        OutputError: It is not one that this version understands.
    """
    path = out / INDEX
    if not path.is_file():
        return None
    try:
        return validate(TaskIndex, read_json(path), source=INDEX)
    except (ValueError, OSError) as error:
        msg = f"'{path}' is not an index of a task: {error}"
        raise OutputError(msg) from None


def open_ledger(out: Path) -> Ledger:
    """What earlier runs wrote into a folder, which may hold nothing else.

    Raises:
        OutputError: It does, or something has changed since, and is named.
    """
    index = read_index(out)
    if index is not None and not is_sealed((out / INDEX).read_bytes()):
        refuse_foreign(out, [INDEX])
    known = {name: Listed(sha256=digest) for name, digest in (index.files if index is not None else {}).items()}
    if index is not None:
        known[INDEX] = Listed(sha256=sha256_of(out / INDEX))
    ledger = Ledger(out, known)
    ledger.refuse_foreign()
    return ledger


def refuse_another(out: Path, earlier: TaskIndex, now: TaskIndex) -> None:
    """Refuses to go on with another task's episodes.

    Raises:
        OutputError: With what differs.
    """
    if (earlier.task, earlier.config_hash) != (now.task, now.config_hash):
        msg = f"'{out}' holds another task (see its {CONFIG}); name another folder"
        raise OutputError(msg)
    changed = changed_versions(earlier.versions | {"variant": earlier.variant}, now.versions | {"variant": now.variant})
    if changed:
        msg = f"'{out}' was begun with another version of {', '.join(changed)}: its results would differ"
        raise OutputError(msg)


def write_index(ledger: Ledger, index: TaskIndex) -> None:
    """Replaces the index at once."""
    ledger.place(INDEX, sealed(index.model_dump(mode="json")))


def write_config(ledger: Ledger, config: GraspConfig) -> None:
    """Writes the task with everything in place."""
    text = tomli_w.dumps(config.model_dump(mode="json", exclude_none=True))
    ledger.place(CONFIG, f"# Settings of a task of magicsim, everything in place\n{text}".encode())


def episode_name(episode: int) -> str:
    """Name of an episode's file below the folder."""
    return f"{EPISODES}/{episode:05d}.json"
