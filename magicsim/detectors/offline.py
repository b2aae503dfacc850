"""Detection from files: a source to judge, a source of references and a profile's name."""

import logging
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from magicsim.detectors.combined import detect
from magicsim.detectors.frame import Frame, check_frame
from magicsim.detectors.fusion import fuse
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.profile_file import load_profile
from magicsim.detectors.source import SourceFrame, read_source
from magicsim.detectors.verdict import Verdict
from magicsim.errors import FrameError

_LOG = logging.getLogger(__name__)


def detect_sources(
    source: str | Path, reference: str | Path, profile: str | Path | DetectorProfile = "published"
) -> list[Verdict]:
    """Judge every frame of a source; logs a warning when there were fewer reference frames than asked for.

    Args:
        source: Image file or folder of images.
        reference: Image file or folder of images of the untouched sensor.
        profile: Shipped name, path of a TOML file, or a profile itself.

    Returns:
        One verdict for each frame, with the frame's file name.

    Raises:
        ConfigError: A source does not exist or holds no image, or the profile is not valid.
        PresetError: There is no such profile.
        FrameError: An image cannot be used; the line names it.
    """
    chosen = profile if isinstance(profile, DetectorProfile) else load_profile(profile)
    frames = read_source(source)
    references = fuse(_reference_images(reference), chosen)
    verdicts = []
    for each in frames:
        with _naming(each):
            verdicts.append(detect(each.image, references, chosen, source=each.name))
    if references.grid.frames < chosen.reference_count:
        _LOG.warning("%d reference frames instead of %d", references.grid.frames, chosen.reference_count)
    return verdicts


def _reference_images(reference: str | Path) -> Iterator[Frame]:
    """Images of the untouched sensor, all of the first one's size."""
    shape: tuple[int, ...] | None = None
    for each in read_source(reference):
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
