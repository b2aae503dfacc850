"""What could tell a teleoperator that plug and base meet: SSIM of the frames, the contact detector, the force label.

SSIM is scikit-image's (extra `task`), on RGB frames of 8 bits, against the mean of the frames without a grasped object.
"""

from collections.abc import Callable, Sequence
from dataclasses import astuple, dataclass

import numpy as np

from magicsim.arrays import Frame
from magicsim.detectors.combined import detect
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.profile import DetectorProfile, load_profile
from magicsim.errors import ConfigError
from magicsim_experiments.assembly.stages import TrialStage
from magicsim_experiments.assembly.trial import Moment

Similarity = Callable[[Frame, Frame], float]
PROFILE = "calibrated"
GREY_LEVELS = 255


@dataclass(frozen=True, slots=True, kw_only=True)
class Cues:
    """One step of a trial, as its cues are."""

    stage: TrialStage
    outcome: str
    ssim: float
    """Mean of both fingers' SSIM, 1 for the image without a grasped object."""
    ssim_fingers: tuple[float, float]
    """Upper and lower finger."""
    similarity: float
    """Mean grid similarity S of both fingers, which the contact detector judges, 0..1."""
    verdicts: tuple[str, str]
    """Contact verdict of the upper and of the lower finger, read together with proximity."""
    time_s: float
    """Since the fingers began to close [s]."""
    force_n: tuple[float, ...]
    """Label: force of the base on the plug in the gripper's frame; of the last balance where it is lost [N]."""
    force_size_n: float
    """Size of that force [N]."""
    torque_nmm: tuple[float, ...]
    """Label: its torque about the plug's origin [N mm]."""
    normal_n: float
    """Label: mean normal force of the fingers [N]."""
    slid_mm: float
    """Label: how far the plug slid in the grip on the way to this step [mm]."""
    place: tuple[float, ...]
    """Label: the plug in the gripper's frame: x, y, z [mm], twist, tilt about x and about y [degrees]."""
    limit: str | None
    """The coordinate of it at whose end in the workspace the plug was lost."""


def check_references(count: int) -> None:
    """Refuses a number of reference frames of which nothing can be learned, before any is rendered."""
    least = load_profile(PROFILE).background_count
    if count < least:
        raise ConfigError(f"references = {count} is not allowed with task assembly: must be at least {least}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """What is known of both fingers without an object, against which frames are read."""

    empty: tuple[Frame, Frame]
    """Mean frame of each finger."""
    references: tuple[References, References]
    profile: DetectorProfile

    @classmethod
    def learned(cls, references: tuple[Sequence[Frame], Sequence[Frame]]) -> "Reader":
        """From frames of the upper and of the lower finger with nothing between them.

        Args:
            references: At least as many as the profile's temporal fusion takes.
        """
        found = load_profile(PROFILE)
        upper, lower = (np.mean(frames, axis=0).round().astype(np.uint8) for frames in references)
        return cls(
            empty=(upper, lower), references=(fuse(references[0], found), fuse(references[1], found)), profile=found
        )

    def read(self, moment: Moment) -> Cues:
        """All cues of one step."""
        similarity = structural_similarity()
        ssim = [similarity(image, empty) for image, empty in zip(moment.images, self.empty, strict=True)]
        verdicts = [detect(image, own, self.profile) for image, own in zip(moment.images, self.references, strict=True)]
        return Cues(
            stage=moment.step.stage, outcome=moment.outcome.value, ssim=float(np.mean(ssim)),
            ssim_fingers=(ssim[0], ssim[1]), similarity=float(np.mean([verdict.similarity for verdict in verdicts])),
            verdicts=(verdicts[0].combined.value, verdicts[1].combined.value), time_s=moment.time_s,
            force_n=moment.base_force_n, force_size_n=float(np.linalg.norm(moment.base_force_n)),
            torque_nmm=moment.base_torque_nmm, normal_n=moment.normal_n, slid_mm=moment.slid_mm,
            place=astuple(moment.place), limit=moment.limit,
        )  # fmt: skip


def structural_similarity() -> Similarity:
    """SSIM of two RGB frames, mean over pixels and channels (Wang et al. 2004), 1 for equal ones."""
    try:
        from skimage.metrics import structural_similarity as ssim
    except ImportError:
        msg = "SSIM needs the package scikit-image, which is not installed: pip install 'magicsim-experiments[task]'"
        raise ConfigError(msg) from None

    def similarity(image: Frame, other: Frame) -> float:
        return float(ssim(image, other, channel_axis=-1, data_range=GREY_LEVELS))  # type: ignore[no-untyped-call]

    return similarity
