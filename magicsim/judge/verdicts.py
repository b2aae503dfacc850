"""Runs the detectors with the standard profiles: over an episode, scored against its truth, and on single frames."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self

from magicsim.arrays import Frame
from magicsim.detectors.combined import behind_coat, detect, detect_all
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.detectors.verdict import FeatureAtRest, Verdict, features_at_rest, marked
from magicsim.errors import MagicsimError
from magicsim.judge.score import DetectionScore, score_verdicts
from magicsim.simulation.episode import Episode
from magicsim.waiting import Told, on_stderr, waiting

PROFILES = ("calibrated", "published")
"""Profiles that every report shows; scores of the first one are the headline."""
COATED = "proximity: design.coat is opaque, and nothing outside is seen"
"""What is not judged of a coated sensor, and why."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Judgement:
    """What the detectors with one profile say about an episode's frames after the references."""

    profile: str
    """Name of the profile."""
    thresholds: dict[str, float]
    """tau_e, tau_c, tau_g of the profile."""
    verdicts: tuple[Verdict, ...]
    """One per frame after the references, in order."""
    score: DetectionScore
    """Against ground truth."""
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
        """A profile fused with frames of the untouched sensor, RGB of shape (rows, columns, 3), in order of time.

        Raises:
            FrameError: Too few frames, or they show no grid.
        """
        references = fuse(untouched, profile)
        rest = features_at_rest(detect_all(untouched, references, profile))
        return cls(profile=profile, references=references, rest=rest, is_coated=is_coated)

    def verdict(self, frame: Frame, *, source: str | None = None) -> Verdict:
        """The verdict on a frame, with whether it rests on less than the camera's own repeatability."""
        verdict = detect(frame, self.references, self.profile, source=source)
        return marked(behind_coat(verdict) if self.is_coated else verdict, self.rest)


def judge(episode: Episode, profile_name: str, *, told: Told = on_stderr) -> Judgement:
    """Verdicts of one profile on the frames after the references, and their score.

    Behind an opaque coat every proximity is `Normal`, which says nothing: see `COATED`.

    Args:
        episode: With reference frames.
        profile_name: Profile preset or TOML file.
        told: Hears what takes longer than two seconds.

    Raises:
        FrameError: Too few reference frames, or they show no grid.
        PresetError: No such profile.
    """
    profile = load_profile(profile_name)
    with waiting(f"judging {len(episode.frames)} frames", told):
        untouched = [frame.image for frame in episode.references]
        detector = SensorDetector.of(untouched, profile, is_coated=episode.scene.design.is_opaque)
        verdicts = tuple(detector.verdict(frame.image) for frame in episode.scored)
    return Judgement(
        profile=profile_name,
        thresholds={"tau_e": profile.tau_e, "tau_c": profile.tau_c, "tau_g": profile.tau_g},
        verdicts=verdicts,
        score=score_verdicts(verdicts, [frame.truth.frame_class for frame in episode.scored]),
        at_rest=detector.rest,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class FusedProfiles:
    """The standard profiles with their references of one sensor, for single frames."""

    fused: dict[str, tuple[DetectorProfile, References] | str]
    """Each profile with its references, or why it refuses the sensor."""

    @classmethod
    def of(cls, untouched: Sequence[Frame]) -> Self:
        """The profiles fused from frames of the untouched sensor, RGB of shape (rows, columns, 3), in order of time."""
        fused: dict[str, tuple[DetectorProfile, References] | str] = {}
        for name in PROFILES:
            profile = load_profile(name)
            try:
                fused[name] = (profile, fuse(untouched, profile))
            except MagicsimError as error:
                fused[name] = str(error)
        return cls(fused=fused)

    def verdicts(self, frame: Frame) -> dict[str, Verdict | str]:
        """What each profile says about a frame, or why it says nothing."""
        return {
            name: each if isinstance(each, str) else detect(frame, each[1], each[0])
            for name, each in self.fused.items()
        }
