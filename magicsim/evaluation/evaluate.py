"""Judges a detector on a suite: measures with intervals, curves, and what fell against a baseline."""

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from magicsim.detectors.verdict import Proximity
from magicsim.errors import ConfigError
from magicsim.evaluation.answers import check_order, judge_footage
from magicsim.evaluation.baseline import Baseline, Comparison, condition_of, set_beside
from magicsim.evaluation.detector import MakeDetector, ProfileDetector, detector_by
from magicsim.evaluation.footage import Footage, film_case, read_recordings
from magicsim.evaluation.rest import Rest, rest_streams
from magicsim.evaluation.suite import SuiteConfig
from magicsim.evaluation.take import list_cases
from magicsim.frame_class import FrameClass
from magicsim.judge.curves import (
    NO_TOUCH,
    NOTHING_NEAR,
    CurvePoint,
    Roc,
    detection_by_depth,
    detection_by_distance,
    trade_off,
)
from magicsim.judge.measures import COMPUTE, TABLE, MeasureEstimate, estimate, exact_share
from magicsim.judge.regression import Change, Collapse, collapses
from magicsim.judge.tally import JudgedEpisode, confusion, is_faultless, tally
from magicsim.judge.verdicts import COATED
from magicsim.waiting import Told, on_stderr, unheard, waiting

Progress = Callable[[int, int], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class Evaluation:
    """Everything that is known of a detector on a suite."""

    suite: str
    detector: str
    beside: Comparison | None
    """What the baseline says of the same episodes."""
    standard: str
    """Condition of light and noise that the headline measures are of."""
    metrics: dict[str, dict[str, MeasureEstimate]]
    """By group of episodes, then by name of the measure."""
    confusion: dict[str, dict[str, dict[str, int]]]
    """`proximity` and `contact` of the standard condition: frames by true class and verdict."""
    distance: list[CurvePoint]
    depth: list[CurvePoint]
    roc: dict[str, Roc | None]
    rest: list[Rest]
    episodes: list[JudgedEpisode] = field(repr=False)
    footage: list[Footage] = field(repr=False)
    seconds: float
    not_judged: str | None = None
    """What was not judged, and why; None where all was."""
    collapses: list[Collapse] = field(default_factory=list)
    """Classes that are never named and accuracies by chance in the standard condition."""

    @property
    def baseline(self) -> str | None:
        """The baseline's detector."""
        return self.beside.baseline.detector if self.beside is not None else None

    @property
    def changes(self) -> list[Change]:
        """Compared measures, on frames that are the baseline's own."""
        return self.beside.changes if self.beside is not None else []

    @property
    def regressions(self) -> list[Change]:
        """Changes that are significantly worse than the baseline."""
        return [each for each in self.changes if each.is_regression]

    @property
    def improvements(self) -> list[Change]:
        """Changes that are significantly better."""
        return [each for each in self.changes if each.is_improvement]

    @property
    def is_worse(self) -> bool:
        """Whether a measure fell, or something collapsed that the baseline, if there is one, tells apart."""
        return bool(self.regressions) or not all(each.is_known for each in self.collapses)

    @property
    def cannot_judge(self) -> str | None:
        """Why no fall in the standard condition could have been found; None where one could, and without a baseline."""
        tested = [each for each in self.changes if each.condition == self.standard and each.p_fall is not None]
        if self.beside is None or any(each.smallest_fall is not None for each in tested):
            return None
        takes = max((each.episodes for each in tested), default=0)
        same = " with the baseline's frames" if self.beside.frames_changed else ""
        return f"{takes} shared take{'s'[: takes != 1]}{same} in {self.standard}, in which no fall could be found"

    def as_dict(self) -> dict[str, Any]:
        """What goes into the JSON: everything but images and single frames."""
        times = sorted(each.milliseconds for each in self.episodes)
        return {
            "suite": self.suite,
            "detector": self.detector,
            "baseline": self.baseline,
            "standard": self.standard,
            "metrics": {group: {name: asdict(one) for name, one in row.items()} for group, row in self.metrics.items()},
            "confusion": self.confusion,
            "detection_by_distance": [asdict(each) for each in self.distance],
            "detection_by_depth": [asdict(each) for each in self.depth],
            "roc": {name: asdict(each) if each is not None else None for name, each in self.roc.items()},
            "rest": [asdict(each) for each in self.rest],
            "provenance": self.beside.as_dict() if self.beside is not None else None,
            "compared": [asdict(each) | {"frames": len(each.frames)} for each in self.changes],
            "regressions": [asdict(each) for each in self.regressions],
            "improvements": [asdict(each) for each in self.improvements],
            "not_judged": self.not_judged,
            "collapses": [asdict(each) for each in self.collapses],
            "cannot_judge": self.cannot_judge,
            "sensors": {each.tag.take: each.tag.sensor for each in self.episodes},
            "episodes": len(self.episodes),
            "frames": sum(len(each.proximity) for each in self.episodes),
            "milliseconds_per_frame": times[len(times) // 2],
            "seconds": round(self.seconds, 3),
        }


def evaluate(
    suite: SuiteConfig, detector: str | MakeDetector = "calibrated", *, cache: Path, told: Told = on_stderr
) -> Evaluation:
    """Judges a detector on a suite, as `magicsim evaluate` does without a baseline.

    Args:
        suite: The episodes.
        detector: A class that satisfies `magicsim.evaluation.detector.Detector`; or, as text, the name or file of a
            profile of the built-in detectors, `module:Class`, `file.py:Class`, or the name of an entry point.
        cache: Folder where simulated episodes are kept.
        told: Hears what takes longer than two seconds.

    Raises:
        MagicsimError: No such detector, it fails, or an episode cannot be simulated or read.
    """
    name = detector if isinstance(detector, str) else getattr(detector, "__name__", type(detector).__name__)
    make = detector_by(detector, is_coated=suite.design.is_opaque)
    return evaluate_suite(suite, make, name="suite", detector=name, cache=cache, told=told)


def evaluate_suite(
    suite: SuiteConfig,
    make: MakeDetector,
    *,
    name: str,
    detector: str,
    cache: Path,
    baseline: Baseline | None = None,
    progress: Progress | None = None,
    films: Iterable[list[Footage]] | None = None,
    told: Told = on_stderr,
) -> Evaluation:
    """Judges a detector.

    Args:
        suite: The episodes.
        make: Makes the detector, anew for every episode.
        name: Of the suite, for results.
        detector: Its name, for results.
        cache: Folder of takes, where simulated episodes are kept.
        baseline: What to compare with.
        progress: Told after every take with the takes done and all takes.
        films: Footage of each take instead of all of the suite's.
        told: Hears what takes longer than two seconds; nothing where `progress` does.

    Raises:
        MagicsimError: An episode cannot be simulated or read, the detector fails, or the baseline does not fit.
    """
    start, coated = time.perf_counter(), suite.design.is_opaque
    total = len(list_cases(suite)) + len(suite.recordings)
    with waiting("judging takes", told if progress is None else unheard) as share:
        episodes: list[JudgedEpisode] = []
        footage: list[Footage] = []
        for done, take in enumerate(film_suite(suite, cache) if films is None else films, 1):
            if not footage and type(make()) is not ProfileDetector:  # which is known to
                check_order(take[0], make, who=detector)
            footage += take
            judged = [judge_footage(film, make, who=detector) for film in take]
            if coated:  # behind it a detector is not asked what is near: an alarm is a touch
                judged = [replace(each, proximity=(str(Proximity.NORMAL),) * len(each.proximity)) for each in judged]
            episodes += judged
            (progress or share)(done, max(done, total))
        if not any(each.proximity for each in episodes):
            raise ConfigError(f"'{name}' holds no frames to judge: must hold some beside those of the untouched sensor")
        conditions = [condition_of(each) for each in episodes]
        groups = group_episodes(episodes)
        standard = groups[conditions[0]]
        options: dict[str, Any] = {"resamples": suite.resamples, "seed": suite.seed}
        curve = options | {"false_alarm_rate": suite.false_alarm_rate}
        beside, before = None, []
        if baseline is not None:
            beside = set_beside(baseline, episodes, suite=name, detector=detector, seed=suite.seed)
            pairs = [*beside.alike, *beside.changed]
            before = [then for then, _ in pairs if condition_of(then) == conditions[0]]
        metrics = {group: _estimates(each, coated=coated, **options) for group, each in groups.items()}
        return Evaluation(
            suite=name,
            detector=detector,
            beside=beside,
            standard=conditions[0],
            metrics=metrics,
            confusion=confusion(standard, coated=coated),
            distance=[] if coated else detection_by_distance(standard, **curve),
            depth=detection_by_depth(standard, **curve),
            roc={
                "approach": None if coated else trade_off(standard, "approach", {FrameClass.NEAR}, NOTHING_NEAR),
                "touch": trade_off(standard, "touch", {FrameClass.CONTACT}, NO_TOUCH),
            },
            rest=rest_streams(footage, episodes, make, seconds=suite.rest_s, who=detector),
            episodes=episodes,
            footage=footage,
            seconds=time.perf_counter() - start,
            not_judged=COATED if coated else None,
            collapses=collapses(standard, metrics[conditions[0]], before, coated=coated),
        )


def film_suite(suite: SuiteConfig, cache: Path) -> Iterator[list[Footage]]:
    """Footage of every take of a suite, one list a take. Takes do not depend on each other's order."""
    for case in list_cases(suite):
        yield film_case(case, suite, cache)
    for each in read_recordings(suite):
        yield [each]


def group_episodes(episodes: Sequence[JudgedEpisode]) -> dict[str, list[JudgedEpisode]]:
    """Episodes by condition; those of the standard one, which comes first, also by sensor, role, object, path."""
    conditions = [condition_of(each) for each in episodes]
    groups = {
        one: [each for each, other in zip(episodes, conditions, strict=True) if other == one]
        for one in dict.fromkeys(conditions)
    }
    standard = groups[conditions[0]]
    light, noise, *_ = conditions[0].split("/")
    if elsewhere := [one for one in groups if one != conditions[0] and one.split("/")[:2] == [light, noise]]:
        groups["other places"] = [each for one in elsewhere for each in groups[one]]
    for kind in ("sensor", "role", "object", "path"):
        values = dict.fromkeys(getattr(each.tag, kind) for each in standard)
        if len(values) > 1:
            groups |= {
                f"{kind} {value}": [each for each in standard if getattr(each.tag, kind) == value] for value in values
            }
    return groups


def _estimates(
    episodes: Sequence[JudgedEpisode], *, coated: bool, resamples: int, seed: int
) -> dict[str, MeasureEstimate]:
    table, takes = tally(episodes), [each.tag.take for each in episodes]
    found = {name: estimate(name, table, takes, resamples=resamples, seed=seed) for name in COMPUTE}
    if coated:
        unseen = [name for name in found if TABLE[name].task == "proximity"]
        found |= {name: replace(found[name], value=None, low=None, high=None) for name in unseen}
    right = [is_faultless(each, coated=coated) for each in episodes]
    return found | {"faultless_episodes": exact_share(sum(right), len(right))}
