"""Faults put into the built-in detectors on purpose: what `evaluate` must notice, and reruns that it must not."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from magicsim.detectors.profile import DetectorProfile
from magicsim.evaluation.detector import Detection, Detector, ProfileDetector

Frame = npt.NDArray[np.uint8]
SWAPPED = [1, 0, 2]
"""Channels in the order red and green exchanged."""


class SwappedChannels:
    """The built-in detectors behind a camera whose red and green are exchanged once the references are taken."""

    def __init__(self, profile: DetectorProfile) -> None:
        """Takes thresholds and options."""
        self._inner = ProfileDetector(profile)

    def fit(self, references: Sequence[Frame]) -> None:
        """See `magicsim.evaluation.detector.Detector`."""
        self._inner.fit(references)

    def step(self, frame: Frame) -> Detection:
        """See `magicsim.evaluation.detector.Detector`."""
        return self._inner.step(np.ascontiguousarray(frame[..., SWAPPED]))


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """One fault."""

    says: str
    make: Callable[[DetectorProfile], Detector]
    """From the sound profile to the faulty detector."""


def _changed(says: str, change: Callable[[DetectorProfile], DetectorProfile]) -> Fault:
    return Fault(says=says, make=lambda profile: ProfileDetector(change(profile)))


FAULTS: Mapping[str, Fault] = {
    "kernel": _changed("grid_blur_px = 9", lambda profile: replace(profile, grid_blur_px=9)),
    "tau_b_low": _changed("tau_b 20 % lower", lambda profile: replace(profile, tau_b=round(0.8 * profile.tau_b))),
    "tau_b_high": _changed("tau_b 20 % higher", lambda profile: replace(profile, tau_b=round(1.2 * profile.tau_b))),
    "tau_e_low": _changed("tau_e 20 % lower", lambda profile: replace(profile, tau_e=0.8 * profile.tau_e)),
    "tau_e_high": _changed("tau_e 20 % higher", lambda profile: replace(profile, tau_e=1.2 * profile.tau_e)),
    "tau_c_low": _changed("tau_c 20 % lower", lambda profile: replace(profile, tau_c=0.8 * profile.tau_c)),
    "tau_g_low": _changed("tau_g 20 % lower", lambda profile: replace(profile, tau_g=0.8 * profile.tau_g)),
    "swapped": Fault(says="red and green exchanged after the references", make=SwappedChannels),
}
"""All faults by name."""
