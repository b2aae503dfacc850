"""The angle of a held object, read from both fingers' frames by a learned model."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from magicsim.arrays import Frame
from magicsim.errors import ConfigError
from magicsim_experiments.learn.reading import FrameReader
from magicsim_experiments.learn.samples import Images
from magicsim_experiments.task.alignment.settings import HOW

LABEL = "r_z"
"""Angle of an object's axis to the sensor's y, in (-90, 90] [degrees], see `study.learned.alignment`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadAngle:
    """What both fingers say of the angle about the closing axis, in the gripper's frame [degrees]."""

    upper_deg: float
    lower_deg: float

    @property
    def mean_deg(self) -> float:
        """Mean of both."""
        return (self.upper_deg + self.lower_deg) / 2


class AngleReader:
    """A model that tells r_z, with the untouched frames of both fingers."""

    def __init__(self, model: Path) -> None:
        """Opens the model.

        Args:
            model: File `model.safetensors` of the study `alignment`.

        Raises:
            ConfigError: It is no model, or tells no angle; the message says how to make one.
        """
        if not model.is_file():
            msg = f"model file '{model}' does not exist: {HOW}"
            raise ConfigError(msg)
        self.reader = FrameReader(model)
        labels = [label.name for label in self.reader.config.labels]
        if LABEL not in labels:
            msg = f"model '{model}' tells {', '.join(labels)} and not {LABEL}: {HOW}"
            raise ConfigError(msg)
        self._column = labels.index(LABEL)
        self._untouched: list[Images] = []

    def learn(self, upper: Sequence[Frame], lower: Sequence[Frame]) -> None:
        """Takes the mean of both fingers' untouched frames."""
        for finger, frames in (("upper", upper), ("lower", lower)):
            self.reader.check(frames[0], f"the {finger} finger's frame")
        self._untouched = [self.reader.untouched(frames) for frames in (upper, lower)]

    def read(self, upper: Frame, lower: Frame) -> ReadAngle:
        """The angle, from one frame of each finger; the lower one sees it turned the other way.

        Raises:
            ConfigError: Nothing has been learned of the untouched fingers yet.
        """
        if not self._untouched:
            msg = "the untouched fingers are not known yet: call learn first"
            raise ConfigError(msg)
        angles = self.reader.read([upper, lower], self._untouched)[:, self._column]
        return ReadAngle(upper_deg=float(angles[0]), lower_deg=-float(angles[1]))
