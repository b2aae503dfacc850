"""What detectors say of filmed sensors: E, C and S by state, and shares of right verdicts with intervals."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from laboratory.see_through.sensors import DrawnSensor, Lights
from magicsim.detectors.combined import detect_all
from magicsim.detectors.features import Episode
from magicsim.detectors.fusion import fuse
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.verdict import Contact, Proximity, Verdict
from magicsim.evaluation.footage import ExposedTake
from magicsim.evaluation.take import Take
from magicsim.frame_class import FrameClass
from magicsim.judge.tally import EpisodeLabels

Array = npt.NDArray[np.float64]
STATES = {"untouched": FrameClass.CLEAR, "near": FrameClass.NEAR, "touched": FrameClass.CONTACT}
"""States that recordings tell apart, and their classes."""
FEATURES = ("entropy", "correlation", "similarity")
QUANTILES = (0.1, 0.5, 0.9)
RESAMPLES, INTERVAL = 4000, (0.025, 0.975)
SHARES = {
    "contact_balanced": "contact, balanced over touched and untouched (near included)",
    "touched_called": "touched frames called Touched",
    "untouched_called": "untouched frames called Touched",
    "near_called": "near frames called Touched",
    "near_balanced": "near (Approaching) against untouched (Normal), balanced",
    "similarity_area": "area under the ROC curve of S, touched against untouched and near",
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """Verdicts on one sensor's frames that have a class."""

    name: str
    lights: Lights
    classes: tuple[FrameClass, ...]
    verdicts: tuple[Verdict, ...]

    def where(self, one: FrameClass) -> list[Verdict]:
        """Verdicts on the frames of a class."""
        return [verdict for verdict, each in zip(self.verdicts, self.classes, strict=True) if each is one]


def exposed(sensor: DrawnSensor, take: Take) -> Episode:
    """A take through its sensor's camera, with classes."""
    scored, scene = ~take.is_reference, sensor.scene
    images = ExposedTake(
        take=take, camera=sensor.camera, seed=scene.seed, frames_per_second=scene.frames_per_second,
        lit=scene.rig.lit,
    )  # fmt: skip
    labels = EpisodeLabels.of(take.gap_mm[scored], take.force_n[scored], take.flashlight[scored])
    return Episode(references=list(images.references()), frames=list(images.frames()), classes=labels.classes)


def read(sensor: DrawnSensor, episode: Episode, profile: DetectorProfile) -> Reading:
    """Verdicts of one profile.

    Raises:
        FrameError: The references show no grid.
    """
    found = detect_all(list(episode.frames), fuse(list(episode.references), profile), profile)
    kept = [(verdict, each) for verdict, each in zip(found, episode.classes, strict=True) if each is not None]
    return Reading(
        name=sensor.name,
        lights=sensor.lights,
        classes=tuple(each for _, each in kept),
        verdicts=tuple(verdict for verdict, _ in kept),
    )


def features(readings: Sequence[Reading]) -> dict[str, dict[str, dict[str, list[float]]]]:
    """Of each state and feature: 10 %, median and 90 % of all frames, and the range of single sensors' medians."""
    found: dict[str, dict[str, dict[str, list[float]]]] = {}
    for state, one in STATES.items():
        found[state] = {}
        for name in FEATURES:
            values = [np.array([getattr(each, name) for each in reading.where(one)]) for reading in readings]
            medians = [float(np.median(each)) for each in values if len(each)]
            found[state][name] = {
                "frames": np.quantile(np.concatenate(values), QUANTILES).round(4).tolist(),
                "sensors": np.quantile(medians, (0.05, 0.95)).round(4).tolist(),
            }
    return found


def shares(readings: Sequence[Reading], *, seed: int = 0) -> dict[str, dict[str, float | list[float]]]:
    """Of each measure: mean over sensors, its 95 % interval (bootstrap over sensors), and where nine of ten lie."""
    random, found = np.random.default_rng(seed), {}
    table = [_of_sensor(each) for each in readings]
    for name in SHARES:
        values = np.array([each[name] for each in table])
        means = values[random.integers(len(values), size=(RESAMPLES, len(values)))].mean(1)
        found[name] = {
            "mean": round(float(values.mean()), 4),
            "interval": np.quantile(means, INTERVAL).round(4).tolist(),
            "sensors": np.quantile(values, (0.05, 0.95)).round(4).tolist(),
        }
    return found


def _of_sensor(reading: Reading) -> dict[str, float]:
    clear, near, touched = (reading.where(one) for one in STATES.values())

    def called(verdicts: Sequence[Verdict]) -> float:
        return float(np.mean([each.combined == Contact.TOUCHED for each in verdicts]))

    normal = np.mean([each.proximity == Proximity.NORMAL for each in clear])
    approaching = np.mean([each.proximity == Proximity.APPROACHING for each in near])
    return {
        "contact_balanced": (called(touched) + 1 - called([*clear, *near])) / 2,
        "touched_called": called(touched),
        "untouched_called": called(clear),
        "near_called": called(near),
        "near_balanced": float(normal + approaching) / 2,
        "similarity_area": _area(touched, [*clear, *near]),
    }


def _area(positive: Sequence[Verdict], negative: Sequence[Verdict]) -> float:
    """Share of pairs in which the touched frame has the lower S; ties count a half."""
    low = np.array([each.similarity for each in positive])[:, None]
    high = np.array([each.similarity for each in negative])[None]
    return float((low < high).mean() + (low == high).mean() / 2)
