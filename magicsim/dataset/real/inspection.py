"""A look at recorded frames, and advice on what their description should say: size, units, colours, exposure."""

import math
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from magicsim.arrays import Array
from magicsim.dataset.real.appearance import Likeness, told_of_exposure
from magicsim.dataset.real.description import Description, RealSource
from magicsim.dataset.real.labels import CONTACT_LABELS, Row, is_empty, size_of_force
from magicsim.dataset.real.sequence import RecordedSequence, check_size, sequences_of
from magicsim.detectors.offline import said_of, told_of_references
from magicsim.detectors.source import listed_images
from magicsim.errors import ConfigError
from magicsim.frame_class import FrameClass
from magicsim.judge.plausible import odd_labels
from magicsim.waiting import waiting

SECONDS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "ns": 1e-9, "min": 60.0}
NEWTONS = {
    "N": 1.0, "mN": 1e-3, "cN": 1e-2, "kN": 1e3, "g": 9.80665e-3, "gf": 9.80665e-3, "kg": 9.80665, "kgf": 9.80665,
    "lbf": 4.4482216,
}  # fmt: skip
MILLIMETRES = {"mm": 1.0, "cm": 10.0, "m": 1e3, "um": 1e-3, "µm": 1e-3, "inch": 25.4}
UNITS = {
    "time_s": SECONDS, "force_n": NEWTONS, "gap_mm": MILLIMETRES, "depth_mm": MILLIMETRES, "place_mm": MILLIMETRES,
    "torque_nmm": {"Nmm": 1.0, "N mm": 1.0, "mNm": 1.0, "Nm": 1e3, "N m": 1e3},
    "contact_area_mm2": {"mm2": 1.0, "mm²": 1.0, "cm2": 100.0, "cm²": 100.0, "m2": 1e6},
    "twist_deg": {"deg": 1.0, "°": 1.0, "rad": 180 / np.pi},
}  # fmt: skip
"""What one of each unit is in that of a label."""
CLOSE = 1e-3
_UNIT = re.compile(r"[(\[]\s*([^)\]]+?)\s*[)\]]$|_([A-Za-zµ°²2]+)$")
"""`force (mN)`, `force [mN]`, `force_mN`."""


def told_of_units(description: Description) -> Iterator[str]:
    """One line for each label whose column names a unit that the description does not bring into its own."""
    for field, units in UNITS.items():
        named = getattr(description.columns, field)
        names = (named,) if isinstance(named, str) else named or ()
        given = np.abs(np.atleast_1d(getattr(description.scale, field)))
        for name in names:
            found = _UNIT.search(name.strip())
            unit = (found[1] or found[2]) if found is not None else ""
            if unit in units and not np.allclose(given, units[unit], rtol=CLOSE, atol=0):
                yield f": column '{name}' is in {unit} by its name: set scale.{field} = {units[unit]:.7g}"
                break


SLOW_S = 5.0
"""Time from one frame to the next that is told [s]."""
MOST_STILL = 0.1
"""Share of rows with the time of the row before that is told."""
CLOCKS = {1e3: "ms", 1e6: "microseconds", 1e9: "ns"}
"""Units in which tables of other programs have times, by how many make a second."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RealRecording:
    """One recording as it was found."""

    frames: str
    """Folder or video, as the description names it."""
    episodes: int
    references: int
    samples: int
    """Frames that are not references."""
    columns: int
    rows: int
    labels: list[str]
    """What the CSV file tells."""
    classes: dict[str, int]
    """Frames of each class that are not references; `unscored` those without one."""
    unlabelled: int
    """Frames that are not references and of which the labels say nothing."""
    frames_s: tuple[float, float] | None
    """Times of the first and the last frame of a film on the clock of its labels; None elsewhere [s]."""
    labels_s: tuple[float, float] | None
    """Times of the first and the last row of labels; None where they have none [s]."""


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
    return inspect_sequences(real, sequences_of(real))


def inspect_sequences(real: RealSource, sequences: Sequence[RecordedSequence]) -> Inspection:
    """The inspection of recordings that are read on afterwards; raises what `inspect_real` does."""
    advice: list[str] = []
    recordings = []
    size: tuple[int, int] | None = None
    likeness = Likeness.of(real.path(real.description.like)) if real.description.like is not None else None
    for sequence in sequences:
        with waiting(f"looking at '{sequence.source.frames}'"):
            references, survey = list(sequence.references()), sequence.survey
        untouched = [each.image for each in references]
        for frame in (*references, *survey.samples):
            size = size or (frame.image.shape[0], frame.image.shape[1])
            check_size(frame.image, size, frame.name)
        if size is None:
            raise ConfigError(f"{sequence.field}.frames = '{sequence.source.frames}' holds no frame")
        recording = _recording(sequence, len(untouched), size)
        recordings.append(recording)
        told = [*_of_labels(sequence), *_of_clock(sequence, recording), *_of_numbers(sequence)]
        told += [
            *(f": {odd}" for odd in told_of_references(untouched, said_of(untouched))),
            *told_of_exposure(sequence.source.gain, untouched, survey.samples),
        ]
        advice += [*sequence.remarks, *(f"{sequence.field}{line}" for line in told)]
        if likeness is not None and untouched:
            advice += likeness.advice(np.mean(untouched, 0), real.description.frames)
    return Inspection(recordings=recordings, told=list(dict.fromkeys(advice)))


def _scored_rows(sequence: RecordedSequence) -> list[Row]:
    return [row for number, row in enumerate(sequence.survey.rows) if number not in sequence.reference_numbers]


def _recording(sequence: RecordedSequence, references: int, size: tuple[int, int]) -> RealRecording:
    labels, rows = sequence.labels, _scored_rows(sequence)
    truths = [sequence.truth(row) for row in rows]
    classes = [each.frame_class for each in truths]
    times = [row["time_s"] + sequence.start_s for row in sequence.survey.rows] if sequence.is_film else []
    return RealRecording(
        frames=sequence.source.frames,
        episodes=len(sequence.episodes),
        references=references,
        samples=len(rows),
        columns=size[1],
        rows=size[0],
        labels=sorted(labels.known - {"image"}) if labels is not None else [],
        classes={str(each): classes.count(each) for each in FrameClass} | {"unscored": classes.count(None)},
        unlabelled=sum(is_empty(row) and truth.contact is None for row, truth in zip(rows, truths, strict=True)),
        frames_s=_span(times),
        labels_s=_span(labels.times_s) if labels is not None else None,
    )


def _span(times_s: Iterable[float]) -> tuple[float, float] | None:
    """First and last of the times that are known."""
    known = [float(each) for each in times_s if not math.isnan(each)]
    return (round(min(known), 3), round(max(known), 3)) if known else None


def _of_labels(sequence: RecordedSequence) -> Iterator[str]:
    """What labels lack, or have the wrong way round."""
    source, labels = sequence.source, sequence.labels
    if all(each is None for each in (source.untouched, source.untouched_first, source.untouched_below_n)) and (
        not sequence.reference_numbers
    ):
        yield (
            " has no frames of the untouched sensor, which detectors learn from: set untouched, untouched_first or "
            "untouched_below_n"
        )
    if labels is None:
        yield ".labels is missing: frames will have no force, place, depth or class"
        return
    presses = np.array([row["force_n"][2] for row in labels.rows])
    presses = presses[np.abs(presses) > sequence.description.truth.contact_n]
    if len(presses) and np.median(presses) < 0:
        yield (
            ": forces along z are mostly negative, and a press is +z here: set scale.force_n with a negative last "
            "factor, as in [1, 1, -1]"
        )
    depths = np.array([row["depth_mm"] for row in labels.rows])
    if len(depths) and np.nanmax(depths, initial=-np.inf) <= 0 and np.isfinite(depths).any() and (depths < 0).any():
        yield ": depths are negative, and a press is positive here: set scale.depth_mm = -1"
    yield from told_of_units(sequence.description)
    still = int(np.count_nonzero(np.diff(labels.times_s) == 0))
    if still > MOST_STILL * len(labels.rows):
        yield f": {still} of {len(labels.rows)} rows have the time of the row before: write time_s with more digits"


def _of_clock(sequence: RecordedSequence, recording: RealRecording) -> Iterator[str]:
    """Frames without labels, and the clocks of both; `ConfigError` where a film and its rows share no time."""
    if sequence.labels is None:
        return
    if not sequence.is_film:
        unnamed = len(listed_images(sequence.frames_path)) - len(sequence.entries)
        if unnamed > 0:
            yield f": {unnamed} images of '{recording.frames}' have no row in the labels and are left out"
        if recording.unlabelled:
            yield f": {recording.unlabelled} of {recording.samples} frames have rows without any label"
        step_s = _median_step_s(np.array([row["time_s"] for row in sequence.survey.rows]))
        if step_s > SLOW_S:
            fine = next((each for each in CLOCKS if step_s / each <= SLOW_S), max(CLOCKS))
            yield f": frames are {step_s:.4g} s apart: {CLOCKS[fine]}? set scale.time_s = {1 / fine:g}"
        return
    assert recording.frames_s is not None  # a film has a frame
    assert recording.labels_s is not None  # and its rows have times
    (first, last), (begin, end) = recording.frames_s, recording.labels_s
    both = f"frames are from {first:.15g} to {last:.15g} s, rows of labels from {begin:.15g} to {end:.15g} s"
    unit = next((each for each in CLOCKS if last > first and 0.5 < (end - begin) / (last - first) / each < 2), None)  # noqa: PLR2004
    hint = f"; are rows in {CLOCKS[unit]}? set scale.time_s = {1 / unit:g}" if unit is not None else ""
    step_s, most_gap_s = _median_step_s(sequence.labels.times_s), sequence.description.most_gap_s
    if first > end or last < begin:
        hint = hint or f"; offset_s = {sequence.source.offset_s + begin - first:.15g} makes them begin together"
        raise ConfigError(f"{sequence.field}: no frame has labels: {both}{hint}")
    if recording.unlabelled:
        if not hint and step_s > most_gap_s:
            hint = f"; rows are {step_s:.4g} s apart, and most_gap_s = {most_gap_s:g}"
        without = "have no labels" if recording.episodes == 1 else "have no labels and are left out"
        yield f": {recording.unlabelled} of {recording.samples} frames {without}: {both}{hint}"
    start_s = sequence.start_s - sequence.source.offset_s
    if start_s and not sequence.source.offset_s:
        yield (
            f": the clock of the video is at {start_s:.6g} s in its first frame: {both}; set offset_s = {-start_s:.6g} "
            "where labels count from the first frame"
        )


def _median_step_s(times_s: Array) -> float:
    """Usual time from one row to the next [s]; 0 where it is not known."""
    steps = np.diff(times_s)
    return float(np.nanmedian(steps)) if np.isfinite(steps).any() else 0.0


def _of_numbers(sequence: RecordedSequence) -> Iterator[str]:
    """Numbers of labels that no such sensor has, and what the dataset lacks where some are unknown."""
    labels, felt_n = sequence.labels, sequence.description.truth.contact_n
    if labels is None:
        return
    truths = [sequence.truth(row) for row in sequence.survey.rows]
    for line in odd_labels(
        force_n=np.array([size_of_force(row, felt_n) for row in sequence.survey.rows]),
        gap_mm=np.array([each.gap_mm for each in truths]),
        felt_n=felt_n,
        gap="gap_mm" if "gap_mm" in labels.known else "depth_mm",
    ):
        yield f": {line} (scale)"
    unknown = sum(sequence.truth(row).contact is None for row in _scored_rows(sequence))
    if unknown and labels.known & CONTACT_LABELS:
        yield (
            f": of {unknown} frames no label tells whether something touches: they have no class, and the dataset no "
            "column contact"
        )
