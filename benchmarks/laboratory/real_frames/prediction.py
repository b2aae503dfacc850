"""Presses that nobody compared: another depth, a thinner layer."""

from dataclasses import asdict, replace
from typing import Any

import numpy as np

from laboratory.real_frames.constants import DEPTH_MM, RANGES, Constants, from_vector
from laboratory.real_frames.frames import features, grey, profile, shade
from laboratory.real_frames.renderings import CAREFUL, images, press_scene, radiance
from magicsim.arrays import Array
from magicsim.simulation.sensor import Sensor

CORE_MM, SKIN_MM = 1.75, 0.375
THINNER = f"design.core_mm={0.9 * (CORE_MM + 2 * SKIN_MM) - 2 * SKIN_MM:.4f}"
SHIFT = 0.2
"""Of a constant, in units of half its range, from which predictions take derivatives."""


def predict(constants: Constants, covariance: Array, depth_share: float, *overrides: str) -> dict[str, Any]:
    """A press that nobody compared: its profile, and features with their spread by the constants' covariance."""
    low, high = np.array([*RANGES.values(), DEPTH_MM]).T
    base = press_scene((-constants.depth_mm,), *CAREFUL)
    exposed = images(base, [Sensor.for_scene(base).rest] * 2, constants.rendered)[0].mean()

    def at(vector: Array) -> Array:
        moved = from_vector(vector)
        moved = replace(moved, depth_mm=depth_share * moved.depth_mm)
        found = radiance(moved, *CAREFUL, *overrides, turns=1)
        frames = grey(found * exposed / found[0].mean(), constants, shade(constants.vignetting))
        return profile(frames[0]) - profile(frames[1])

    middle = np.array([*constants.rendered, *list(asdict(constants).values())[4:]])
    drop = at(middle)
    value, slopes = features(drop), []
    for place in range(len(low)):
        step = SHIFT * (high - low)[place] / 2
        step = -step if middle[place] + step > high[place] else step
        moved = middle.copy()
        moved[place] += step
        slopes.append({key: (each - value[key]) / step for key, each in features(at(moved)).items()})
    cut = covariance[: len(low), : len(low)]
    told = {}
    for key, each in value.items():
        slope = np.array([one[key] for one in slopes])
        told[key] = {"value": each, "sd": float(np.sqrt(slope @ cut @ slope))}
    return {"features": told, "curve": drop.round(2).tolist()}
