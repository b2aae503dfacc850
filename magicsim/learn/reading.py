"""A model reads frames: images, a folder of them, a video, or the frames of a dataset."""

from collections.abc import Iterator
from contextlib import closing
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import numpy as np
import numpy.typing as npt

from magicsim.dataset.export.source import decoded, open_dataset
from magicsim.dataset.manifest import MANIFEST
from magicsim.detectors.sources.source import read_source, source_kind
from magicsim.errors import ConfigError, FrameError
from magicsim.learn.model_file import ModelConfig, read_config
from magicsim.learn.samples import Samples, reduced
from magicsim.learn.training import answer

Frame = npt.NDArray[np.uint8]
AT_ONCE = 64
"""Frames that are in memory at the same time."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Estimate:
    """What a model says of one frame."""

    frame: str
    """Name of the frame."""
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
            reads differences, but for datasets.
        frames: Most frames to read.

    Raises:
        ConfigError: The model or a source does not exist, a camera without `frames`, or the reference is missing.
        FrameError: Frames have another size than the model takes, or cannot be read.
    """
    config, content = read_config(model), model.read_bytes()
    if frames is not None and frames < 1:
        msg = f"frames = {frames} is not allowed: must be at least 1"
        raise ConfigError(msg)
    if (source / MANIFEST).is_file():
        found = _dataset_frames(source, config)
    else:
        if frames is None and source_kind(source) == "camera":
            msg = f"frames is missing: camera {source} never ends; give the number of frames to read"
            raise ConfigError(msg)
        found = _source_frames(source, _reference(reference, config), config)
    return _estimates(islice(found, frames), config, content)


def _estimates(
    frames: Iterator[tuple[str, Frame, npt.NDArray[np.float32]]], config: ModelConfig, model: bytes
) -> Iterator[Estimate]:
    while batch := list(islice(frames, AT_ONCE)):
        images = np.stack([reduced(image, config.long_side_px) for _, image, _ in batch])
        numbers = np.arange(len(batch))
        samples = Samples(
            images=images, references=np.stack([reference for _, _, reference in batch]), reference_of=numbers,
            targets=np.zeros((len(batch), len(config.labels))), labels=config.labels, press=numbers, unit=numbers,
            features=np.zeros((len(batch), 0)), group=numbers,
        )  # fmt: skip
        for (name, _, _), row in zip(batch, answer(samples, model, config), strict=True):
            values = {label.name: float(value) for label, value in zip(config.labels, row, strict=True)}
            yield Estimate(frame=name, values=values)


def _dataset_frames(folder: Path, config: ModelConfig) -> Iterator[tuple[str, Frame, npt.NDArray[np.float32]]]:
    source = open_dataset(folder)
    for split in source.splits:
        for shard in source.shards(split):
            for table in source.episodes(shard):
                images = [decoded(each) for each in table["image"].to_pylist()]
                untouched = np.array(table["is_reference"].to_pylist(), bool)
                episode = table["episode"][0].as_py()
                for image in images[:1]:
                    _check_size(image, config, f"dataset '{folder}'")
                small = [reduced(each, config.long_side_px) for each in images]
                used = [each for each, is_one in zip(small, untouched, strict=True) if is_one]
                if not used and config.input == "difference":
                    msg = f"dataset '{folder}' has no reference frames, and the model reads differences to them"
                    raise ConfigError(msg)
                reference = np.mean(used, axis=0) if used else np.zeros_like(small[0])
                for step, (image, is_one) in enumerate(zip(images, untouched, strict=True)):
                    if not is_one:
                        yield f"episode {episode} step {step}", image, reference.astype(np.float32)


def _source_frames(
    source: Path, reference: npt.NDArray[np.float32] | None, config: ModelConfig
) -> Iterator[tuple[str, Frame, npt.NDArray[np.float32]]]:
    with closing(read_source(source)) as found:
        for each in found:
            _check_size(each.image, config, f"frame '{each.name}'")
            small = reduced(each.image, config.long_side_px)
            yield each.name, each.image, reference if reference is not None else np.zeros_like(small)


def _reference(reference: Path | None, config: ModelConfig) -> npt.NDArray[np.float32] | None:
    if config.input != "difference":
        return None
    if reference is None:
        msg = "--reference is missing: the model reads differences to frames of the untouched sensor"
        raise ConfigError(msg)
    with closing(read_source(reference)) as found:
        used = []
        for each in islice(found, 30):
            _check_size(each.image, config, f"reference '{each.name}'")
            used.append(reduced(each.image, config.long_side_px))
    return np.asarray(np.mean(used, axis=0), np.float32)


def _check_size(image: Frame, config: ModelConfig, what: str) -> None:
    rows, columns = image.shape[:2]
    if (rows, columns) != (config.frame_rows, config.frame_columns):
        msg = (
            f"{what} has {columns} x {rows} pixels; the model takes frames of "
            f"{config.frame_columns} x {config.frame_rows}; `magicsim real` brings recorded ones to that with "
            f"frames.size_px = [{config.frame_columns}, {config.frame_rows}]"
        )
        raise FrameError(msg)
