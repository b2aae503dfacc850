"""What a dataset's folder holds, with the hash of every file: `manifest.json`; `recorded.json` of a real sensor's."""

import hashlib
from collections.abc import Iterator, Mapping
from pathlib import Path, PurePosixPath
from typing import Annotated, Literal, Self

from pydantic import Field

from magicsim.config.documents import read_json
from magicsim.config.models import Config, validate
from magicsim.errors import MagicsimError, OutputError
from magicsim.folder.ledger import WORK, Ledger
from magicsim.folder.listing import Listed
from magicsim.workers.run_folder import RunFolder, RunIndex

MANIFEST, RECORDED = "manifest.json", "recorded.json"
CONFIG, CARD, CALIBRATION, SENSORS = "config.toml", "README.md", "calibration.json", "sensors.parquet"
SHEET, STATISTICS = "preview.png", "preview.json"
PREVIEW_FILES = frozenset({SHEET, STATISTICS})
"""Files of a preview, which may stand beside; they answer for each other."""
STAGED = f"{WORK}/episode-*.parquet"
"""Finished episodes that wait for their shard, by number."""


class ShardEntry(Config):
    """One finished shard."""

    file: str
    split: str
    episodes: tuple[int, ...]
    rows: int
    size: int
    """Bytes."""
    sha256: str

    @classmethod
    def of(cls, ledger: Ledger, file: str, *, split: str, episodes: tuple[int, ...], rows: int) -> Self:
        """The entry of a file that a ledger has written."""
        written = ledger.listed(file)
        size = written.size or 0
        return cls(file=file, split=split, episodes=episodes, rows=rows, size=size, sha256=written.sha256)

    @property
    def listed(self) -> Listed:
        """What the file was when it was written."""
        return Listed(sha256=self.sha256, size=self.size)


class FailedEpisode(Config):
    """One episode that has no rows."""

    episode: int
    kind: Literal["refused", "error", "crash", "timeout"]
    """`refused` is final; what else went wrong is tried again on resuming."""
    message: str


class Manifest(RunIndex):
    """Index of a dataset; holds nothing that differs from run to run."""

    seed: int
    episodes: int
    """How many the recipe asks for."""
    rows: int = 0
    shards: tuple[ShardEntry, ...] = ()
    """Finished shards, by name."""
    failed: tuple[FailedEpisode, ...] = ()
    """By episode."""

    def _problems(self) -> Iterator[str | None]:
        for name in (*self.files, *(entry.file for entry in self.shards)):
            path = PurePosixPath(name)
            if path.is_absolute() or ".." in path.parts or not path.name:
                yield f"file = '{name}' is not allowed: must be a path below the dataset's folder"

    def constants(self) -> dict[str, str]:
        """Columns that say in every row of the dataset what made it."""
        made_by = ", ".join(f"{name} {version}" for name, version in self.versions.items())
        return {"config_hash": self.config_hash, "version": made_by}

    def listed(self) -> dict[str, Listed]:
        """What every other file was when it was written, by name."""
        return super().listed() | {entry.file: entry.listed for entry in self.shards}


FOLDER = RunFolder(
    index=MANIFEST, model=Manifest, noun="dataset", content="dataset", beside=PREVIEW_FILES,
    other=f"a dataset of another recipe (see its {CONFIG}, and the files that it names)",
    is_worth_keeping=lambda out, index: bool(index.shards or index.failed) or any(out.glob(STAGED)),
)  # fmt: skip
read_manifest = FOLDER.read_index


def known_manifest(folder: Path) -> Manifest:
    """The manifest of a folder; `OutputError` where it holds no dataset."""
    if (manifest := read_manifest(folder)) is None:
        raise OutputError(f"'{folder}' holds no dataset: {MANIFEST} is missing")
    return manifest


def with_files(manifest: Manifest, ledger: Ledger, contents: Mapping[str, bytes]) -> Manifest:
    """Writes files beside the shards, and lists them in the manifest with those that it lists already."""
    for name, content in contents.items():
        ledger.place(name, content)
    files = manifest.files | {name: ledger.listed(name).sha256 for name in contents}
    return manifest.model_copy(update={"files": files})


def check_size(folder: Path, name: str, listed: Listed) -> None:
    """Refuses (`OutputError`) a file that is missing or has another size than its manifest lists, unread."""
    path = folder / name
    if not path.is_file():
        raise OutputError(f"'{path}' is missing, and {MANIFEST} lists it: put it back, or make the dataset again")
    if listed.size not in {None, path.stat().st_size}:
        raise OutputError(_changed(path, f"has {path.stat().st_size} bytes, and {MANIFEST} lists {listed.size}"))


def listed_content(folder: Path, name: str, listed: Listed) -> bytes:
    """Content of a file; an `OutputError` names it where it is missing, unreadable, or not what the manifest lists."""
    check_size(folder, name, listed)
    path = folder / name
    try:
        content = path.read_bytes()
    except OSError as error:
        raise OutputError(f"'{path}' cannot be read: {error.strerror or error}") from None
    if hashlib.sha256(content).hexdigest() != listed.sha256:
        raise OutputError(_changed(path, f"its SHA-256 is not the one in {MANIFEST}"))
    return content


def _changed(path: Path, how: str) -> str:
    return f"'{path}' is not as it was written ({how}): put it back, or make the dataset again"


class Recorded(Config):
    """Facts about frames of a real sensor; `magicsim.dataset.real` writes them."""

    schema_version: Literal[1] = 1
    rows: Annotated[int, Field(ge=1, le=65_535)]
    """Height of every frame [px]."""
    columns: Annotated[int, Field(ge=1, le=65_535)]
    """Width of every frame [px]."""
    frames_per_second: Annotated[float, Field(gt=0, le=1e6)] | None
    """Frame rate [1/s]; none where nobody said when the frames were taken."""
    table: tuple[str, ...]
    """Names of the columns, in order."""
    description: Annotated[str, Field(pattern=r"^[a-z]+\.toml$")]
    """Name of the file beside it that says where the frames came from and what was done to them."""


def read_recorded(folder: Path) -> Recorded | None:
    """The facts of a folder of recorded frames (`OutputError` unless this version's); None of simulated ones."""
    path = folder / RECORDED
    if not path.is_file():
        return None
    try:
        return validate(Recorded, read_json(path), source=RECORDED)
    except (MagicsimError, TypeError) as error:
        raise OutputError(f"'{path}' does not describe recorded frames: {error}") from None
