"""How the published features and the verdicts change with what is taken away."""

import zlib
from collections.abc import Mapping, Sequence
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from magicsim.detectors import DetectorProfile, FrameClass, detect, fuse
from magicsim.errors import MagicsimError
from magicsim.evaluation.answers import judge_footage
from magicsim.evaluation.detector import ProfileDetector
from magicsim.evaluation.footage import ExposedTake, Footage
from magicsim.evaluation.suite import SuiteConfig
from magicsim.evaluation.take import Case, Take
from magicsim.judge.measures import estimate
from magicsim.judge.tally import EpisodeLabels, EpisodeTag, tally

MEASURED = (
    "proximity_balanced_accuracy", "contact_balanced_accuracy", "approach_auc", "touch_auc", "light_false_alarms",
)  # fmt: skip
"""Measures that are told with their intervals."""
FEATURES = ("entropy", "correlation", "similarity")


def ablated_footage(case: Case, take: Take, suite: SuiteConfig) -> Footage:
    """A take as labelled frames in the standard noise of a suite."""
    scored = ~take.is_reference
    name = suite.noises[0].name
    return Footage(
        tag=EpisodeTag(
            take=case.name, object=case.object, role=case.role, path=case.path, light=case.light, noise=name
        ),
        labels=EpisodeLabels.of(take.gap_mm[scored], take.force_n[scored], take.flashlight[scored]),
        images=ExposedTake(
            take=take,
            camera=suite.rig.camera,
            seed=zlib.crc32(f"{suite.seed} {case.name}".encode()) & 0x7FFFFFFF,
            frames_per_second=suite.frames_per_second,
        ),
        frames_per_second=suite.frames_per_second,
    )


def without_fusion(profile: DetectorProfile) -> DetectorProfile:
    """The detectors with a single frame as their whole reference."""
    return replace(profile, reference_count=1, background_count=1)


def score_ablation(footage: Sequence[Footage], profile: DetectorProfile, suite: SuiteConfig) -> dict[str, Any]:
    """Measures with bootstrap intervals over takes, and medians of E, C and S by true class.

    Args:
        footage: One a take.
        profile: Of the built-in detectors.
        suite: Whose seed and number of resamples count.

    Returns:
        `measures` and `features`; or `refused`, where the detectors cannot use the frames.
    """
    try:
        episodes = [judge_footage(each, lambda: ProfileDetector(profile), who="built-in") for each in footage]
        features = _features(footage, profile)
    except MagicsimError as error:
        return {"refused": str(error)}
    table, takes = tally(episodes), [each.tag.take for each in footage]
    return {
        "takes": len(footage),
        "measures": {
            name: asdict(estimate(name, table, takes, resamples=suite.resamples, seed=suite.seed)) for name in MEASURED
        },
        "features": features,
    }


def _features(footage: Sequence[Footage], profile: DetectorProfile) -> dict[str, dict[str, float]]:
    values: dict[str, dict[str, list[float]]] = {str(each): {name: [] for name in FEATURES} for each in FrameClass}
    for film in footage:
        references = fuse(film.images.references(), profile)
        for frame, truth in zip(film.images.frames(), film.labels.classes, strict=True):
            if truth is None:
                continue
            verdict = detect(frame, references, profile)
            for name in FEATURES:
                values[str(truth)][name].append(getattr(verdict, name))
    return {
        truth: {name: _median(each) for name, each in row.items()} for truth, row in values.items() if row[FEATURES[0]]
    }


def _median(values: Sequence[float]) -> float:
    return float(np.median(values))


def compare_scores(scores: Mapping[str, Mapping[str, Any]], full: str) -> dict[str, dict[str, float]]:
    """By how much every measure fell against the full physics, of the ablations that could be scored."""
    reference = scores[full]["measures"]
    return {
        name: {
            each: reference[each]["value"] - score["measures"][each]["value"]
            for each in MEASURED
            if reference[each]["value"] is not None and score["measures"][each]["value"] is not None
        }
        for name, score in scores.items()
        if name != full and "measures" in score
    }
