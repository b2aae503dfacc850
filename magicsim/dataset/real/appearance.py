"""How recorded frames look: references that are none, exposure, colours and orientation, and what to set or do."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from magicsim.arrays import Array
from magicsim.dataset.frames import open_frames
from magicsim.dataset.manifest import MANIFEST
from magicsim.dataset.real.description import FrameForm
from magicsim.dataset.real.sequence import RealFrame
from magicsim.detectors.frame import Frame
from magicsim.detectors.offline import LEAST_MEAN, black_frames, said_of, told_of_references
from magicsim.detectors.orientation import TURNS, Change, after, better_changes, turned, turned_against
from magicsim.errors import ConfigError
from magicsim.judge.recorded import read_episode

MOST_RATIO = 1.1
"""Brightness of frames over that of their references, or of one channel over the others', that is told."""
LIKE_RATIO = 1.25
"""Mean brightness against that of another sensor that is told."""
MOST_SATURATED = 0.2
"""Share of saturated pixels that is told."""


def told_of_exposure(gain: float, untouched: Sequence[Frame], sampled: Sequence[RealFrame]) -> Iterator[str]:
    """Where frames are lit, exposed or turned otherwise than their references, or cannot be read well.

    A gain is advised last, and only where references are steady and nothing else differs.
    """
    looked_at = [*untouched] or [each.image for each in sampled]
    if not looked_at:
        return
    mean = np.mean([each.mean() for each in looked_at])
    saturated = np.mean([(each == 255).mean() for each in looked_at])  # noqa: PLR2004 - white
    if saturated > MOST_SATURATED:
        yield f": {100 * saturated:.0f} % of the pixels are white: expose less"
    is_black = bool(mean < LEAST_MEAN)
    if is_black and untouched and np.mean([each.image.mean() for each in sampled] or [0.0]) >= LEAST_MEAN:
        yield f": references are black, with a mean grey level of {mean:.1f} of 255, and frames are not: take others"
        return
    if is_black:
        yield f": the mean grey level is {mean:.1f} of 255: expose more, or set gain"
    means = np.array([each.image.mean((0, 1)) for each in sampled]).reshape(-1, 3) + 1
    if black := black_frames(means, np.median(means, 0)) if len(means) else []:
        yield f": frames such as '{sampled[black[0]].name}' are black: leave out what a camera gives before it is ready"
    if not untouched or not sampled:
        return
    before = np.mean(untouched, 0, dtype=np.float64) + 1
    if turned_line := turned_against(np.asarray(before), [each.image for each in sampled]):
        yield f": {turned_line}"
        return
    ratios = np.median([np.median((each.image + 1.0) / before, axis=(0, 1)) for each in sampled], axis=0)
    overall, apart = float(np.median(ratios)), float(ratios.max() / ratios.min())
    if apart > MOST_RATIO:
        named = ", ".join(f"{channel} {ratio:.2f}" for channel, ratio in zip("RGB", ratios, strict=True))
        yield f": colours differ from the untouched frames' ({named}): lock the white balance"
    if not 1 / MOST_RATIO <= overall <= MOST_RATIO:
        steady = not [*told_of_references(untouched, said_of(untouched))] and apart <= MOST_RATIO
        or_gain = f", or set gain = {gain / overall:.3g} there" if steady else ""
        told = f": frames are {overall:.2f} times as bright as the untouched ones: record both with locked exposure"
        yield told + or_gain


@dataclass(frozen=True, slots=True, kw_only=True)
class Likeness:
    """The untouched sensor that frames should resemble."""

    name: str
    mean: Array

    @classmethod
    def of(cls, folder: Path) -> "Likeness":
        """Mean of the references of a run, a recording, or a dataset's first episode; `ConfigError` without any."""
        references: Sequence[Frame]
        if (folder / MANIFEST).is_file():
            frames = open_frames(folder, ("image", "is_reference", "episode"))
            episodes = frames.column("episode")
            untouched = frames.where((episodes == episodes.min()) & frames.column("is_reference"))
            references = [row["image"] for row in untouched]
        else:
            references = read_episode(folder).references
        if not references:
            raise ConfigError(f"like = '{folder}' has no reference frames: make it with references above 0")
        return cls(name=folder.name, mean=np.mean(references, 0, dtype=np.float64))

    def advice(self, mean: Array, form: FrameForm) -> Iterator[str]:
        """What differs in an untouched mean frame of shape (rows, columns, 3)."""
        rows, columns = self.mean.shape[:2]
        fitting = better_changes([mean], self.mean) or [(TURNS[0], False)]
        best, exchanged = fitting[0]
        if mean.shape[:2] != (rows, columns):
            now = f"{mean.shape[1]} x {mean.shape[0]}"
            shape = turned(mean, best).shape
            crop = ", and frames.crop_px before, since their shapes differ"
            extra = crop if abs(shape[1] * rows / (shape[0] * columns) - 1) > 0.02 else ""  # noqa: PLR2004
            yield (
                f"frames have {now} pixels, those of '{self.name}' {columns} x {rows}: set frames.size_px = "
                f"[{columns}, {rows}]{extra}"
            )
        if len(fitting) > 1:
            ways = ", ".join(_settings(form, each) for each in fitting)
            yield (
                f"frames look turned against those of '{self.name}', and several settings fit alike: {ways}; which is "
                "right cannot be seen"
            )
        elif best != TURNS[0]:
            yield f"frames look turned against those of '{self.name}': set {_settings(form, (best, False))}"
        if len(fitting) == 1 and exchanged:
            yield (f"red and blue look exchanged against '{self.name}': set frames.color_order = \"{_other(form)}\"")
        ratio = float(mean.mean() / max(self.mean.mean(), 1e-9))
        if not 1 / LIKE_RATIO <= ratio <= LIKE_RATIO:
            yield (
                f"untouched frames have a mean grey level of {mean.mean():.0f}, those of '{self.name}' "
                f"{self.mean.mean():.0f}: set rig.camera.exposure_grey = {mean.mean():.0f} there"
            )


def _settings(form: FrameForm, change: Change) -> str:
    """What a form has to say for frames to be changed so."""
    turn, exchanged = change
    current = (form.rotate_deg, form.mirror)
    wanted = after(current, turn)
    said = (
        [f"frames.rotate_deg = {wanted[0]} and frames.mirror = {str(wanted[1]).lower()}"] if wanted != current else []
    )
    said += [f'frames.color_order = "{_other(form)}"'] if exchanged else []
    return " and ".join(said)


def _other(form: FrameForm) -> str:
    """The order of colours that a form has not."""
    return "rgb" if form.color_order == "bgr" else "bgr"
