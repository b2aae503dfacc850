"""Frames and labels in memory, as networks and baselines take them."""

import json
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Annotated, Any, Literal

import cv2
import numpy as np
import numpy.typing as npt
import pyarrow as pa
from pydantic import Field

from magicsim.arrays import Array, Index, Mask
from magicsim.config.models import Config
from magicsim.dataset.export.source import Source, open_dataset
from magicsim.errors import ConfigError


@dataclass(frozen=True, slots=True, kw_only=True)
class Split:
    """Rows of the frames of each part, ascending; no group is in two of them."""

    train: Index
    validation: Index
    test: Index


def fold(
    groups: Index, number: int, folds: int, *, validation_share: float, share: float = 1.0, seed: int = 0,
    inner: Index | None = None,
) -> Split:  # fmt: skip
    """One fold of a cross-validation over groups.

    A smaller share of the training groups is a part of a larger one's, and test and validation stay.

    Args:
        groups: Group of each frame, shape (n,).
        number: Which fold, from 0.
        validation_share: Share of the other groups that tell when to stop, at least one.
        share: Share of the training groups that are used, at least one.
        inner: Groups within which validation and share are chosen, such as presses where the folds are units; the
            groups themselves by default.

    Raises:
        ConfigError: There are fewer groups than folds, or too few to train on.
    """
    names = np.unique(groups)
    if len(names) < folds:
        raise ConfigError(f"there are {len(names)} groups for {folds} folds: more of them are needed, or fewer folds")
    order = np.random.default_rng([seed, folds]).permutation(names)
    held = order[number::folds]
    inner = groups if inner is None else inner
    outside = ~np.isin(groups, held)
    rest = np.unique(inner[outside])
    left = np.random.default_rng([seed, folds, number]).permutation(rest)
    stop = max(1, round(validation_share * len(left)))
    train = left[stop:]
    if not len(train):
        raise ConfigError(f"there are {len(left)} groups beside those of the test: too few to train on")
    train = train[: max(1, round(share * len(train)))]
    return Split(
        train=np.flatnonzero(np.isin(inner, train) & outside),
        validation=np.flatnonzero(np.isin(inner, left[:stop]) & outside),
        test=np.flatnonzero(~outside),
    )


Images = npt.NDArray[np.float32]
FRAME = "frame"
"""Key of a frame's name beside its answers."""
TURNS = frozenset({"roll_deg", "pitch_deg", "yaw_deg"})
"""Keys of an object that say how it is turned."""


class Label(Config):
    """What a model tells."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z][A-Za-z0-9_]{0,59}$")]
    """Key of the answer; `frame` is that of the frame's name."""
    unit: Annotated[str, Field(pattern=r"^[ -~]{0,20}$")] = ""
    kind: Literal["number", "flag", "choice"] = "number"
    """A number; whether something is so (0 or 1); or one of some values."""
    choices: Annotated[tuple[Annotated[float, Field(ge=-1e9, le=1e9)], ...], Field(max_length=1000)] = ()
    """Values of a choice, ascending."""

    def _problems(self) -> Iterator[str]:
        if self.name == FRAME:
            yield f"name = '{self.name}' is not allowed: it stands for the name of the frame"
        if (self.kind == "choice") != bool(self.choices):
            wanted = "must name at least one" if self.kind == "choice" else f"must be [] of a {self.kind}"
            yield f"choices = {list(self.choices)} is not allowed: {wanted}"
        if any(later <= earlier for earlier, later in pairwise(self.choices)):
            yield f"choices = {list(self.choices)} is not allowed: must ascend"


@dataclass(frozen=True, slots=True, kw_only=True)
class Samples:
    """Frames with their labels; row k of every array belongs to frame k."""

    images: Images
    """Shape (n, rows, columns, 3), grey levels 0 to 255, reduced."""
    references: Images
    """Untouched frames, shape (m, rows, columns, 3)."""
    reference_of: Index
    """Row of `references` of each frame, shape (n,)."""
    targets: Array
    """Shape (n, labels); NaN where a label does not exist; a choice by its value."""
    labels: tuple[Label, ...]
    press: Index
    unit: Index
    object_of: Index
    """Number of the object of each frame, whatever its orientation; -1 without one."""
    features: Array
    """Geometric features for baselines, shape (n, features)."""
    group: Index
    """Number of the group that a frame is scored with, such as presses with and without shear, shape (n,)."""

    def __len__(self) -> int:
        """Number of frames."""
        return len(self.images)

    def at(self, rows: Index) -> "Samples":
        """Some of the frames."""
        names = ("images", "reference_of", "targets", "press", "unit", "object_of", "features", "group")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})

    def inputs(self, kind: str) -> Images:
        """What networks see (`Input`), in units of the full range, shape (n, rows, columns, channels)."""
        if kind == "frame":
            return np.asarray(self.images / np.float32(255.0), np.float32)
        untouched = self.references[self.reference_of]
        change = self.images - untouched
        found = change if kind == "difference" else np.concatenate([change, untouched], -1)
        return np.asarray(found / np.float32(255.0), np.float32)


@dataclass(frozen=True, slots=True, kw_only=True)
class EpisodeRows:
    """The rows of one episode, decoded."""

    columns: dict[str, list[Any]]
    images: Images
    """Reduced frames, shape (rows of the episode, rows, columns, 3)."""
    masks: list[Mask]
    """Contact masks in full size, where they were asked for."""

    @property
    def untouched(self) -> Images:
        """Mean of the reference frames, shape (rows, columns, 3)."""
        return np.asarray(self.images[np.array(self.columns["is_reference"], bool)].mean(0))

    def vectors(self, name: str, length: int) -> Array:
        """A column of vectors, NaN where there is none, shape (n, length)."""
        return np.array([each or (np.nan,) * length for each in self.columns[name]], float)


@dataclass(frozen=True, slots=True, kw_only=True)
class Chosen:
    """What counts of an episode's rows, and what is true of them."""

    rows: Mask
    """Which rows count, shape (n,); references never do."""
    targets: Array
    """Shape (n, labels)."""
    features: Array
    group: Index


Choose = Callable[[EpisodeRows], Chosen]


def read_samples(
    folder: Path, labels: Sequence[Label], choose: Choose, *, columns: Sequence[str], long_side_px: int,
    masks: bool = False,
) -> Samples:  # fmt: skip
    """Frames of a finished dataset, in the order of its episodes.

    Args:
        folder: What `magicsim dataset` wrote.
        choose: What counts and what is true, from the rows of an episode.
        long_side_px: Longer side of the reduced frames [px]; 0 keeps them.
        masks: Whether it needs contact masks.

    Raises:
        OutputError: There is no finished dataset, or a file of it is not as it was written.
    """
    source = open_dataset(folder)
    wanted = [
        "image", "episode", "sensor", "is_reference", "object_config", *columns, *(["contact_mask"] if masks else []),
    ]  # fmt: skip
    parts: list[tuple[int, int, Images, Chosen, Images, str]] = []
    for split in source.splits:
        for shard in source.shards(split):
            for table in source.episodes(shard):
                rows = _decoded(source, table.select(list(dict.fromkeys(wanted))), long_side_px)
                is_reference = np.array(rows.columns["is_reference"], bool)
                reference = rows.images[is_reference].mean(0, keepdims=True)
                found = choose(rows)
                found = replace(found, rows=found.rows & ~is_reference)
                numbers = (int(rows.columns["episode"][0]), int(rows.columns["sensor"][0]))
                key = object_key(rows.columns["object_config"])
                parts.append((*numbers, rows.images[found.rows], found, reference, key))
    parts.sort(key=lambda part: part[0])
    episodes, sensors, images, chosen, references, keys = zip(*parts, strict=True)
    objects = {key: number for number, key in enumerate(dict.fromkeys(filter(None, keys)))}
    of = np.repeat(np.arange(len(parts)), [int(each.rows.sum()) for each in chosen])
    return Samples(
        images=np.concatenate(images), references=np.concatenate(references), reference_of=of,
        targets=np.concatenate([each.targets[each.rows] for each in chosen]), labels=tuple(labels),
        press=np.array(episodes)[of], unit=np.array(sensors)[of],
        object_of=np.array([objects.get(key, -1) for key in keys])[of],
        features=np.concatenate([each.features[each.rows] for each in chosen]),
        group=np.concatenate([each.group[each.rows] for each in chosen]),
    )  # fmt: skip


def object_key(configs: Sequence[str]) -> str:
    """What the object of an episode is, apart from how it is turned; empty without one.

    Args:
        configs: `object_config` of its rows: JSON, a name, or empty.
    """
    config = next((each for each in configs if each), "")
    try:
        table = json.loads(config)
    except ValueError:
        return config  # a name, of recorded frames
    if not isinstance(table, dict):
        return config
    return json.dumps({name: value for name, value in table.items() if name not in TURNS}, sort_keys=True)


def reduced(image: npt.NDArray[np.uint8], long_side_px: int) -> Images:
    """A frame with its longer side reduced to so many pixels by averaging areas, as float32; 0 keeps its size.

    Args:
        image: Shape (rows, columns, 3).
        long_side_px: At most the frame's own; a larger one keeps it too.
    """
    rows, columns = image.shape[:2]
    scale = long_side_px / max(rows, columns)
    if long_side_px == 0 or scale >= 1:
        return image.astype(np.float32)
    size = (max(1, round(columns * scale)), max(1, round(rows * scale)))
    return np.asarray(cv2.resize(image.astype(np.float32), size, interpolation=cv2.INTER_AREA), np.float32)


def _decoded(source: Source, table: pa.Table, long_side_px: int) -> EpisodeRows:
    plain = [name for name in table.column_names if name not in {"image", "contact_mask"}]
    masks = source.pictures(table, "contact_mask") if "contact_mask" in table.column_names else []
    return EpisodeRows(
        columns={name: table[name].to_pylist() for name in plain},
        images=np.stack([reduced(each, long_side_px) for each in source.pictures(table, "image")]),
        masks=[each > 0 for each in masks],
    )
