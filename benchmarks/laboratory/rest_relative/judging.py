"""What `rest-relative` and profiles with fixed thresholds say of recordings, and which fall of S would be best."""

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

import cv2
import numpy as np
import numpy.typing as npt

from laboratory.rest_relative.cameras import Recording
from magicsim.detectors import Verdict, detect_all, fuse, load_profile, with_touches
from magicsim.detectors.verdict import Contact, Proximity
from magicsim.errors import MagicsimError
from magicsim.frame_class import FrameClass

PROFILE = load_profile("rest-relative")
FALLS = np.geomspace(0.001, 0.3, 100)
"""Falls of S, in shares of rest, from which a frame may be touched."""
ALIKE = 0.01
"""Balanced accuracies that differ by less are alike."""
FIXED_SCALE = 2
"""By how much frames are enlarged for profiles whose kernels are in pixels of 240 x 320."""
FIRM_MM = 0.6
"""Depth of the own first touches that are shown, at least [mm]."""
MEASURES = {
    "balanced": "contact, balanced over touched and untouched (near and light included)",
    "touched": "touched frames called Touched",
    "clear": "clear frames called Touched",
    "near": "near frames called Touched",
    "light": "flashlight frames called Touched",
    "near_balanced": "near (Approaching) against clear (Normal), balanced",
}
Curve = npt.NDArray[np.float64]
"""Shares of touched, clear and near frames beyond each of `FALLS`, shape (3, falls)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Reading:
    """Measures of one recording; None where it has no such frame."""

    name: str
    measures: Mapping[str, float | None]


def judge(recording: Recording, *, fall: float | None = None, with_own_touches: bool = False) -> Reading:
    """Measures by `rest-relative`, with another fall of S or with thresholds from own touches."""
    profile = PROFILE if fall is None else replace(PROFILE, tau_g=1 - fall)
    references = fuse(recording.references, profile)
    if with_own_touches:
        firm = np.flatnonzero(recording.depth_mm >= FIRM_MM)[:3].tolist()
        with suppress(MagicsimError):  # S does not fall: one would do without
            references = with_touches(references, [recording.frames[each] for each in firm], profile)
    return _measured(recording, detect_all(recording.frames, references, profile))


def judge_fixed(recording: Recording, name: str) -> Reading:
    """Measures by a profile with fixed thresholds, of frames at its own scale; a refusal is no touch."""
    profile, (rows, columns) = load_profile(name), recording.frames[0].shape[:2]

    def enlarged(frame: npt.NDArray[np.uint8]) -> npt.NDArray[np.uint8]:
        size = (FIXED_SCALE * columns, FIXED_SCALE * rows)
        return np.asarray(cv2.resize(frame, size, interpolation=cv2.INTER_LINEAR), dtype=np.uint8)

    try:
        references = fuse([enlarged(each) for each in recording.references], profile)
    except MagicsimError:
        return Reading(name=recording.name, measures=dict.fromkeys(MEASURES))
    return _measured(recording, detect_all([enlarged(each) for each in recording.frames], references, profile))


def _measured(recording: Recording, verdicts: Sequence[Verdict]) -> Reading:
    classes = np.array(recording.classes, dtype=object)
    called = np.array([each.combined is Contact.TOUCHED for each in verdicts])
    proximity = np.array([each.proximity for each in verdicts], dtype=object)
    clear, near, contact, light = (classes == each for each in FrameClass)

    def share(which: npt.NDArray[np.bool_], of: npt.NDArray[np.bool_]) -> float | None:
        return float(which[of].mean()) if of.any() else None

    normal, approaching = share(proximity == Proximity.NORMAL, clear), share(proximity == Proximity.APPROACHING, near)
    return Reading(
        name=recording.name,
        measures={
            "balanced": float(called[contact].mean() + 1 - called[clear | near | light].mean()) / 2,
            "touched": share(called, contact), "clear": share(called, clear), "near": share(called, near),
            "light": share(called, light),
            "near_balanced": None if normal is None or approaching is None else (normal + approaching) / 2,
        },
    )  # fmt: skip


def falls(recording: Recording) -> Curve:
    """Shares beyond each fall, frames called Noise as untouched."""
    verdicts = detect_all(recording.frames, fuse(recording.references, PROFILE), PROFILE)
    fall = np.array([-1.0 if each.proximity is Proximity.NOISE else 1 - each.similarity for each in verdicts])
    classes = np.array(recording.classes, dtype=object)
    groups = [fall[classes == each] for each in (FrameClass.CONTACT, FrameClass.CLEAR, FrameClass.NEAR)]
    return np.array([[(each > cut).mean() if len(each) else 0.0 for cut in FALLS] for each in groups])


def thresholds(by_type: Mapping[str, Sequence[Curve]]) -> dict[str, Any]:
    """The fall with the best balanced accuracy, near and clear frames as often, each type weighing the same.

    The middle, in ratios, of the falls that are alike.
    """
    means = [np.mean(each, axis=0) for each in by_type.values()]
    balanced = np.mean([(touched + 1 - (clear + near) / 2) / 2 for touched, clear, near in means], axis=0)
    alike = FALLS[balanced >= balanced.max() - ALIKE]
    middle = float(np.sqrt(alike[0] * alike[-1]))
    return {"fall": round(middle, 5), "alike": [round(float(each), 5) for each in (alike[0], alike[-1])]}
