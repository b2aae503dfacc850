"""Least squares of the constants on rings of both frames."""

from dataclasses import asdict
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from laboratory.real_frames.constants import DEPTH_MM, GAMMA, LOGARITHMS, RANGES, VIGNETTING, Constants, from_vector
from laboratory.real_frames.frames import grey, observed, profile, shade
from laboratory.real_frames.renderings import CAREFUL, SEED, places, radiance
from laboratory.real_frames.rings import Rings
from magicsim.arrays import Array

STARTS = 6


def fit(rings: Rings, real: Array, *, gamma: float | None) -> tuple[Constants, dict[str, float], Array, float]:
    """Least squares on rings of both frames.

    Args:
        rings: Of the model.
        real: Observed, shape (2, rings).
        gamma: Of the camera; None to fit it.

    Returns:
        Constants, their standard deviations, their covariance (of a vector as in `from_vector`), and the root mean
        square of the residuals [grey levels].
    """

    def residuals(vector: Array) -> Array:
        constants = from_vector(vector)
        shading = profile(shade(constants.vignetting))
        return np.concatenate(
            [grey(each, constants, shading) - seen for each, seen in zip(rings.of(constants), real, strict=True)]
        )

    held = (gamma - 1e-6, gamma + 1e-6) if gamma is not None else GAMMA
    bounds = np.array([*RANGES.values(), DEPTH_MM, VIGNETTING, (-8.0, 12.0), held]).T
    random, found = np.random.default_rng(SEED), []
    for _ in range(STARTS):
        start = bounds[0] + random.uniform(0.2, 0.8, bounds.shape[1]) * np.ptp(bounds, axis=0)
        rest = rings.of(from_vector(start))[0].mean()
        start[6] = start[7] * np.log(real[0].mean() / 255) - np.log(rest)
        found.append(least_squares(residuals, start, bounds=(bounds[0], bounds[1]), x_scale=np.ptp(bounds, axis=0)))
    best = min(found, key=lambda each: each.cost)
    count = len(best.fun) - (bounds.shape[1] - (gamma is not None))
    free = np.array([True] * 7 + [gamma is None])
    covariance = np.zeros((len(free), len(free)))
    jacobian = np.asarray(best.jac)[:, free]
    covariance[np.ix_(free, free)] = np.linalg.pinv(jacobian.T @ jacobian) * (best.fun**2).sum() / count
    constants = from_vector(best.x)
    spread = np.sqrt(np.diag(covariance))
    values = list(asdict(constants).values())
    spread[:LOGARITHMS] *= values[:LOGARITHMS]
    sds = dict(zip(asdict(constants), spread.tolist(), strict=True))
    return constants, sds, covariance, float(np.sqrt(np.mean(best.fun**2)))


def fitted(renders: Array) -> dict[str, Any]:
    """Both fits: with a camera whose grey levels are linear in light, and with a gamma of its own.

    Args:
        renders: Rings at `places`, shape (places, 5, rings).
    """
    real = np.array([profile(observed("ref")), profile(observed("sample"))])
    rings = Rings(places(), renders)
    first = fit(rings, real, gamma=1.0)[0]
    rings.correct(first, np.array([profile(each) for each in radiance(first, *CAREFUL)]))
    told: dict[str, Any] = {}
    for name, gamma in (("linear camera", 1.0), ("gamma free", None)):
        constants, sds, covariance, rms = fit(rings, real, gamma=gamma)
        print(name, rms, constants, flush=True)
        both = {key: {"value": value, "sd": sds[key]} for key, value in asdict(constants).items()}
        told[name] = {"rms_grey": rms, "constants": both, "covariance": covariance.tolist()}
    chosen = told["linear camera"]
    return {"constants": chosen["constants"], "covariance": chosen["covariance"], "fits": told}
