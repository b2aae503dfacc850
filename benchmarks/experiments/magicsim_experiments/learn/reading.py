"""A model reads frames: images, a folder of them, a video, or the frames of a dataset."""

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.arrays import Array, Frame
from magicsim.dataset.export.source import open_dataset
from magicsim.dataset.manifest import MANIFEST
from magicsim.detectors.source import read_source, source_kind
from magicsim.errors import ConfigError, FrameError
from magicsim_experiments.learn.model_file import ModelConfig, read_model
from magicsim_experiments.learn.samples import Images, Samples, reduced


class FrameReader:
    """A model file that was opened."""

    def __init__(self, path: Path) -> None:
        """Reads the header of a file `model.safetensors` of a study; raises what `read_model` does."""
        self.path = path
        self.config: ModelConfig
        self.config, self._content = read_model(path)
        self._network: Any = None  # of PyTorch, which only reading needs

    def check(self, image: Frame, what: str) -> None:
        """Refuses a frame of another size than the model takes."""
        config, (rows, columns) = self.config, image.shape[:2]
        if (rows, columns) != (config.frame_rows, config.frame_columns):
            raise FrameError(
                f"{what} has {columns} x {rows} pixels; the model takes frames of {config.frame_columns} x "
                f"{config.frame_rows}; `dataset import` brings recorded ones to that with "
                f"frames.size_px = [{config.frame_columns}, {config.frame_rows}]"
            )

    def reduced(self, image: Frame) -> Images:
        """A frame as the model sees it, shape (rows, columns, 3)."""
        return reduced(image, self.config.long_side_px)

    def untouched(self, images: Sequence[Frame]) -> Images:
        """The mean of untouched frames, reduced, shape (rows, columns, 3)."""
        return np.asarray(np.mean([self.reduced(each) for each in images], axis=0), np.float32)

    def read(self, images: Sequence[Frame], references: Sequence[Images]) -> Array:
        """Answers on frames in the labels' units, shape (n, labels).

        Args:
            references: What `untouched` gave for the sensor of each frame; zeros where the model takes frames as they
                are.

        Raises:
            ConfigError: The file's weights are not those of its network, or answers are not finite.
        """
        from magicsim_experiments.learn.networks import open_network
        from magicsim_experiments.learn.training import answers_with

        if self._network is None:
            self._network = open_network(self._content, self.config, source=str(self.path))
        numbers = np.arange(len(images))
        samples = Samples(
            images=np.stack([self.reduced(each) for each in images]), references=np.stack(list(references)),
            reference_of=numbers, targets=np.zeros((len(images), len(self.config.labels))), labels=self.config.labels,
            press=numbers, unit=numbers, object_of=numbers, features=np.zeros((len(images), 0)), group=numbers,
        )  # fmt: skip
        with np.errstate(all="ignore"):  # what overflows is told below
            answers = answers_with(self._network, samples, self.config)
        if not np.isfinite(answers).all():
            raise ConfigError(f"model '{self.path}' has no finite answer: its numbers overflow")
        return answers


AT_ONCE = 64
"""Frames that are in memory at the same time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """What a model says of one frame."""

    frame: str
    values: dict[str, float]
    """Answer of each label by its name and unit; a flag's as a probability."""


def estimate_frames(
    model: Path, source: Path, *, reference: Path | None = None, frames: int | None = None
) -> Iterator[Estimate]:
    """Reads every frame of a source.

    Args:
        model: File `model.safetensors` of a study.
        source: Image, folder of images, video, camera's index, or a finished dataset, whose own references serve.
        reference: The same, of the untouched sensor, its mean taken over at most 30 frames; needed where the model
            reads frames beside it, but for datasets.

    Raises:
        ConfigError: The model is missing, damaged or overflows, a source does not exist, a camera without `frames`,
            or the reference is missing.
        FrameError: Frames have another size than the model takes, or cannot be read.
    """
    reader = FrameReader(model)
    if frames is not None and frames < 1:
        raise ConfigError(f"frames = {frames} is not allowed: must be at least 1")
    if (source / MANIFEST).is_file():
        found = _dataset_frames(source, reader)
    else:
        if frames is None and source_kind(source) == "camera":
            raise ConfigError(f"frames is missing: camera {source} never ends; give the number of frames to read")
        found = _source_frames(source, _reference(reference, reader), reader)
    return _estimates(islice(found, frames), reader)


def _estimates(frames: Iterator[tuple[str, Frame, Images]], reader: FrameReader) -> Iterator[Estimate]:
    labels = [label.name for label in reader.config.labels]
    while batch := list(islice(frames, AT_ONCE)):
        found = reader.read([image for _, image, _ in batch], [reference for _, _, reference in batch])
        for (name, _, _), row in zip(batch, found, strict=True):
            yield Estimate(frame=name, values=dict(zip(labels, map(float, row), strict=True)))


def _dataset_frames(folder: Path, reader: FrameReader) -> Iterator[tuple[str, Frame, Images]]:
    source = open_dataset(folder)
    for split in source.splits:
        for shard in source.shards(split):
            for table in source.episodes(shard):
                images = source.pictures(table, "image")
                untouched = np.array(table["is_reference"].to_pylist(), bool)
                episode = table["episode"][0].as_py()
                for image in images[:1]:
                    reader.check(image, f"dataset '{folder}'")
                used = [each for each, is_one in zip(images, untouched, strict=True) if is_one]
                if not used and reader.config.input != "frame":
                    msg = f"dataset '{folder}' has no reference frames, and the model reads frames beside them"
                    raise ConfigError(msg)
                reference = reader.untouched(used) if used else np.zeros_like(reader.reduced(images[0]))
                for step, (image, is_one) in enumerate(zip(images, untouched, strict=True)):
                    if not is_one:
                        yield f"episode {episode} step {step}", image, reference


def _source_frames(
    source: Path, reference: Images | None, reader: FrameReader
) -> Iterator[tuple[str, Frame, Images]]:  # fmt: skip
    with closing(read_source(source)) as found:
        for each in found:
            reader.check(each.image, f"frame '{each.name}'")
            yield (
                each.name, each.image,
                reference if reference is not None else np.zeros_like(reader.reduced(each.image)),
            )  # fmt: skip


def _reference(reference: Path | None, reader: FrameReader) -> Images | None:
    if reader.config.input == "frame":
        return None
    if reference is None:
        raise ConfigError("--reference is missing: the model reads frames beside those of the untouched sensor")
    with closing(read_source(reference)) as found:
        used = []
        for each in islice(found, 30):
            reader.check(each.image, f"reference '{each.name}'")
            used.append(each.image)
    return reader.untouched(used)
