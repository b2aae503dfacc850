"""Runs the detectors with the standard profiles: over an episode, scored against its truth, and on single frames.

An episode as a Parquet table: one row a frame with its truth and every profile's verdict.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Self

import cv2
import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from magicsim.arrays import Frame
from magicsim.detectors.combined import behind_coat, detect, detect_all, followed
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.rest import References, fuse
from magicsim.detectors.verdict import NUMBERS, WORDS, FeatureAtRest, Verdict, features_at_rest, marked
from magicsim.errors import ConfigError, MagicsimError
from magicsim.judge.score import DetectionScore, score_verdicts
from magicsim.scenes.scene import TaxelSettings
from magicsim.simulation.episode import Episode, SimulatedFrame, frame_file, truth_row
from magicsim.simulation.touch_truth import TOUCH_COLUMNS, touch_columns
from magicsim.waiting import Told, on_stderr, waiting

PROFILES = ("calibrated", "published")
"""Profiles that every report shows; scores of the first one are the headline."""
COATED = "proximity: design.coat is opaque, and nothing outside is seen"
"""What is not judged of a coated sensor, and why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """What the detectors with one profile say about an episode's frames after the references."""

    profile: str
    thresholds: dict[str, float]
    """tau_e, tau_c, tau_g of the profile."""
    verdicts: tuple[Verdict, ...]
    """One per frame after the references, in order."""
    score: DetectionScore
    at_rest: Mapping[str, FeatureAtRest] = field(default_factory=dict)
    """`entropy`, `correlation` and `similarity` of the reference frames."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorDetector:
    """One profile with the references of one sensor under one light."""

    profile: DetectorProfile
    references: References
    rest: Mapping[str, FeatureAtRest]
    """E, C and S of the reference frames."""
    is_coated: bool = False
    """Whether an opaque coat hides what is outside."""

    @classmethod
    def of(cls, untouched: Sequence[Frame], profile: DetectorProfile, *, is_coated: bool = False) -> Self:
        """A profile fused with RGB frames of the untouched sensor, in order of time; `FrameError` as of `fuse`."""
        references = fuse(untouched, profile)
        rest = features_at_rest(detect_all(untouched, references, profile))
        return cls(profile=profile, references=references, rest=rest, is_coated=is_coated)

    def verdict(self, frame: Frame) -> Verdict:
        """The verdict on a frame, with whether it rests on less than the camera's own repeatability."""
        verdict = detect(frame, self.references, self.profile)
        return marked(behind_coat(verdict) if self.is_coated else verdict, self.rest)

    def verdicts(self, frames: Iterable[Frame]) -> Iterator[Verdict]:
        """Verdicts on frames as they arrive, units of rest following."""
        detector = self
        for frame in frames:
            verdict = detector.verdict(frame)
            yield verdict
            detector = replace(detector, references=followed(detector.references, verdict, detector.profile))


def judge(episode: Episode, profile_name: str, *, told: Told = on_stderr) -> Judgement:
    """Verdicts of one profile on the frames after the references, and their score.

    Behind an opaque coat every proximity is `Normal`, which says nothing: see `COATED`.

    Args:
        episode: References and frames.
        profile_name: Preset or file.
        told: Hears what takes longer than two seconds.
    """
    profile = load_profile(profile_name)
    with waiting(f"judging {len(episode.frames)} frames", told):
        untouched = [frame.image for frame in episode.references]
        detector = SensorDetector.of(untouched, profile, is_coated=episode.scene.design.is_opaque)
        verdicts = tuple(detector.verdicts(frame.image for frame in episode.scored))
    return Judgement(
        profile=profile_name,
        thresholds={"tau_e": profile.tau_e, "tau_c": profile.tau_c, "tau_g": profile.tau_g},
        verdicts=verdicts,
        score=score_verdicts(verdicts, [frame.truth.frame_class for frame in episode.scored]),
        at_rest=detector.rest,
    )


def fused_profiles(untouched: Sequence[Frame]) -> dict[str, SensorDetector | str]:
    """Each standard profile with RGB frames of the untouched sensor, in order of time, or why it refuses the sensor."""
    fused: dict[str, SensorDetector | str] = {}
    for name in PROFILES:
        profile = load_profile(name)
        try:
            fused[name] = SensorDetector.of(untouched, profile)
        except MagicsimError as error:
            fused[name] = str(error)
    return fused


TABLE = "episode.parquet"
"""Name of the table in a folder of results."""
MARKERS = ("markers_mm", "markers_px")
READ = {
    field.name: field for field in (
        pa.field("file", pa.string(), nullable=False), pa.field("is_reference", pa.bool_(), nullable=False),
        pa.field("frame_class", pa.string()), pa.field("gap_mm", pa.float64()),
        pa.field("force_n", pa.list_(pa.float64(), 3), nullable=False),
        pa.field("flashlight", pa.bool_(), nullable=False),
    )
}  # fmt: skip
"""Columns that are read back, and whether they may have nulls."""


def write_table(path: Path, episode: Episode, judgements: Sequence[Judgement]) -> None:
    """Writes truth and verdicts, one row a frame, references included.

    Columns that a dataset has too are named as there. Only labels that were not asked for are null: elsewhere a text is
    empty and a number NaN where there is nothing.
    """
    skipped = len(episode.references)
    marked, taxels = episode.scene.design.markers is not None, episode.scene.output.taxels
    rows = [_row(frame, marked=marked, taxels=taxels) for frame in episode.frames]
    for judgement in judgements:
        for row, frame in zip(rows, episode.frames, strict=True):
            number = frame.truth.index - skipped
            verdict = judgement.verdicts[number].as_dict() if number >= 0 else {}
            for key in (*NUMBERS, *WORDS):
                row[f"{judgement.profile}_{key}"] = verdict.get(key, math.nan if key in NUMBERS else "")
            row[f"{judgement.profile}_weak"] = bool(verdict.get("weak"))
    flows = episode.scene.contact.infill_yield_mpa is not None
    schema = _schema(judgements, marked=marked, flows=flows, touch=rows[0] if taxels else {})
    pq.write_table(pa.Table.from_pylist(rows, schema=schema), path, compression="zstd")


def read_table(folder: Path, names: Sequence[str]) -> list[dict[str, Any]]:
    """Rows of the table in a folder of results; a `ConfigError` names what is missing or wrong in it."""
    path, schema = folder / TABLE, pa.schema([READ[name] for name in names])
    try:
        found = pq.read_table(path, columns=list(names)).select(list(names)).cast(schema)
    except (OSError, pa.ArrowException, KeyError, ValueError) as error:
        reason = str(error.args[-1] if error.args else error).partition("\n")[0]
        raise ConfigError(f"'{path}' cannot be read: {reason}") from None
    rows: list[dict[str, Any]] = found.to_pylist()
    return rows


def _schema(judgements: Sequence[Judgement], *, marked: bool, flows: bool, touch: dict[str, Any]) -> pa.Schema:
    number, vector = pa.float64(), pa.list_(pa.float64(), 3)
    picture = pa.struct({"bytes": pa.binary(), "path": pa.string()})
    fields = [
        ("step", pa.int32()), ("file", pa.string()), ("time_s", number), ("is_reference", pa.bool_()),
        ("frame_class", pa.string()), ("gap_mm", number), ("x_mm", number), ("y_mm", number), ("twist_deg", number),
        ("flashlight", pa.bool_()), ("contact", pa.bool_()), ("depth_mm", number), ("force_n", vector),
        ("torque_nmm", vector), ("contact_area_mm2", number),
        ("beyond_limits", pa.bool_()), ("in_view", pa.bool_()), ("light_way", pa.string()), ("image_way", pa.string()),
        ("iterations", pa.int32()), ("min_jacobian", number), ("max_penetration_mm", number), ("force_balance", number),
        ("contact_mask", picture), ("displacements_mm", pa.list_(pa.float32())),
    ]  # fmt: skip
    if flows:
        fields += [("dissipated_nmm", number)]
    if marked:
        fields += [(name, pa.list_(pa.list_(number))) for name in MARKERS]
    touched = [name for name in TOUCH_COLUMNS if name in touch]
    fields += [(name, number if name.startswith("max_") else pa.list_(pa.list_(number))) for name in touched]
    for judgement in judgements:
        fields += [(f"{judgement.profile}_{key}", number) for key in NUMBERS]
        fields += [(f"{judgement.profile}_{key}", pa.string()) for key in WORDS]
        fields += [(f"{judgement.profile}_weak", pa.bool_())]
    return pa.schema(fields)


def _row(frame: SimulatedFrame, *, marked: bool, taxels: TaxelSettings | None) -> dict[str, Any]:
    state, labels = frame.truth.state, frame.labels
    moved, mask, touch = labels.displacements_mm, labels.contact_mask, labels.touch
    further: dict[str, Any] = {name: getattr(labels, name) for name in MARKERS if marked}
    further |= touch_columns(touch, taxels) if touch is not None and taxels is not None else {}
    plain = {name: each.tolist() if isinstance(each, np.ndarray) else each for name, each in further.items()}
    return truth_row(frame) | plain | {
        "file": frame_file(frame.truth.index), "x_mm": state.x_mm, "y_mm": state.y_mm,
        "gap_mm": state.gap_mm if state.gap_mm is not None else math.nan,
        "contact_mask": {"bytes": _png(mask), "path": None} if mask is not None else None,
        "displacements_mm": moved.ravel() if moved is not None else None,
    }  # fmt: skip


def _png(mask: np.ndarray[Any, np.dtype[np.bool_]]) -> bytes:
    return bytes(cv2.imencode(".png", mask.astype(np.uint8) * 255)[1].tobytes())
