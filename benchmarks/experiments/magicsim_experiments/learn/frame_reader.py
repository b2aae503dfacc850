"""A learned model that reads frames which are in memory, beside the untouched frames that belong to them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.arrays import Array, Frame
from magicsim.errors import ConfigError, FrameError
from magicsim_experiments.learn.model_file import ModelConfig, read_model
from magicsim_experiments.learn.samples import Images, Samples, reduced


class FrameReader:
    """A model file that was opened."""

    def __init__(self, path: Path) -> None:
        """Reads the file.

        Args:
            path: File `model.safetensors` of a study.

        Raises:
            ConfigError: It does not exist, is no model, or its header says what is not allowed.
        """
        self.path = path
        self.config: ModelConfig
        self.config, self._content = read_model(path)
        self._network: Any = None  # of PyTorch, which only reading needs

    def check(self, image: Frame, what: str) -> None:
        """Refuses a frame of another size than the model takes.

        Raises:
            FrameError: With both sizes.
        """
        config, (rows, columns) = self.config, image.shape[:2]
        if (rows, columns) != (config.frame_rows, config.frame_columns):
            msg = (
                f"{what} has {columns} x {rows} pixels; the model takes frames of {config.frame_columns} x "
                f"{config.frame_rows}; `magicsim real` brings recorded ones to that with "
                f"frames.size_px = [{config.frame_columns}, {config.frame_rows}]"
            )
            raise FrameError(msg)

    def reduced(self, image: Frame) -> Images:
        """A frame as the model sees it, shape (rows, columns, 3)."""
        return reduced(image, self.config.long_side_px)

    def untouched(self, images: Sequence[Frame]) -> Images:
        """The mean of untouched frames, reduced, shape (rows, columns, 3)."""
        return np.asarray(np.mean([self.reduced(each) for each in images], axis=0), np.float32)

    def read(self, images: Sequence[Frame], references: Sequence[Images]) -> Array:
        """Answers on frames in the labels' units, shape (n, labels).

        Args:
            images: As the camera gives them.
            references: What `untouched` gave for the sensor of each frame; zeros where the model takes frames as they
                are.

        Raises:
            ConfigError: The file's weights are not those of its network, or answers are not finite.
        """
        from magicsim_experiments.learn.training import answers_with
        from magicsim_experiments.learn.weights import open_network

        if self._network is None:
            self._network = open_network(self._content, self.config, source=str(self.path))
        numbers = np.arange(len(images))
        samples = Samples(
            images=np.stack([self.reduced(each) for each in images]), references=np.stack(list(references)),
            reference_of=numbers, targets=np.zeros((len(images), len(self.config.labels))), labels=self.config.labels,
            press=numbers, unit=numbers, thing=numbers, features=np.zeros((len(images), 0)), group=numbers,
        )  # fmt: skip
        with np.errstate(all="ignore"):  # what overflows is told below
            answers = answers_with(self._network, samples, self.config)
        if not np.isfinite(answers).all():
            msg = f"model '{self.path}' has no finite answer: its numbers overflow"
            raise ConfigError(msg)
        return answers
