"""Faults put into the built-in detectors on purpose: what `evaluate` must notice, and reruns that it must not."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from magicsim.detectors.profile import DetectorProfile
from magicsim.evaluation.detector import Detection, Detector, ProfileDetector

Frame = npt.NDArray[np.uint8]
SWAPPED = [1, 0, 2]
"""Channels in the order red and green exchanged."""
DELAY, STUCK, DROPPED = 2, 10, 2
"""Frames that an answer comes late, after which it stays, and of which one answer is made."""


class OtherFrames:
    """The built-in detectors that see other references, or other frames once the references are taken."""

    def __init__(self, profile: DetectorProfile, *, seen: "Change", is_reference: bool = False) -> None:
        """Takes thresholds and options, and what becomes of a frame or of a reference."""
        self._inner, self._seen, self._is_reference = ProfileDetector(profile), seen, is_reference

    def fit(self, references: Sequence[Frame]) -> None:
        """See `magicsim.evaluation.detector.Detector`."""
        self._inner.fit([self._seen(each) for each in references] if self._is_reference else references)

    def step(self, frame: Frame) -> Detection:
        """See `magicsim.evaluation.detector.Detector`."""
        return self._inner.step(frame if self._is_reference else self._seen(frame))


class OtherAnswers:
    """The built-in detectors whose answers are tampered with."""

    def __init__(self, profile: DetectorProfile, answer: "Answer") -> None:
        """Takes thresholds and options, and the answer that follows from all right ones so far."""
        self._inner, self._answer = ProfileDetector(profile), answer
        self._right: list[Detection] = []

    def fit(self, references: Sequence[Frame]) -> None:
        """See `magicsim.evaluation.detector.Detector`."""
        self._inner.fit(references)

    def step(self, frame: Frame) -> Detection:
        """See `magicsim.evaluation.detector.Detector`."""
        self._right.append(self._inner.step(frame))
        return self._answer(self._right)


Change = Callable[[Frame], Frame]
Answer = Callable[[Sequence[Detection]], Detection]


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One fault."""

    says: str
    make: Callable[[DetectorProfile], Detector]
    """From the sound profile to the faulty detector."""


def _changed(says: str, change: Callable[[DetectorProfile], DetectorProfile]) -> Fault:
    return Fault(says=says, make=lambda profile: ProfileDetector(change(profile)))


def _off(name: str, factor: float) -> Fault:
    """A threshold off by a factor; that of grey levels is a whole number of at most 255."""

    def change(profile: DetectorProfile) -> DetectorProfile:
        value = factor * getattr(profile, name)
        return replace(profile, **{name: min(255, round(value)) if name == "tau_b" else value})

    return _changed(f"{name} times {factor:.3g}", change)


def _seen(says: str, seen: Change, *, is_reference: bool = False) -> Fault:
    return Fault(says=says, make=lambda profile: OtherFrames(profile, seen=seen, is_reference=is_reference))


def _answered(says: str, answer: Answer) -> Fault:
    return Fault(says=says, make=lambda profile: OtherAnswers(profile, answer))


def _always(**verdicts: Any) -> Fault:  # noqa: ANN401 - fields of a detection, each of a type of its own
    return _answered(f"always {' and '.join(verdicts.values())}", lambda right: replace(right[-1], **verdicts))


def _exchanged(field: str, one: str, other: str) -> Fault:
    to = {one: other, other: one}
    return _answered(
        f"{one} and {other} exchanged",
        lambda right: replace(right[-1], **{field: to.get(getattr(right[-1], field), getattr(right[-1], field))}),
    )


def _after_light(right: Sequence[Detection]) -> Detection:
    """Once it has seen a flashlight it takes everything for a touch."""
    seen = any(each.proximity == "Noise" for each in right[:-1])
    return replace(right[-1], proximity="Normal", contact="Touched", touch=1.0) if seen else right[-1]


def swapped(frame: Frame) -> Frame:
    """A frame of a camera whose red and green are exchanged."""
    return np.ascontiguousarray(frame[..., SWAPPED])


def _mirrored(frame: Frame) -> Frame:
    return np.ascontiguousarray(frame[:, ::-1])


def _without_red(frame: Frame) -> Frame:
    return frame * np.array([0, 1, 1], np.uint8)


def _dimmed(frame: Frame) -> Frame:
    return (frame * 0.7).astype(np.uint8)


FAULTS: Mapping[str, Fault] = {
    "kernel": _changed("grid_blur_px = 9", lambda profile: replace(profile, grid_blur_px=9)),
    "tau_b_low": _off("tau_b", 0.8),
    "tau_b_high": _off("tau_b", 1.2),
    "tau_e_low": _off("tau_e", 0.8),
    "tau_e_high": _off("tau_e", 1.2),
    "tau_c_low": _off("tau_c", 0.8),
    "tau_g_low": _off("tau_g", 0.8),
    "tau_e_1.5": _off("tau_e", 1.5),
    "tau_e_2": _off("tau_e", 2),
    "tau_e_5": _off("tau_e", 5),
    "tau_g_1.5": _off("tau_g", 1 / 1.5),
    "tau_g_2": _off("tau_g", 1 / 2),
    "tau_g_5": _off("tau_g", 1 / 5),
    "tau_c_2": _off("tau_c", 1 / 2),
    "tau_c_5": _off("tau_c", 1 / 5),
    "tau_b_2": _off("tau_b", 2),
    "tau_b_5": _off("tau_b", 1 / 5),
    "dead": _answered(
        "one answer, whatever the frame",
        lambda right: Detection(proximity="Normal", contact="Untouched", approach=0.0, touch=0.0),
    ),
    "never_touched": _always(contact="Untouched"),
    "always_touched": _always(contact="Touched"),
    "always_near": _always(proximity="Approaching"),
    "always_light": _always(proximity="Noise", contact="Unknown"),
    "contact_exchanged": _exchanged("contact", "Touched", "Untouched"),
    "light_exchanged": _exchanged("proximity", "Approaching", "Noise"),
    "delayed": _answered(f"{DELAY} frames late", lambda right: right[max(0, len(right) - 1 - DELAY)]),
    "stuck": _answered(f"one answer after {STUCK} frames", lambda right: right[min(STUCK, len(right)) - 1]),
    "dropped": _answered(
        f"one answer for {DROPPED} frames", lambda right: right[(len(right) - 1) // DROPPED * DROPPED]
    ),
    "after_light": _answered("Touched after a flashlight", _after_light),
    "scores_turned": _answered(
        "scores with the other sign",
        lambda right: replace(right[-1], approach=-right[-1].approach, touch=-right[-1].touch),
    ),
    "swapped": _seen("red and green exchanged after the references", swapped),
    "mirrored": _seen("references left-right mirrored", _mirrored, is_reference=True),
    "dimmed": _seen("frames at 70 % after the references", _dimmed),
    "red_lost": _seen("red lost after the references", _without_red),
    "references_swapped": _seen("red and green exchanged in the references", swapped, is_reference=True),
    "references_dimmed": _seen("references at 70 %", _dimmed, is_reference=True),
}
"""All faults by name."""
