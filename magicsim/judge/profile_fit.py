"""Fits a detector profile to labelled episodes of one sensor and saves it, so that every design is judged fairly."""

import dataclasses
import logging
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.config.models import apply_overrides
from magicsim.detectors.calibrate import Candidates, fit_profile
from magicsim.detectors.combined import detect_all
from magicsim.detectors.features import Episode, scored_classes
from magicsim.detectors.offline import said_of, told_of_references
from magicsim.detectors.profile import DetectorProfile, load_profile, save_profile
from magicsim.detectors.rest import fuse
from magicsim.detectors.thresholds import fit_widths
from magicsim.detectors.verdict import Proximity, Verdict
from magicsim.errors import ConfigError, FrameError, OutputError, unknown_choice
from magicsim.folder import check_file
from magicsim.frame_class import FrameClass
from magicsim.judge.curves import rates_at, roc_curve
from magicsim.judge.recorded import read_episode
from magicsim.judge.score import DetectionScore, score_verdicts
from magicsim.waiting import Told, on_stderr, waiting

_LOG = logging.getLogger(__name__)


@dataclass(frozen=True, slots=True, kw_only=True)
class Separation:
    """How well one feature tells two groups of training frames apart, at the fitted threshold and at all others."""

    area: float
    """Area under the ROC curve, 0..1."""
    threshold: float
    hit_rate: float
    false_alarm_rate: float
    curve: list[tuple[float, float]]
    """False alarm rate and hit rate of every threshold, from the strictest."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitSummary:
    """Report of `magicsim fit profile`."""

    profile: str
    options: dict[str, float | int | str]
    frames: dict[str, int]
    candidates: int
    """Combinations of options that were tried."""
    proximity_accuracy: float | None
    """Balanced accuracy on the training frames, 0..1."""
    contact_accuracy: float | None
    """Balanced accuracy of the combined verdict on the training frames, 0..1."""
    cross_validated_proximity_accuracy: float | None
    """Balanced accuracy with each episode judged by a fit to the others; None where those lack a class."""
    cross_validated_contact_accuracy: float | None
    base_proximity_accuracy: float | None
    """Balanced accuracy of the base profile on the same frames, 0..1."""
    base_contact_accuracy: float | None
    roc: dict[str, Separation]
    """`brightening`: Near and Light against Clear by E; `light`: Light against Near and Contact by C; `touch`: Contact
    against the rest by S, frames called Noise left out."""


def calibrate(
    episodes: Sequence[Path],
    out: Path,
    *,
    base: str | Path = "published",
    settings: Sequence[str] = (),
    read: Callable[[Path], Sequence[Episode]] = lambda folder: [read_episode(folder)],
    told: Told = on_stderr,
) -> FitSummary:
    """Fits thresholds, options and widths to labelled episodes and writes them as a profile.

    Args:
        episodes: Folders of labelled episodes of one sensor (`magicsim.judge.recorded.read_episode`), every class of
            frame in at least one of them.
        out: TOML file to write.
        base: Profile that gives everything that is not fitted.
        settings: `key=value`: one value or a list for an option that is searched, one value for another of the base.
        read: Episodes of a folder; `magicsim.evaluation.existing.labelled_episodes` reads datasets too.
        told: Hears what takes longer than two seconds.

    Raises:
        MagicsimError: Episodes, settings or the file cannot be used; then nothing is written.
    """
    if out.suffix != ".toml":
        raise ConfigError(f"out = {out} is not allowed; must end in .toml")
    check_file(out)
    if not out.parent.is_dir():
        raise OutputError(f"profile file '{out}' cannot be written: no such folder")
    start, candidates = _search(load_profile(base), settings)
    with waiting("fitting a profile", told):
        labelled = [episode for folder in episodes for episode in read(folder)]
        fitted = fit_profile(start, labelled, candidates)
        profile = fit_widths(fitted.best.profile, labelled)
        for episode in labelled:
            for odd in told_of_references(episode.references, said_of(episode.references, profile)):
                _LOG.warning("%s", odd)
        judged = [_judged(profile, each) for each in labelled]
        seen, unseen = _score(judged, labelled), cross_validate(start, labelled, candidates)
        before = None
        with suppress(FrameError):  # the base's references show no grid
            before = score_profile(start, labelled)
        names = ", ".join(folder.resolve().name for folder in episodes)
        save_profile(profile, out, comment=f"Fitted by magicsim calibrate to {names}.\nValid for that sensor only.")
        classes = scored_classes(labelled)
        return FitSummary(
            profile=str(out),
            options=dataclasses.asdict(profile),
            frames={str(each): classes.count(each) for each in FrameClass},
            candidates=len(fitted.candidates),
            proximity_accuracy=seen.proximity.accuracy,
            contact_accuracy=seen.contact.accuracy,
            cross_validated_proximity_accuracy=unseen.proximity.accuracy if unseen else None,
            cross_validated_contact_accuracy=unseen.contact.accuracy if unseen else None,
            base_proximity_accuracy=before.proximity.accuracy if before else None,
            base_contact_accuracy=before.contact.accuracy if before else None,
            roc=separations(profile, judged, labelled),
        )


def separations(
    profile: DetectorProfile, judged: Sequence[Sequence[Verdict]], episodes: Sequence[Episode]
) -> dict[str, Separation]:
    """ROC of entropy, correlation and similarity on the scored frames; a group without frames leaves its ROC out."""
    pairs = [pair for said, one in zip(judged, episodes, strict=True) for pair in zip(said, one.classes, strict=True)]
    verdicts = [verdict for verdict, each in pairs if each is not None]
    labels = np.array(scored_classes(episodes), dtype=object)
    clear, near, contact, light = (labels == each for each in FrameClass)
    entropy, correlation, similarity = (
        np.array([getattr(each, name) for each in verdicts]) for name in ("entropy", "correlation", "similarity")
    )
    dark = np.array([each.proximity is not Proximity.NOISE for each in verdicts])
    # A similarity below its threshold is a touch, so its sign turns; a value at the threshold is none.
    touch_from = float(np.nextafter(-profile.tau_g, np.inf))
    groups = {
        "brightening": (entropy, near | light, clear, profile.tau_e, profile.tau_e),
        "light": (correlation, light, near | contact, profile.tau_c, profile.tau_c),
        "touch": (-similarity, contact & dark, ~contact & dark, touch_from, profile.tau_g),
    }
    found = {}
    for name, (values, positive, negative, cut, threshold) in groups.items():
        if positive.any() and negative.any():
            group = values[positive | negative], positive[positive | negative]
            curve, (hits, alarms) = roc_curve(*group), rates_at(*group, cut)
            points = list(zip(curve.false_alarm_rate.tolist(), curve.hit_rate.tolist(), strict=True))
            found[name] = Separation(
                area=curve.area, threshold=threshold, hit_rate=hits, false_alarm_rate=alarms, curve=points
            )
    return found


def _search(base: DetectorProfile, settings: Sequence[str]) -> tuple[DetectorProfile, Candidates]:
    """Base and candidates with the settings put in."""
    given: Mapping[str, Any] = apply_overrides({}, settings)
    fixed = {each.name for each in dataclasses.fields(DetectorProfile)}
    searched = {each.name for each in dataclasses.fields(Candidates)}
    fitted = {"tau_e", "tau_c", "tau_g", "entropy_width", "correlation_width", "similarity_width", "schema_version"}
    for key in given:
        if key not in fixed - fitted:
            raise ConfigError(unknown_choice("option", key, fixed - fitted))
    lists = {key: value if isinstance(value, list) else [value] for key, value in given.items() if key in searched}
    for key, values in lists.items():
        for value in values:
            dataclasses.replace(base, **{key: value})  # refuses what is not allowed
        if not values:
            raise ConfigError(f"{key} = [] is not allowed; must hold at least one value")
    others = {key: value for key, value in given.items() if key not in searched}
    return dataclasses.replace(base, **others), dataclasses.replace(Candidates(), **lists)


def score_profile(profile: DetectorProfile, episodes: Sequence[Episode]) -> DetectionScore:
    """Score of one profile on all episodes together, each with its own references."""
    return _score([_judged(profile, episode) for episode in episodes], episodes)


def cross_validate(
    base: DetectorProfile, episodes: Sequence[Episode], candidates: Candidates | None = None
) -> DetectionScore | None:
    """Score of all episodes together, each judged by the profile that `fit_profile` finds without it.

    None where leaving an episode out leaves a class without frames.
    """
    rests = [[each for each in episodes if each is not held] for held in episodes]
    if any(set(scored_classes(rest)) != set(FrameClass) for rest in rests):
        return None
    profiles = [fit_profile(base, rest, candidates).best.profile for rest in rests]
    return _score([_judged(*pair) for pair in zip(profiles, episodes, strict=True)], episodes)


def _judged(profile: DetectorProfile, episode: Episode) -> list[Verdict]:
    return detect_all(episode.frames, fuse(episode.references, profile), profile)


def _score(verdicts: Sequence[Sequence[Verdict]], episodes: Sequence[Episode]) -> DetectionScore:
    return score_verdicts(
        [each for found in verdicts for each in found], [each for episode in episodes for each in episode.classes]
    )
