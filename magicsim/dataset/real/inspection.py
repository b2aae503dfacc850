"""A look at recorded frames, and advice on what their description should say: size, orientation, colours, exposure."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import cv2
import numpy as np

from magicsim.arrays import Array
from magicsim.dataset.frames import open_frames
from magicsim.dataset.manifest import MANIFEST
from magicsim.dataset.real.description import FrameForm, RealSource
from magicsim.dataset.real.form import TURNS, Turn, after, turned
from magicsim.dataset.real.labels import truth_of
from magicsim.dataset.real.sequence import RealFrame, RecordedSequence, check_size, sequences_of
from magicsim.detectors.frame import Frame
from magicsim.errors import ConfigError
from magicsim.frame_class import FrameClass
from magicsim.judge.recorded import read_episode

SAMPLED = 12
"""Frames of a recording that are looked at, spread over it."""
MOST_RATIO = 1.1
"""Brightness of frames over that of their references, or of one channel over the others', that is told."""
LIKE_RATIO = 1.25
"""Mean brightness against that of another sensor that is told."""
MOST_SATURATED, LEAST_MEAN = 0.2, 10.0
"""Share of saturated pixels, and mean grey level, that are told."""
COMPARED_PX = 48
"""Longer side of the pictures that are compared in orientation [px]."""
LEAST_LIKENESS, LEAST_GAIN = 0.3, 0.1
"""Correlation that another orientation must have, and by how much it must be better."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RealRecording:
    """One recording as it was found."""

    frames: str
    """Folder or video, as the description names it."""
    episodes: int
    references: int
    samples: int
    """Frames that are not references; of a video, as far as it was looked at."""
    columns: int
    rows: int
    labels: list[str]
    """What the CSV file tells."""
    classes: dict[str, int]
    """Frames of each class; `unscored` those without one."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Inspection:
    """What `magicsim dataset import` reports without `--out`."""

    recordings: list[RealRecording]
    told: list[str]
    """What to set or to do, one line each; empty where nothing is odd."""


def inspect_real(real: RealSource) -> Inspection:
    """Looks at every recording, at some of its frames, and says what to set.

    Raises:
        ConfigError: Frames or labels are not where the description says, or not what it says.
        FrameError: An image cannot be read, or frames differ in size.
    """
    advice: list[str] = []
    recordings = []
    size: tuple[int, int] | None = None
    likeness = _Likeness.of(real.path(real.description.like)) if real.description.like is not None else None
    for sequence in sequences_of(real):
        untouched = [each.image for each in sequence.references()]
        sampled = list(_sampled(sequence))
        for frame in (*untouched, *(each.image for each in sampled)):
            size = size or (frame.shape[0], frame.shape[1])
            check_size(frame, size, sequence.source.frames)
        assert size is not None  # a recording without a frame is an error
        recordings.append(_recording(sequence, len(untouched), size))
        advice += _of_labels(sequence)
        advice += _of_exposure(sequence, untouched, sampled)
        if likeness is not None and untouched:
            advice += likeness.advice(np.mean(untouched, 0), real.description.frames)
    return Inspection(recordings=recordings, told=list(dict.fromkeys(advice)))


def _recording(sequence: RecordedSequence, references: int, size: tuple[int, int]) -> RealRecording:
    rules, labels = sequence.description.truth, sequence.labels
    known = labels.known if labels is not None else frozenset()
    rows = labels.rows if labels is not None else ()
    if not sequence.is_video:
        rows = tuple(
            row for number, (_, row) in enumerate(sequence.entries) if number not in sequence.reference_numbers
        )
    classes = [truth_of(row, rules, known).frame_class for row in rows]
    counts = {str(each): classes.count(each) for each in FrameClass} | {"unscored": classes.count(None)}
    return RealRecording(
        frames=sequence.source.frames,
        episodes=len(sequence.episodes),
        references=references,
        samples=len(rows),
        columns=size[1],
        rows=size[0],
        labels=sorted(known - {"image"}),
        classes=counts,
    )


def _sampled(sequence: RecordedSequence) -> Iterator[RealFrame]:
    """Frames spread over a folder; the first ones of a video, which would have to be decoded as a whole."""
    if sequence.is_video:
        yield from islice(sequence.scored(sequence.episodes[0]), SAMPLED)
        return
    every = max(1, len(sequence.entries) // SAMPLED)
    for episode in sequence.episodes[:SAMPLED]:
        yield from islice(sequence.scored(episode, every=every), SAMPLED)


def _of_labels(sequence: RecordedSequence) -> Iterator[str]:
    """What labels lack, or have the wrong way round."""
    source, labels = sequence.source, sequence.labels
    if all(each is None for each in (source.untouched, source.untouched_first, source.untouched_below_n)) and (
        not sequence.reference_numbers
    ):
        yield (
            f"{sequence.field} has no frames of the untouched sensor, which detectors learn from: set untouched, "
            "untouched_first or untouched_below_n"
        )
    if labels is None:
        yield f"{sequence.field}.labels is missing: frames will have no force, place, depth or class"
        return
    presses = np.array([row["force_n"][2] for row in labels.rows])
    presses = presses[np.abs(presses) > sequence.description.truth.contact_n]
    if len(presses) and np.median(presses) < 0:
        yield (
            f"{sequence.field}: forces along z are mostly negative, and a press is +z here: set scale.force_n with a "
            "negative last factor, as in [1, 1, -1]"
        )
    depths = np.array([row["depth_mm"] for row in labels.rows])
    if len(depths) and np.nanmax(depths, initial=-np.inf) <= 0 and np.isfinite(depths).any() and (depths < 0).any():
        yield f"{sequence.field}: depths are negative, and a press is positive here: set scale.depth_mm = -1"


def _of_exposure(sequence: RecordedSequence, untouched: list[Frame], sampled: list[RealFrame]) -> Iterator[str]:
    """Where frames are lit or exposed otherwise than their references, or cannot be read well."""
    looked_at = untouched or [each.image for each in sampled]
    if not looked_at:
        return
    mean = np.mean([each.mean() for each in looked_at])
    saturated = np.mean([(each == 255).mean() for each in looked_at])  # noqa: PLR2004 - white
    if saturated > MOST_SATURATED:
        yield f"{sequence.field}: {100 * saturated:.0f} % of the pixels are white: expose less"
    if mean < LEAST_MEAN:
        yield f"{sequence.field}: the mean grey level is {mean:.1f} of 255: expose more, or set gain"
    if not untouched or not sampled:
        return
    before = np.mean(untouched, 0, dtype=np.float64) + 1
    ratios = np.median([np.median((each.image + 1.0) / before, axis=(0, 1)) for each in sampled], axis=0)
    overall = float(np.median(ratios))
    if not 1 / MOST_RATIO <= overall <= MOST_RATIO:
        yield (
            f"{sequence.field}: frames are {overall:.2f} times as bright as the untouched ones: record both with "
            f"locked exposure, or set gain = {sequence.source.gain / overall:.3g} there"
        )
    apart = float(ratios.max() / ratios.min())
    if apart > MOST_RATIO:
        named = ", ".join(f"{channel} {ratio:.2f}" for channel, ratio in zip("RGB", ratios, strict=True))
        yield f"{sequence.field}: colours differ from the untouched frames' ({named}): lock the white balance"


@dataclass(frozen=True, slots=True, kw_only=True)
class _Likeness:
    """The untouched sensor that frames should resemble."""

    name: str
    mean: Array
    """Shape (rows, columns, 3)."""

    @classmethod
    def of(cls, folder: Path) -> "_Likeness":
        """Mean of the references of a run, of a recording, or of a dataset's first episode.

        Raises:
            ConfigError: It is none of these, or has no references.
        """
        references: Sequence[Frame]
        if (folder / MANIFEST).is_file():
            frames = open_frames(folder, ("image", "is_reference", "episode"))
            episodes = frames.column("episode")
            untouched = frames.where((episodes == episodes.min()) & frames.column("is_reference"))
            references = [row["image"] for row in untouched]
        else:
            references = read_episode(folder).references
        if not references:
            msg = f"like = '{folder}' has no reference frames: make it with references above 0"
            raise ConfigError(msg)
        return cls(name=folder.name, mean=np.mean(references, 0, dtype=np.float64))

    def advice(self, mean: Array, form: FrameForm) -> Iterator[str]:
        """What differs in an untouched mean frame of shape (rows, columns, 3)."""
        rows, columns = self.mean.shape[:2]
        best, order = self._orientation(mean)
        if mean.shape[:2] != (rows, columns):
            now = f"{mean.shape[1]} x {mean.shape[0]}"
            shape = turned(mean, best).shape
            crop = ", and frames.crop_px before, since their shapes differ"
            extra = crop if abs(shape[1] * rows / (shape[0] * columns) - 1) > 0.02 else ""  # noqa: PLR2004
            yield (
                f"frames have {now} pixels, those of '{self.name}' {columns} x {rows}: set frames.size_px = "
                f"[{columns}, {rows}]{extra}"
            )
        current: Turn = (form.rotate_deg, form.mirror)
        wanted = after(current, best)
        if wanted != current:
            yield (
                f"frames look turned against those of '{self.name}': set frames.rotate_deg = {wanted[0]} and "
                f"frames.mirror = {str(wanted[1]).lower()}"
            )
        if order:
            other = "rgb" if form.color_order == "bgr" else "bgr"
            yield f"red and blue look exchanged against '{self.name}': set frames.color_order = \"{other}\""
        ratio = float(mean.mean() / max(self.mean.mean(), 1e-9))
        if not 1 / LIKE_RATIO <= ratio <= LIKE_RATIO:
            yield (
                f"untouched frames have a mean grey level of {mean.mean():.0f}, those of '{self.name}' "
                f"{self.mean.mean():.0f}: set rig.camera.exposure_grey = {mean.mean():.0f} there"
            )

    def _orientation(self, mean: Array) -> tuple[Turn, bool]:
        """The turn, and whether an exchange of red and blue, with which a frame is most like this sensor's."""
        scored = {
            (turn, order): _correlation(turned(mean[..., ::-1] if order else mean, turn), self.mean)
            for turn in TURNS
            for order in (False, True)
        }
        same = scored[TURNS[0], False]
        best = max(scored, key=lambda each: scored[each])
        if scored[best] < LEAST_LIKENESS or scored[best] < same + LEAST_GAIN:
            return TURNS[0], False
        near = [each for each in scored if scored[each] > scored[best] - LEAST_GAIN]
        return min(near, key=lambda each: (each[1], TURNS.index(each[0])))


def _correlation(image: Array, other: Array) -> float:
    """Pearson's coefficient of two colour images, reduced to the size of a thumbnail, all channels together."""
    rows, columns = other.shape[:2]
    scale = COMPARED_PX / max(rows, columns)
    size = (max(4, round(columns * scale)), max(4, round(rows * scale)))
    small = [
        cv2.resize(np.ascontiguousarray(each, np.float32), size, interpolation=cv2.INTER_AREA)
        for each in (image, other)
    ]
    one, two = (each.ravel() - each.mean() for each in small)
    norm = float(np.linalg.norm(one) * np.linalg.norm(two))
    return float(one @ two) / norm if norm else 0.0
