"""What differs from a baseline: the frames, which is the simulator, or what is said of the same frames, the detector.

Falls are tested on frames that are the baseline's own, up to camera noise and the rounding of another processor. Where
they are others, the same measures are told apart, and are no verdict on the detector.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from magicsim.config.program import other_code, versions
from magicsim.errors import ConfigError
from magicsim.evaluation.baseline import ANEW, Baseline, Pair, as_judged, classes_of
from magicsim.judge.regression import Change, compare
from magicsim.judge.tally import FIRST_PLACE, JudgedEpisode


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
    """An evaluation beside a baseline.

    Args:
        baseline: What to compare with.
        episodes: What is said now.
        suite: Name of the present suite.
        detector: Name of the present detector; scores are compared where it is the baseline's.
        seed: Of the exchanges.

    Raises:
        ConfigError: No episode in common, or none with the same frames where the baseline is of another suite.
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
    options: dict[str, Any] = {"seed": seed, "same_scale": baseline.detector == detector}
    changes, moved = (
        compare(pairs, [condition_of(now) for _, now in pairs], **options) if pairs else []
        for pairs in (alike, changed)
    )
    return Comparison(
        baseline=baseline, alike=alike, changed=changed, relabelled=relabelled, changes=changes, moved=moved
    )


def condition_of(episode: JudgedEpisode) -> str:
    """Light and noise of an episode, and its place where that is another than the suite's own."""
    condition = f"{episode.tag.light}/{episode.tag.noise}"
    return condition if episode.tag.place == FIRST_PLACE else f"{condition}/{episode.tag.place}"
