"""Combined detection: both algorithms on one frame, read together; for single frames, batches and streams.

Outside light changes the grid's look as a touch does, so a frame that proximity calls Noise is no evidence
of contact (Fan, Li, Zhang, arXiv 2505.24382). The references are the only memory: a stream is a loop over
`detect`.
"""

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy.typing as npt

from magicsim.detectors.features import (
    brightening,
    decide_contact,
    decide_proximity,
    filter_channels,
    grid_areas,
    grid_similarity,
)
from magicsim.detectors.frame import check_frame
from magicsim.detectors.profile import DetectorProfile
from magicsim.detectors.rest import References
from magicsim.detectors.verdict import Contact, Proximity, Verdict
from magicsim.errors import ConfigError


def detect(
    frame: npt.ArrayLike, references: References, profile: DetectorProfile, *, source: str | None = None
) -> Verdict:
    """Judge one frame.

    Args:
        frame: RGB image, uint8, shape (rows, columns, 3), same exposure as the references.
        references: From `fuse` with the same profile; its thresholds tau_e, tau_c and tau_g may differ.
        profile: Thresholds and options.
        source: Where the frame came from, kept in the verdict.

    Raises:
        FrameError: The frame is not an image of the references' size, or the references show no grid.
        ConfigError: The references were fused with other options than the profile's.
    """
    _check_match(references, profile)
    rest = references.rest
    if rest is not None:
        image = check_frame(frame, shape=rest.shape)
        told = rest.relative(rest.features(rest.matched(image), references, profile), profile)
    else:
        image = check_frame(frame, shape=references.background.ceiling.shape)
        similarity = grid_similarity(grid_areas(image, references.grid), profile.similarity)
        told = (*brightening(filter_channels(image, references.background), profile), similarity)
    return judge(entropy=told[0], correlation=told[1], similarity=told[2], profile=profile, source=source)


def detect_stream(
    frames: Iterable[npt.ArrayLike], references: References, profile: DetectorProfile
) -> Iterator[Verdict]:
    """Judge frames as they arrive, units of rest following; raises what `detect` raises, at the frame that is wrong."""
    for frame in frames:
        verdict = detect(frame, references, profile)
        yield verdict
        references = followed(references, verdict, profile)


def detect_all(frames: Iterable[npt.ArrayLike], references: References, profile: DetectorProfile) -> list[Verdict]:
    """Judge a batch of frames in their order; the same as a loop over `detect` where thresholds are fixed."""
    return list(detect_stream(frames, references, profile))


def followed(references: References, verdict: Verdict, profile: DetectorProfile) -> References:
    """References for the next frame: units of rest follow slow drift, fixed thresholds stay."""
    if references.rest is None:
        return references
    return replace(references, rest=references.rest.followed(verdict, profile))


def judge(
    *, entropy: float, correlation: float, similarity: float, profile: DetectorProfile, source: str | None = None
) -> Verdict:
    """Verdicts and probabilities from the three features: E [bit], C in -1..1 and S in 0..1.

    With L the logistic function, b = L((E - tau_e) / entropy_width) says that something brightens and
    a = L((C - tau_c) / correlation_width) that it does so alike: p_approach = b (1 - a), p_noise = b a, and
    1 - b is left for Normal. p_touch = L((tau_g - S) / similarity_width), of the frame alone, so that outside light,
    which changes S too, is not taken out of it. All are monotone: p_approach rises with E and falls with C, p_noise
    rises with both, p_touch falls with S; and b, a and p_touch are one half at their thresholds.

    The paper names the distances to the thresholds as the source of its probabilities; the form is assumed. With
    widths from `magicsim.detectors.thresholds.fit_widths` (as `magicsim fit profile` writes them) b, a and p_touch
    are calibrated: each is the share of positives among training frames at that distance, were both groups as frequent.
    With other widths, `published` among them, they rank frames and say no share.
    """
    brighter = logistic((entropy - profile.tau_e) / profile.entropy_width)
    alike = logistic((correlation - profile.tau_c) / profile.correlation_width)
    touched = logistic((profile.tau_g - similarity) / profile.similarity_width)
    proximity, contact = decide_proximity(entropy, correlation, profile), decide_contact(similarity, profile)
    return Verdict(
        entropy=entropy, correlation=correlation, similarity=similarity, p_approach=brighter * (1.0 - alike),
        p_noise=brighter * alike, p_touch=touched, proximity=proximity, contact=contact,
        combined=combine(proximity, contact), source=source,
    )  # fmt: skip


def combine(proximity: Proximity, contact: Contact) -> Contact:
    """The contact verdict, or `Unknown` where proximity says `Noise`."""
    return Contact.UNKNOWN if proximity is Proximity.NOISE else contact


def behind_coat(verdict: Verdict) -> Verdict:
    """The verdict of a sensor that sees nothing outside: nothing is near, no light shines in, S alone tells a touch."""
    return replace(verdict, proximity=Proximity.NORMAL, combined=verdict.contact)


def logistic(distance: float) -> float:
    """1 / (1 + exp(-distance)), which never overflows."""
    return 0.5 * (1.0 + math.tanh(0.5 * distance))


def _check_match(references: References, profile: DetectorProfile) -> None:
    """Refuse references that were fused with other options than the profile's."""
    grid, background, units = references.grid, references.background, "fixed" if references.rest is None else "rest"
    tau_b = profile.tau_b if units == "fixed" else grid.tau_b
    for name, fused, wanted in (
        ("units", units, profile.units),
        ("tau_b", grid.tau_b, tau_b),
        ("polarity", grid.polarity, profile.polarity),
        ("grid_blur_px", grid.blur_px, profile.grid_blur_px),
        ("grid_blur_sigma_px", grid.blur_sigma_px, profile.grid_blur_sigma_px),
        ("grid_reference", grid.kind, profile.grid_reference),
        ("surround_px", grid.surround_px, profile.surround_px),
        ("difference_blur_px", background.blur_px, profile.difference_blur_px),
        ("background_count", len(background.images), profile.background_count),
    ):
        if fused != wanted:
            raise ConfigError(f"{name} = {wanted!r}, but the references were fused with {fused!r}; fuse them again")
