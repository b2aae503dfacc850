"""Gains that follow what the camera sees.

Each frame the logarithms of the gains are corrected by a share of the errors of brightness and of the channels'
balance, metered in the linear signal that is clipped at white; a new gain arrives some frames later.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from magicsim.arrays import Array, FloatImage
from magicsim.camera.effect_settings import LiveExposure, correction_share
from magicsim.errors import RenderError

FAINTEST = 1e-6
"""Least signal that is metered: a black image asks for a large gain and not for an infinite one."""
MAX_SETTLING = 2000
"""Frames after which a camera that still corrects its gains is taken to have no balance."""
SETTLED = 1e-6
"""Largest correction of a settled gain."""
CENTRE_SHARE = 0.25
"""Deviation of the centre's weights over each side."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Gains:
    """The gains of a stream."""

    now: Array
    """Signal = gain * what the sensor's colours see, shape (3,)."""
    coming: tuple[Array, ...] = ()
    """Those that arrive with the next frames, soonest first."""

    @property
    def latest(self) -> Array:
        """The last that was chosen."""
        return self.coming[-1] if self.coming else self.now

    def followed_by(self, chosen: Array, delay_frames: int) -> Self:
        """Gains of the next frame, when others were chosen in this one."""
        waiting = (*self.coming, chosen)
        if len(waiting) <= delay_frames:
            return type(self)(now=self.now, coming=waiting)
        return type(self)(now=waiting[0], coming=waiting[1:])


def metered(sensed: FloatImage, gain: Array, metering: str) -> Array:
    """Mean signal of each channel, clipped at white, shape (3,).

    Args:
        sensed: What the sensor's colours see, shape (rows, columns, 3).
        gain: Of each channel.
        metering: `mean` or `centre`.
    """
    signal = np.clip(sensed * gain, 0, 1)
    if metering == "mean":
        return np.asarray(signal.mean((0, 1), dtype=np.float64))
    down, across = (np.exp(-((np.linspace(-1, 1, count) / (2 * CENTRE_SHARE)) ** 2) / 2) for count in sensed.shape[:2])
    return np.asarray(np.einsum("r,c,rcx->x", down / down.sum(), across / across.sum(), signal, dtype=np.float64))


def corrected(gain: Array, means: Array, live: LiveExposure, *, aim: float, first: Array) -> Array:
    """The gains that a frame's means ask for, shape (3,).

    Args:
        gain: The last gains that were chosen.
        means: Metered signals of the frame, shape (3,).
        live: How it follows.
        aim: Mean signal that exposure aims at.
        first: Gains of the untouched sensor, which the limits are relative to.
    """
    seen = np.maximum(means, FAINTEST)
    step = np.zeros(3)
    if live.exposure:
        step += correction_share(live.time_constant_frames) * _beyond(np.log(aim / seen.mean()), live.tolerance)
    if live.white_balance:
        is_seen = means > FAINTEST  # a colour without light has no balance
        balance = np.where(is_seen, np.log(seen.mean() / seen), 0.0)
        balance -= is_seen * balance.sum() / max(1, is_seen.sum())
        step += correction_share(live.white_balance_frames) * _beyond(balance, live.tolerance)
    return np.asarray(np.clip(gain * np.exp(step), first * live.gain_limits[0], first * live.gain_limits[1]))


def settled(sensed: FloatImage, live: LiveExposure, *, aim: float, first: Array) -> Array:
    """Gains at which the untouched sensor stays, shape (3,).

    Where no light arrives at all they are the first ones.

    Args:
        sensed: What the sensor's colours see of the untouched sensor, shape (rows, columns, 3).
        live: How exposure follows.
        aim: Mean signal that it aims at.
        first: Where it begins, and what the limits are relative to.

    Raises:
        RenderError: It never settles, or not at what it aims at.
    """
    if not sensed.any():
        return first
    exact, gain = live.model_copy(update={"tolerance": 0.0}), first
    for _ in range(MAX_SETTLING):
        means = metered(sensed, gain, live.metering)
        chosen = corrected(gain, means, exact, aim=aim, first=first)
        if np.abs(chosen / gain - 1).max() < SETTLED:
            break
        gain = chosen
    else:
        msg = f"live exposure never settles on the untouched sensor: gains still move after {MAX_SETTLING} frames"
        raise RenderError(msg)
    reached = float(means.mean())
    if live.exposure and abs(np.log(max(reached, FAINTEST) / aim)) > max(live.tolerance, 100 * SETTLED):
        raise RenderError(
            f"live exposure never settles on the untouched sensor: its mean signal is {reached:.3g} of white at the "
            f"limit of the gains (camera.live.gain_limits = {list(live.gain_limits)}), {aim:.3g} is aimed at "
            "(camera.exposure_grey)"
        )
    return gain


def _beyond(error: Array | float, tolerance: float) -> Array:
    """An error where it is worth correcting."""
    return np.where(np.abs(error) > tolerance, error, 0.0)
