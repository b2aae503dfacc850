"""Runs the detectors over an episode and scores them against its ground truth."""

from magicsim.detectors.combined import detect_all
from magicsim.detectors.fusion import fuse
from magicsim.detectors.profiles.profile_file import load_profile
from magicsim.detectors.scoring.score import score_verdicts
from magicsim.simulation.episode import Episode, Judgement

PROFILES = ("calibrated", "published")
"""Profiles that every report shows; scores of the first one are the headline."""


def judge(episode: Episode, profile_name: str) -> Judgement:
    """Verdicts of one profile on the frames after the references, and their score.

    Args:
        episode: With reference frames.
        profile_name: Profile preset or TOML file.

    Raises:
        FrameError: Too few reference frames, or they show no grid.
        PresetError: No such profile.
    """
    profile = load_profile(profile_name)
    references = fuse([frame.image for frame in episode.references], profile)
    verdicts = detect_all([frame.image for frame in episode.scored], references, profile)
    score = score_verdicts(verdicts, [frame.truth.frame_class for frame in episode.scored])
    return Judgement(
        profile=profile_name,
        thresholds={"tau_e": profile.tau_e, "tau_c": profile.tau_c, "tau_g": profile.tau_g},
        verdicts=tuple(verdicts),
        score=score,
    )
