"""Detection on sources: one to judge, one of references, and a profile's name."""

import logging
from collections.abc import Generator, Iterator
from contextlib import closing, contextmanager
from itertools import islice
from pathlib import Path

from magicsim.detectors.at_rest import FeatureAtRest, features_at_rest, marked
from magicsim.detectors.combined import detect
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import References, fuse
from magicsim.detectors.profiles.profile import DetectorProfile
from magicsim.detectors.profiles.profile_file import load_profile
from magicsim.detectors.sources.source import SourceFrame, read_source, source_kind
from magicsim.detectors.verdict import Contact, Proximity, Verdict
from magicsim.errors import ConfigError, FrameError
from magicsim.waiting import Told, on_stderr, waiting

_LOG = logging.getLogger(__name__)


def detect_sources(
    source: str | Path,
    reference: str | Path,
    profile: str | Path | DetectorProfile = "published",
    *,
    frames: int | None = None,
    told: Told = on_stderr,
) -> list[Verdict]:
    """Judge every frame of a source.

    Logs a warning when there were fewer reference frames than asked for, or some that do not look untouched.

    Args:
        source: Image file, folder of images, video file, or index of a camera.
        reference: The same, of the untouched sensor; its first `reference_count` frames are taken.
        profile: Shipped name, path of a TOML file, or a profile itself.
        frames: Most frames to judge; needed for a camera, which never ends.
        told: Hears what takes longer than two seconds.

    Returns:
        One verdict for each frame, with the frame's name.

    Raises:
        ConfigError: A source does not exist or holds no image, a camera without `frames`, or the profile is not valid.
        PresetError: There is no such profile.
        FrameError: An image, a video or a camera cannot be used; the line names it.
    """
    if frames is None and source_kind(source) == "camera":
        msg = f"frames is missing: camera {source} never ends; give the number of frames to judge"
        raise ConfigError(msg)
    with waiting("judging frames", told):
        return list(stream_sources(source, reference, profile, frames=frames))


def stream_sources(
    source: str | Path,
    reference: str | Path,
    profile: str | Path | DetectorProfile = "published",
    *,
    frames: int | None = None,
) -> Iterator[Verdict]:
    """As `detect_sources`, one verdict at a time, so that a camera can be judged for as long as it runs."""
    if frames is not None and frames < 1:
        msg = f"frames = {frames} is not allowed; must be a whole number of at least 1"
        raise ConfigError(msg)
    chosen = profile if isinstance(profile, DetectorProfile) else load_profile(profile)
    with closing(read_source(source)) as judged:
        references, resting = fuse_source(reference, chosen)
        for each in islice(judged, frames):
            with _naming(each):
                verdict = detect(each.image, references, chosen, source=each.name)
            yield marked(verdict, resting)
    if references.grid.frames < chosen.reference_count:
        _LOG.warning("%d reference frames instead of %d", references.grid.frames, chosen.reference_count)


def fuse_source(reference: str | Path, profile: DetectorProfile) -> tuple[References, dict[str, FeatureAtRest]]:
    """References from the first frames of a source of the untouched sensor, and what E, C and S are on these.

    Raises:
        MagicsimError: As `detect_sources`.
    """
    with closing(_reference_images(reference)) as images:
        taken = list(islice(images, profile.reference_count))
    references = fuse(taken, profile)
    verdicts = [detect(image, references, profile) for image in taken]
    odd = [number for number, verdict in enumerate(verdicts) if not _is_untouched(verdict)]
    if odd:
        first = verdicts[odd[0]]
        _LOG.warning(
            "%d of %d reference frames do not look untouched beside the others, the first of them frame %d (%s, %s); "
            "references are frames of the untouched sensor",
            len(odd), len(taken), odd[0], first.proximity, first.combined,
        )  # fmt: skip
    return references, features_at_rest(verdicts)


def _is_untouched(verdict: Verdict) -> bool:
    return verdict.proximity is Proximity.NORMAL and verdict.combined is Contact.UNTOUCHED


def _reference_images(reference: str | Path) -> Generator[Frame, None, None]:
    """Images of the untouched sensor, all of the first one's size."""
    shape: tuple[int, ...] | None = None
    with closing(read_source(reference)) as frames:
        for each in frames:
            with _naming(each):
                image = check_frame(each.image, shape=shape)
            shape = image.shape
            yield image


@contextmanager
def _naming(frame: SourceFrame) -> Iterator[None]:
    """Add the frame's name to what is wrong with it."""
    try:
        yield
    except FrameError as error:
        msg = f"image '{frame.name}': {error}"
        raise FrameError(msg) from error
