"""What a detector says of every frame of an episode, beside the truth."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from magicsim.arrays import Array
from magicsim.detectors.at_rest import FEATURES
from magicsim.evaluation.answers import answered, fitted
from magicsim.evaluation.detector import Detection, MakeDetector
from magicsim.evaluation.takes.footage import EpisodeTag, Footage, Labels


@dataclass(frozen=True, slots=True, kw_only=True)
class JudgedEpisode:
    """Verdicts and scores of the frames after the references."""

    tag: EpisodeTag
    labels: Labels
    proximity: tuple[str, ...]
    contact: tuple[str, ...]
    approach: Array
    """Evidence for a nearby object, shape (frames,)."""
    touch: Array
    """Evidence for a touch, shape (frames,)."""
    features: Mapping[str, Array] = field(default_factory=dict)
    """`entropy`, `correlation` and `similarity` as far as the detector tells them of every frame, shape (frames,)."""
    milliseconds: float = 0.0
    """Median time of one step [ms]; belongs to the machine, so nothing is compared by it."""
    frames_per_second: float = 15.0


def judge_footage(footage: Footage, make: MakeDetector, *, who: str) -> JudgedEpisode:
    """Runs a new detector over an episode.

    Raises:
        MagicsimError: A frame cannot be used, or the detector does not answer as it must.
    """
    detector = fitted(make, footage.images.references(), who=who)
    said, spent = [], []
    for frame in footage.images.frames():
        start = time.perf_counter()
        said.append(answered(detector, frame, who=who))
        spent.append(time.perf_counter() - start)
    return JudgedEpisode(
        tag=footage.tag,
        labels=footage.labels,
        proximity=tuple(str(each.proximity) for each in said),
        contact=tuple(str(each.contact) for each in said),
        approach=np.array([each.approach for each in said], np.float64),
        touch=np.array([each.touch for each in said], np.float64),
        features=features_of(said),
        milliseconds=round(1e3 * float(np.median(spent)), 3) if spent else 0.0,
        frames_per_second=footage.frames_per_second,
    )


def features_of(said: Sequence[Detection]) -> dict[str, Array]:
    """E, C and S that a detector tells of every frame, by name."""
    values = {name: [getattr(each, name) for each in said] for name in FEATURES}
    return {name: np.array(each, np.float64) for name, each in values.items() if each and None not in each}
