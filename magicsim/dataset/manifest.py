"""What a dataset's folder holds, with the hash of every file: `manifest.json`."""

import json
from pathlib import Path
from typing import Literal

from magicsim.config import Config, validate
from magicsim.errors import OutputError
from magicsim.workers.folder import place

MANIFEST = "manifest.json"


class ShardEntry(Config):
    """One finished shard."""

    file: str
    split: str
    episodes: tuple[int, ...]
    rows: int
    size: int
    """Bytes."""
    sha256: str


class FailedEpisode(Config):
    """One episode that has no rows."""

    episode: int
    kind: Literal["refused", "error", "crash", "timeout"]
    """`refused` is final; what else went wrong is tried again on resuming."""
    message: str


class Manifest(Config):
    """Index of a dataset; holds nothing that differs from run to run."""

    schema_version: Literal[1] = 1
    config_hash: str
    """SHA-256 of the recipe without its number of episodes."""
    versions: dict[str, str]
    variant: str
    seed: int
    episodes: int
    """How many the recipe asks for."""
    rows: int = 0
    is_complete: bool = False
    """Whether every episode is in a shard or failed."""
    shards: tuple[ShardEntry, ...] = ()
    """Finished shards, by name."""
    failed: tuple[FailedEpisode, ...] = ()
    """By episode."""
    files: dict[str, str]
    """SHA-256 of every other file."""


def read_manifest(folder: Path) -> Manifest | None:
    """The manifest of a folder, None where there is none.

    Raises:
        OutputError: It is not a manifest that this version understands.
    """
    path = folder / MANIFEST
    if not path.is_file():
        return None
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        return validate(Manifest, data, source=MANIFEST)
    except (ValueError, OSError) as error:
        msg = f"'{path}' is not a manifest of magicsim: {error}"
        raise OutputError(msg) from None


def write_manifest(folder: Path, manifest: Manifest) -> None:
    """Replaces the manifest of a folder at once."""
    place(folder / MANIFEST, (json.dumps(manifest.model_dump(mode="json"), indent=1) + "\n").encode())
