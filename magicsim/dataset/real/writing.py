"""A dataset of recorded frames on disk: resumable, and the same bytes each time."""

import hashlib
import json
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import chain, islice, pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import tomli_w

from magicsim.config.program import versions
from magicsim.dataset.card import card_columns, card_header
from magicsim.dataset.columns import recorded_columns
from magicsim.dataset.manifest import CARD, FOLDER, RECORDED, Manifest, Recorded, ShardEntry, with_files
from magicsim.dataset.real.description import Description, RealSource
from magicsim.dataset.real.inspection import Inspection, inspect_sequences
from magicsim.dataset.real.labels import CONTACT_LABELS
from magicsim.dataset.real.sequence import RealFrame, RecordedSequence, check_size, sequences_of
from magicsim.dataset.shard import (
    ROWS_A_GROUP,
    Column,
    png_cell,
    schema_of_columns,
    table_of_rows,
    write_rows,
)
from magicsim.folder.ledger import RESUMABLE, Ledger
from magicsim.folder.listing import sha256_of
from magicsim.folder.target import output_errors, sole_writer
from magicsim.frame_class import CONTACT_MIN_DEPTH_MM, frame_label

DESCRIPTION = "real.toml"
NEVER_RENDERED = "recorded"
"""What stands for the renderer's variant."""
TIMED_FRAMES = 16
"""Frames whose times give the frame rate."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RealSummary:
    """What `magicsim dataset import --out` reports."""

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
        real: What to read, see `magicsim.dataset.real.description.load_real`.
        out: Folder of the dataset.
        resume: Whether to go on with what an interrupted run has left there.

    Raises:
        ConfigError: Frames or labels are not where the description says, or not what it says.
        FrameError: An image cannot be read, or frames differ in size.
        OutputError: The folder is not ours, holds another dataset, or cannot be written; what is finished is kept.
    """
    start = time.perf_counter()
    FOLDER.check(out, resume=resume)
    sequences = sequences_of(real)
    inspection = inspect_sequences(real, sequences)
    columns = table_columns(sequences)
    with output_errors(out, then=RESUMABLE), sole_writer(out):
        out.mkdir(parents=True, exist_ok=True)
        ledger, manifest = _begin(real, sequences, columns, inspection, out)
        seen = inspection.recordings[0]
        manifest = _complete(ledger, manifest, sequences, columns, (seen.rows, seen.columns))
    return RealSummary(
        samples=manifest.rows,
        episodes=manifest.episodes,
        told=list(dict.fromkeys([*inspection.told, *(line for each in sequences for line in each.remarks)])),
        seconds=round(time.perf_counter() - start, 3),
        bytes=sum(entry.size for entry in manifest.shards),
        out=str(out),
    )


def description_hash(real: RealSource, sequences: list[RecordedSequence]) -> str:
    """SHA-256 of a description, of the content of its labels, and of names and content of all files of frames."""
    content: list[Any] = [real.description.model_dump(mode="json")]
    for sequence in sequences:
        content.append([[path.name, sha256_of(path)] for path in sequence.files])
        content.append(sha256_of(sequence.labels.path) if sequence.labels is not None else "")
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()


def _begin(
    real: RealSource, sequences: list[RecordedSequence], columns: list[Column], inspection: Inspection, out: Path
) -> tuple[Ledger, Manifest]:
    """The folder's files and the manifest to go on with."""
    earlier = FOLDER.begun(out)
    manifest = Manifest(
        config_hash=description_hash(real, sequences),
        versions=versions(),
        variant=NEVER_RENDERED,
        seed=0,
        episodes=sum(len(each.episodes) for each in sequences),
        shards=earlier.shards if earlier is not None else (),
        files={},
    )
    if earlier is not None:
        FOLDER.refuse_another(out, earlier, manifest, other="a dataset of other frames or of another description")
    facts = Recorded(
        rows=inspection.recordings[0].rows,
        columns=inspection.recordings[0].columns,
        frames_per_second=real.description.frames_per_second or _rate(sequences[0]),
        table=tuple(each.name for each in columns),
        description=DESCRIPTION,
    )
    text = tomli_w.dumps(real.description.model_dump(mode="json", exclude_none=True))
    contents = {
        DESCRIPTION: f"# Recorded frames; read by `magicsim real`, everything in place\n{text}".encode(),
        RECORDED: (facts.model_dump_json(indent=1) + "\n").encode(),
        CARD: real_card(real.description, columns, [each.source.split for each in sequences]).encode(),
    }
    ledger = FOLDER.open_ledger(out)
    manifest = with_files(manifest, ledger, contents)
    FOLDER.write_index(ledger, manifest)
    return ledger, manifest


def _complete(
    ledger: Ledger, manifest: Manifest, sequences: list[RecordedSequence], columns: list[Column], size: tuple[int, int]
) -> Manifest:
    """Writes every shard that the index does not list as it is; `size` is the rows and columns of all frames."""
    done = {each.file: each for each in manifest.shards if ledger.is_intact(each.file)}
    for number, (sequence, episode) in enumerate((each, episode) for each in sequences for episode in each.episodes):
        source = sequence.source
        name = f"data/{source.split}-{number:05d}.parquet"
        if name not in done:
            constants = {"episode": number, "sensor": source.sensor, "path_kind": source.path_kind}
            rows = _rows(sequence, episode, manifest.constants() | constants, size)
            with ledger.writing(name) as partial:
                count = write_rows(partial, _tables(rows, columns), schema_of_columns(columns))
            done[name] = ShardEntry.of(ledger, name, split=source.split, episodes=(number,), rows=count)
        shards = tuple(done[file] for file in sorted(done))
        manifest = manifest.model_copy(update={"shards": shards, "rows": sum(each.rows for each in shards)})
        FOLDER.write_index(ledger, manifest)
    manifest = manifest.model_copy(update={"is_complete": True})
    FOLDER.write_index(ledger, manifest)
    ledger.close()
    return manifest


def _rows(
    sequence: RecordedSequence, episode: str, shared: Mapping[str, Any], size: tuple[int, int]
) -> Iterator[dict[str, Any]]:
    """Rows of one episode, references first; all frames have one size, rows and columns."""
    first_s = sequence.begin_s(episode)
    for step, frame in enumerate(chain(sequence.references(), sequence.scored(episode))):
        check_size(frame.image, size, frame.name)
        kind = frame.labels["object_kind"] or sequence.source.object_kind
        yield {
            **frame_row(frame, sequence),
            "step": step,
            "time_s": frame.labels["time_s"] - first_s,
            "object_kind": "" if frame.is_reference else kind,
            **shared,
        }


def _tables(rows: Iterator[dict[str, Any]], columns: list[Column]) -> Iterator[pa.Table]:
    """Rows in tables of the size of a row group."""
    while batch := list(islice(rows, ROWS_A_GROUP)):
        yield table_of_rows(batch, columns)


def frame_row(frame: RealFrame, sequence: RecordedSequence) -> dict[str, Any]:
    """Columns of one frame of a recording by itself. What a reference has no label of is that of no contact."""
    labels = frame.labels
    common = {
        "image": png_cell(frame.image),
        "is_reference": frame.is_reference,
        "flashlight": bool(labels["flashlight"]),
    }
    if frame.is_reference:
        force_n, depth_mm = np.nan_to_num(labels["force_n"]).tolist(), float(np.nan_to_num(labels["depth_mm"]))
        return common | {"frame_class": "", "contact": False, "force_n": force_n, "depth_mm": depth_mm}
    truth = sequence.truth(labels, name=frame.name)
    is_light = bool(truth.contact) and 0 < truth.depth_mm < CONTACT_MIN_DEPTH_MM
    return common | {
        "frame_class": frame_label(truth.frame_class, touches=is_light),
        "gap_mm": truth.gap_mm,
        "contact": truth.contact,
        "depth_mm": truth.depth_mm,
        "force_n": labels["force_n"],
        "torque_nmm": labels["torque_nmm"],
        "contact_area_mm2": labels["contact_area_mm2"],
        "object_position_mm": labels["place_mm"],
        "twist_deg": labels["twist_deg"],
    }


def table_columns(sequences: Sequence[RecordedSequence]) -> list[Column]:
    """Columns of a dataset of recordings; `contact` only where it is known of every frame.

    That column has no word for what nobody knows.
    """
    is_told = all(
        each.labels is not None
        and each.labels.known & CONTACT_LABELS
        and all(
            number in each.reference_numbers or each.truth(row).contact is not None
            for number, row in enumerate(each.survey.rows)
        )
        for each in sequences
    )
    return [each for each in recorded_columns() if is_told or each.name != "contact"]


def _rate(sequence: RecordedSequence) -> float | None:
    """Frame rate by the times of a recording's first frames [1/s]; None where nothing says it, or none is so low."""
    frames = islice(sequence.scored(sequence.episodes[0]), TIMED_FRAMES)
    steps = [
        later - earlier for earlier, later in pairwise(each.labels["time_s"] for each in frames) if later > earlier
    ]
    return round(1 / sorted(steps)[len(steps) // 2], 6) or None if steps else None


def real_card(description: Description, columns: Sequence[Column], splits: Sequence[str]) -> str:
    """Markdown with a YAML header that names the files of each split."""
    return f"""---
{card_header(description.license, ("robotics", "tactile"), dict.fromkeys(splits))}
---

# Recorded frames of a touch sensor

Frames of a real sensor with their labels, in the columns of a dataset that magicsim simulates; `real.toml` says where
they came from and what was done to them. What nobody labelled is empty or a number that is none;
the flashlight counts as off.

{card_columns(columns)}
"""
