"""Contact: how much of the untouched grid does a frame still show?

Published as the third algorithm of the MagicGripper (Fan, Li, Zhang, arXiv 2505.24382). The paper divides
the intersected area by the reference area (`recall`) and leaves open which side of tau_B is the grid; the
other two measures also fall where a frame shows grid that the reference does not.
"""

from dataclasses import dataclass

import cv2

from magicsim.detectors.frame import Frame
from magicsim.detectors.fusion import FULL, GridReference, blur, grid_mask, levelled
from magicsim.detectors.profile import DetectorProfile, Similarity
from magicsim.detectors.verdict import Contact

Areas = tuple[float, float, float]
"""Area of red, green and blue [px]."""


@dataclass(frozen=True, slots=True, kw_only=True)
class GridAreas:
    """How a frame's grid overlaps the reference grid.

    The frame's mask b is 0 or 1 and the reference g is the share of frames in 0..1. For such a pair the
    fuzzy-set intersection min(b, g) and the probabilistic one b g are the same, and so are the unions
    max(b, g) and b + g - b g, so that no choice between them is needed.
    """

    intersection: Areas
    """Sum of b g per channel [px]."""
    frame: Areas
    """Sum of b per channel [px]."""
    reference: Areas
    """Sum of g per channel [px]."""


def grid_areas(frame: Frame, grid: GridReference) -> GridAreas:
    """Measure the overlap of a frame, shape (rows, columns, 3), with a reference of the same shape."""
    return mask_areas(levelled(blur(frame, grid.blur_px, grid.blur_sigma_px), grid.surround_px), grid)


def mask_areas(blurred: Frame, grid: GridReference) -> GridAreas:
    """Areas of the grid in a frame that is blurred and levelled already."""
    mask = grid_mask(blurred, tau_b=grid.tau_b, polarity=grid.polarity)
    shared = cv2.sumElems(cv2.bitwise_and(grid.counts, mask))
    shown = cv2.sumElems(mask)
    count, areas = grid.frames, grid.areas
    return GridAreas(
        intersection=(shared[0] / count, shared[1] / count, shared[2] / count),
        frame=(shown[0] / FULL, shown[1] / FULL, shown[2] / FULL),
        reference=(areas[0] / count, areas[1] / count, areas[2] / count),
    )


def grid_similarity(areas: GridAreas, similarity: Similarity) -> float:
    """Mean similarity S, 0..1, over the channels whose reference shows the grid, of which there is at least one.

    With i the intersection, f the frame's area and r the reference's: `recall` = i / r (published),
    `iou` = i / (f + r - i), `dice` = 2 i / (f + r). 1 means the grid is undisturbed.
    """
    values = [
        _ratio(shared, shown, wanted, similarity)
        for shared, shown, wanted in zip(areas.intersection, areas.frame, areas.reference, strict=True)
        if wanted > 0
    ]
    return sum(values) / len(values)


def _ratio(shared: float, shown: float, wanted: float, similarity: Similarity) -> float:
    """Similarity of one channel from its areas [px]; `wanted` is above 0."""
    if similarity == "recall":
        return shared / wanted
    if similarity == "iou":
        return shared / (shown + wanted - shared)
    return 2 * shared / (shown + wanted)


def decide_contact(similarity: float, profile: DetectorProfile) -> Contact:
    """S < tau_g: Touched; else Untouched."""
    return Contact.TOUCHED if similarity < profile.tau_g else Contact.UNTOUCHED
