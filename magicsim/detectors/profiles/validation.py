"""What a fit is worth on episodes that it has not seen: each one judged by a profile fitted to the others."""

from collections.abc import Sequence

from magicsim.detectors.combined import detect_all
from magicsim.detectors.fusion import fuse
from magicsim.detectors.profiles.calibrate import Candidates, fit_profile
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.scoring.episode import Episode, scored_classes
from magicsim.detectors.scoring.score import DetectionScore, score_verdicts
from magicsim.detectors.verdict import Verdict
from magicsim.frame_class import FrameClass


def score_profile(profile: DetectorProfile, episodes: Sequence[Episode]) -> DetectionScore:
    """Score of one profile on all episodes together, each with its own references."""
    return _score([_judged(profile, episode) for episode in episodes], episodes)


def cross_validate(
    base: DetectorProfile, episodes: Sequence[Episode], candidates: Candidates | None = None
) -> DetectionScore | None:
    """Score of all episodes together, each judged by the profile that `fit_profile` finds without it.

    Returns:
        The score; None where leaving an episode out leaves a class without frames.
    """
    rests = [[each for each in episodes if each is not held] for held in episodes]
    if any(set(scored_classes(rest)) != set(FrameClass) for rest in rests):
        return None
    verdicts = [
        _judged(fit_profile(base, rest, candidates).best.profile, held)
        for held, rest in zip(episodes, rests, strict=True)
    ]
    return _score(verdicts, episodes)


def _judged(profile: DetectorProfile, episode: Episode) -> list[Verdict]:
    return detect_all(episode.frames, fuse(episode.references, profile), profile)


def _score(verdicts: Sequence[Sequence[Verdict]], episodes: Sequence[Episode]) -> DetectionScore:
    return score_verdicts(
        [each for found in verdicts for each in found], [each for episode in episodes for each in episode.classes]
    )
