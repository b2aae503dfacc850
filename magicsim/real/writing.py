"""A dataset of recorded frames on disk: resumable, and the same bytes each time."""

import hashlib
import json
import math
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import tomli_w

from magicsim.dataset.features import schema_of_columns
from magicsim.dataset.folder import begun_dataset, check_folder, open_ledger
from magicsim.dataset.manifest import CARD, Manifest, ShardEntry, write_manifest
from magicsim.dataset.recorded import RECORDED, Recorded
from magicsim.dataset.shard import read_rows, write_rows
from magicsim.errors import OutputError
from magicsim.folder.hashing import sha256_of
from magicsim.folder.ledger import RESUMABLE, Ledger
from magicsim.folder.lock import sole_writer
from magicsim.folder.result import output_errors
from magicsim.real.card import real_card
from magicsim.real.description import RealSource
from magicsim.real.inspection import Inspection, inspect_real
from magicsim.real.rows import frame_row, table_columns, tables
from magicsim.real.sequence import Sequence, check_size, sequences_of
from magicsim.workers.versions import versions

DESCRIPTION = "real.toml"
NEVER = "recorded"
"""What stands for the renderer's variant."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RealSummary:
    """What `magicsim real --out` reports."""

    samples: int
    """Rows in the dataset."""
    episodes: int
    told: list[str]
    """What to set or to do, one line each; empty where nothing is odd."""
    seconds: float
    bytes: int
    """Size of all shards."""
    out: str


def write_real(real: RealSource, out: Path, *, resume: bool = False) -> RealSummary:
    """Writes recorded frames and their labels as a dataset, which other commands read like a simulated one.

    Args:
        real: What to read, see `magicsim.real.description.load_real`.
        out: Folder of the dataset.
        resume: Whether to go on with what an interrupted run has left there.

    Raises:
        ConfigError: Frames or labels are not where the description says, or not what it says.
        FrameError: An image cannot be read, or frames differ in size.
        OutputError: The folder is not ours, holds another dataset, or cannot be written; what is finished is kept.
    """
    start = time.perf_counter()
    check_folder(out, resume=resume)
    found = inspect_real(real)
    sequences = sequences_of(real)
    with output_errors(out, then=RESUMABLE), sole_writer(out):
        out.mkdir(parents=True, exist_ok=True)
        manifest = _begun(real, sequences, found, out)
        manifest = _complete(sequences, out, manifest)
    return RealSummary(
        samples=manifest.rows,
        episodes=manifest.episodes,
        told=found.told,
        seconds=round(time.perf_counter() - start, 3),
        bytes=sum(entry.size for entry in manifest.shards),
        out=str(out),
    )


def description_hash(real: RealSource, sequences: list[Sequence]) -> str:
    """SHA-256 of a description, of the content of its labels, and of names and sizes of all files of frames."""
    content: list[Any] = [real.description.model_dump(mode="json")]
    for sequence in sequences:
        labels = sequence.labels
        content.append([[path.name, path.stat().st_size] for path in sequence.files])
        content.append(sha256_of(labels.path) if labels is not None else "")
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _begun(real: RealSource, sequences: list[Sequence], found: Inspection, out: Path) -> Manifest:
    """The manifest to go on with."""
    earlier = begun_dataset(out)
    digest = description_hash(real, sequences)
    if earlier is not None and earlier.config_hash != digest:
        msg = f"'{out}' holds a dataset of other frames or of another description; name another folder"
        raise OutputError(msg)
    names = [each.name for each in table_columns(contact_is_told=_tells_contact(sequences))]
    facts = Recorded(
        rows=found.recordings[0].rows,
        columns=found.recordings[0].columns,
        frames_per_second=real.description.frames_per_second or _rate(sequences),
        table=tuple(names),
        description=DESCRIPTION,
    )
    text = tomli_w.dumps(real.description.model_dump(mode="json", exclude_none=True))
    columns = table_columns(contact_is_told="contact" in names)
    contents = {
        DESCRIPTION: f"# Recorded frames; read by `magicsim real`, everything in place\n{text}".encode(),
        RECORDED: (facts.model_dump_json(indent=1) + "\n").encode(),
        CARD: real_card(real.description, columns, [each.source.split for each in sequences]).encode(),
    }
    ledger = open_ledger(out)
    for name, content in contents.items():
        ledger.place(name, content)
    manifest = Manifest(
        config_hash=digest,
        versions=versions(),
        variant=NEVER,
        seed=0,
        episodes=sum(len(each.episodes) for each in sequences),
        shards=earlier.shards if earlier is not None else (),
        files={name: ledger.listed(name).sha256 for name in contents},
    )
    write_manifest(ledger, manifest)
    return manifest


def _complete(sequences: list[Sequence], out: Path, manifest: Manifest) -> Manifest:
    ledger = open_ledger(out)
    columns = table_columns(contact_is_told=_tells_contact(sequences))
    made_by = ", ".join(f"{name} {version}" for name, version in manifest.versions.items())
    shared = {"config_hash": manifest.config_hash, "version": made_by}
    size: tuple[int, int] | None = None
    number = 0
    for sequence in sequences:
        for episode in sequence.episodes:
            name = f"data/{sequence.source.split}-{number:05d}.parquet"
            if not ledger.is_intact(name):
                rows = _Rows(sequence, episode, shared | _constants(sequence, number), size)
                with ledger.writing(name) as partial:
                    write_rows(partial, tables(rows, columns), schema_of_columns(columns))
                size = rows.size
            entry = _entry(ledger, name, sequence.source.split, number)
            others = tuple(each for each in manifest.shards if each.file != name)
            shards = tuple(sorted((*others, entry), key=lambda each: each.file))
            manifest = manifest.model_copy(update={"shards": shards, "rows": sum(each.rows for each in shards)})
            write_manifest(ledger, manifest)
            number += 1
    manifest = manifest.model_copy(update={"is_complete": True})
    write_manifest(ledger, manifest)
    ledger.close()
    return manifest


class _Rows:
    """Rows of one episode, references first, made as they are asked for; all frames have one size."""

    def __init__(
        self, sequence: Sequence, episode: str, shared: Mapping[str, Any], size: tuple[int, int] | None
    ) -> None:
        """Takes what is read, and the size of frames before, if any."""
        self._sequence, self._episode, self._shared, self.size = sequence, episode, shared, size

    def __iter__(self) -> Iterator[dict[str, Any]]:
        """One row a frame."""
        sequence, first_s = self._sequence, math.nan
        rules = sequence.description.truth
        told = sequence.labels.told if sequence.labels is not None else frozenset()
        step = 0
        for frames in (sequence.references(), sequence.scored(self._episode)):
            for frame in frames:
                self.size = self.size or (frame.image.shape[0], frame.image.shape[1])
                check_size(frame.image, self.size, frame.name)
                first_s = frame.labels["time_s"] if math.isnan(first_s) else first_s
                row = frame_row(frame, rules, told, step=step, first_s=first_s)
                kind = frame.labels["object_kind"] or sequence.source.object_kind
                yield {**row, "object_kind": "" if frame.is_reference else kind, **self._shared}
                step += 1


def _constants(sequence: Sequence, number: int) -> dict[str, Any]:
    return {"episode": number, "sensor": sequence.source.sensor, "path_kind": sequence.source.path_kind}


def _entry(ledger: Ledger, name: str, split: str, number: int) -> ShardEntry:
    facts = ledger.listed(name)
    rows = read_rows(ledger.out / name).num_rows
    return ShardEntry(file=name, split=split, episodes=(number,), rows=rows, size=facts.size or 0, sha256=facts.sha256)


def _tells_contact(sequences: list[Sequence]) -> bool:
    """Whether something says of the frames of every recording whether they touch."""
    needed = {"contact", "force_n", "depth_mm", "gap_mm"}
    return all(each.labels is not None and needed & each.labels.told for each in sequences)


def _rate(sequences: list[Sequence]) -> float | None:
    """Frame rate by the times of the first recording's first frames [1/s]; None where nothing says it."""
    times = []
    for frame in sequences[0].scored(sequences[0].episodes[0]):
        times.append(frame.labels["time_s"])
        if len(times) == 2 * 8:
            break
    steps = [later - earlier for earlier, later in pairwise(times) if later > earlier]
    return round(1 / sorted(steps)[len(steps) // 2], 6) if steps else None
