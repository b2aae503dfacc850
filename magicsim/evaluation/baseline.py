"""A baseline: what a detector said of every frame of a suite, small enough to be committed.

It knows its frames again, so that what differs now has a name: the frames, which is the simulator, or what is said of
the same frames, which is the detector. Falls are tested on frames that are the baseline's own, up to camera noise and
the rounding of another processor. Where they are others, the same measures are told apart, and are no verdict on the
detector.
"""

import json
import os
import platform
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np

from magicsim.arrays import Array
from magicsim.config.documents import read_json
from magicsim.config.presets import preset_root
from magicsim.config.program import other_code, versions
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.errors import ConfigError
from magicsim.folder import result_file
from magicsim.frame_class import FrameClass
from magicsim.judge.regression import Change, Pair, compare
from magicsim.judge.tally import FIRST_PLACE, FramesSeen, JudgedEpisode

FORMAT = 2
DIGITS = 6
"""Significant digits of a score in the file."""
CLASS_LETTERS = {None: ".", FrameClass.CLEAR: "c", FrameClass.NEAR: "n", FrameClass.CONTACT: "t", FrameClass.LIGHT: "l"}
PROXIMITY_LETTERS = {Proximity.NORMAL: "n", Proximity.APPROACHING: "a", Proximity.NOISE: "x"}
CONTACT_LETTERS = {Contact.TOUCHED: "t", Contact.UNTOUCHED: "u", Contact.UNKNOWN: "?"}
FOLDER = "detectors/baselines"
ANEW = "make it anew with --save-baseline"


@dataclass(frozen=True, slots=True, kw_only=True)
class BaselineEpisode:
    """One episode as a baseline knows it; one letter or number a frame."""

    classes: str
    proximity: tuple[str, ...]
    contact: tuple[str, ...]
    approach: Array
    touch: Array
    seen: FramesSeen


@dataclass(frozen=True, slots=True, kw_only=True)
class Baseline:
    """What a detector said of a suite."""

    suite: str
    detector: str
    episodes: dict[str, BaselineEpisode]
    made_by: dict[str, str]
    """What computed it, see `magicsim.config.program.versions`."""
    made_on: str
    """Day and machine: `2026-11-27, Linux x86_64`."""


def default_baseline(suite: str, profile: str) -> Path | None:
    """The committed baseline of a shipped suite and profile, where there is one."""
    path = preset_root() / FOLDER / f"{suite}-{profile}.json"
    return path if path.is_file() else None


def save_baseline(path: Path, episodes: Sequence[JudgedEpisode], *, suite: str, detector: str) -> None:
    """Writes a baseline; the file appears whole or not at all."""
    packed = {each.tag.name: _packed(each) for each in episodes}
    made_on = f"{date.today().isoformat()}, {platform.system()} {platform.machine()}"
    about = {"format": FORMAT, "suite": suite, "detector": detector, "made_by": versions(), "made_on": made_on}
    text = json.dumps(about | {"episodes": packed}, indent=1)
    with result_file(path) as partial, partial.open("w", encoding="utf-8") as file:
        file.write(text + "\n")
        file.flush()
        os.fsync(file.fileno())


def load_baseline(path: Path) -> Baseline:
    """Reads what `save_baseline` wrote; `ConfigError` where it is not readable, or of another format."""
    try:
        content = read_json(path)
    except ConfigError as error:
        raise ConfigError(f"baseline: {error}") from None
    if isinstance(content, dict) and content.get("format", FORMAT) != FORMAT:
        raise ConfigError(f"baseline '{path}': format = {content['format']!r} is not allowed: must be {FORMAT}; {ANEW}")
    try:
        episodes = {name: _unpacked(each) for name, each in content["episodes"].items()}
        about = {name: str(content[name]) for name in ("suite", "detector", "made_on")}
        return Baseline(**about, episodes=episodes, made_by=dict(content["made_by"]))
    except (KeyError, TypeError, AttributeError, IndexError, ValueError) as error:
        raise ConfigError(f"baseline '{path}' is not one that magicsim wrote: {error!r}") from None


def as_judged(known: BaselineEpisode, now: JudgedEpisode) -> Pair:
    """An episode as the baseline's detector judged it, and as the present one did, with scores alike rounded."""
    said = {name: getattr(known, name) for name in ("proximity", "contact", "approach", "touch", "seen")}
    then = replace(now, **said)
    return then, replace(now, approach=_rounded(now.approach), touch=_rounded(now.touch))


def _rounded(scores: Array) -> Array:
    """Scores as the file would give them back, so that a rerun compares as equal."""
    return np.array([float(f"{each:.{DIGITS}g}") for each in scores])


def classes_of(episode: JudgedEpisode) -> str:
    """Classes of an episode's frames, a letter each."""
    return "".join(CLASS_LETTERS[each] for each in episode.labels.classes)


def _packed(episode: JudgedEpisode) -> dict[str, Any]:
    return {
        "classes": classes_of(episode),
        "proximity": "".join(PROXIMITY_LETTERS[Proximity(each)] for each in episode.proximity),
        "contact": "".join(CONTACT_LETTERS[Contact(each)] for each in episode.contact),
        "approach": " ".join(f"{each:.{DIGITS}g}" for each in episode.approach),
        "touch": " ".join(f"{each:.{DIGITS}g}" for each in episode.touch),
        "levels": " ".join(f"{each:.3f}" for each in episode.seen.levels),
        "look": " ".join(f"{each:.3f}" for each in episode.seen.look),
        "digest": episode.seen.digest,
    }


def _unpacked(entry: dict[str, str]) -> BaselineEpisode:
    words = {letter: str(word) for word, letter in PROXIMITY_LETTERS.items()}
    touches = {letter: str(word) for word, letter in CONTACT_LETTERS.items()}
    number = {name: [*map(float, entry.get(name, "").split())] for name in ("approach", "touch", "levels", "look")}
    counts = {len(entry[name]) for name in ("classes", "proximity", "contact")}
    if len(counts | {len(number[name]) for name in ("approach", "touch", "levels")}) != 1:
        raise IndexError("lists of different length")
    return BaselineEpisode(
        classes=entry["classes"], proximity=tuple(words[letter] for letter in entry["proximity"]),
        contact=tuple(touches[letter] for letter in entry["contact"]), approach=np.array(number["approach"]),
        touch=np.array(number["touch"]),
        seen=FramesSeen(digest=entry["digest"], levels=tuple(number["levels"]), look=tuple(number["look"])),
    )  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class Comparison:
    """An evaluation beside a baseline."""

    baseline: Baseline
    alike: list[Pair]
    """Episodes on the baseline's own frames, as its detector and as the present one judged them."""
    changed: list[Pair]
    """Those whose frames are others now, likewise."""
    relabelled: list[str]
    """Names of those whose frames have other classes now: nothing of them can be compared."""
    changes: list[Change]
    """Measures on the baseline's own frames."""
    moved: list[Change]
    """Measures on frames that are others now."""

    @property
    def code(self) -> str | None:
        """What made the baseline, where that is not the present code."""
        return other_code(self.baseline.made_by, versions())

    @property
    def verdicts_changed(self) -> list[str]:
        """Names of episodes on the same frames of which something else is said now."""
        return [
            now.tag.name for then, now in self.alike if (then.proximity, then.contact) != (now.proximity, now.contact)
        ]

    @property
    def frames_changed(self) -> list[str]:
        """Names of episodes whose frames or classes are others now."""
        return [*(now.tag.name for _, now in self.changed), *self.relabelled]

    @property
    def lines(self) -> list[str]:
        """For people: who changed what."""
        frames, said, all_of = len(self.frames_changed), len(self.verdicts_changed), len(self.alike)
        lines = []
        if frames:
            code = f"by {self.code}" if self.code else "by the present code"
            lines.append(
                f"the frames changed (simulator): {frames} of {frames + all_of} episodes since the baseline was made "
                f"{code} on {self.baseline.made_on}; falls there are not the detector's; {ANEW}"
            )
        return [*lines, f"the verdicts changed (detector): {said} of {all_of} episodes with the same frames"]

    def as_dict(self) -> dict[str, Any]:
        """What goes into the JSON."""
        return {
            "baseline_made_by": self.baseline.made_by, "baseline_made_on": self.baseline.made_on,
            "other_code": self.code, "frames_changed": self.frames_changed, "verdicts_changed": self.verdicts_changed,
            "compared_on_changed_frames": [asdict(each) | {"frames": len(each.frames)} for each in self.moved],
        }  # fmt: skip


def set_beside(
    baseline: Baseline, episodes: Sequence[JudgedEpisode], *, suite: str, detector: str, seed: int
) -> Comparison:
    """An evaluation beside a baseline; its first episode has the standard condition.

    Scores are compared where the detector is the baseline's; `seed` is that of the exchanges. `ConfigError` where no
    episode is in common, or none with the same frames and the baseline is of another suite.
    """
    alike: list[Pair] = []
    changed: list[Pair] = []
    relabelled = []
    for now in episodes:
        known = baseline.episodes.get(now.tag.name)
        if known is not None and known.classes != classes_of(now):
            relabelled.append(now.tag.name)
        elif known is not None:
            pair = as_judged(known, now)
            (alike if pair[0].seen.is_alike(now.seen) else changed).append(pair)
    other = [*changed, *relabelled]
    if not alike and (baseline.suite != suite or not other):
        share = "frames" if other else "episode"
        raise ConfigError(f"baseline of suite '{baseline.suite}' has no {share} in common with suite '{suite}'; {ANEW}")
    standard, same_scale = condition_of(episodes[0]), Path(baseline.detector) == Path(detector)

    def compared(pairs: list[Pair]) -> list[Change]:
        conditions = [condition_of(now) for _, now in pairs]
        return compare(pairs, conditions, standard=standard, seed=seed, same_scale=same_scale) if pairs else []

    return Comparison(
        baseline=baseline, alike=alike, changed=changed, relabelled=relabelled, changes=compared(alike),
        moved=compared(changed),
    )  # fmt: skip


def condition_of(episode: JudgedEpisode) -> str:
    """Light and noise of an episode, and its place where that is another than the suite's own."""
    condition = f"{episode.tag.light}/{episode.tag.noise}"
    return condition if episode.tag.place == FIRST_PLACE else f"{condition}/{episode.tag.place}"
