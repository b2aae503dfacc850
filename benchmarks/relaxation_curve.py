"""How stiff Agilus30 is at a time, beside the time of a hardness reading: the published master curve, shifted.

    python benchmarks/relaxation_curve.py       # the table of docs/validation.md

As published (20 C, axis read as hertz) the curve has the stiffness that the readings ask for after 92 s, where a
durometer is read 1 to 15 s after contact. Times are divided so that the curve meets the reading at its own time.
"""

from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.optimize import brentq

Array = npt.NDArray[np.float64]
LONG_TERM_MPA = 1.08
TERMS = np.array([(0.064, 22.3), (0.37, 6.96), (2.1, 2.71), (12.0, 1.25), (68.0, 0.46), (390.0, 0.16), (2200.0, 0.24)])
"""Prony terms of Young's modulus at 20 C: time [s] and modulus [MPa], shape (terms, 2)."""
FITTED_MPA = 1.557
"""Of the default design: what the readings ask for."""
READING_S = (1.0, 15.0)
"""After contact: what ASTM D2240 has where nothing else is stated, which is assumed, and the latest that is usual."""
SPEEDS_MM_S = (1.0, 0.1)
STEPS = 40
"""Between two depths of a path."""


def relaxed_mpa(time_s: Array | float) -> Array:
    """Relaxation modulus as published [MPa]."""
    time = np.asarray(time_s, float)[..., None]
    return np.asarray(LONG_TERM_MPA + (TERMS[:, 1] * np.exp(-time / TERMS[:, 0])).sum(-1))


def stiffness_time_s() -> float:
    """When the published curve has the fitted stiffness [s]."""
    return float(brentq(lambda time: float(relaxed_mpa(time)) - FITTED_MPA, 1.0, 2000.0))


def ratio(time_s: Array | float, *, reading_s: float) -> Array:
    """Relaxation modulus over that of the reading, at times after contact."""
    return relaxed_mpa(np.asarray(time_s) * stiffness_time_s() / reading_s) / FITTED_MPA


def ramp_ratio(path: Array, *, speed_mm_s: float, reading_s: float) -> Array:
    """Force over that at the reading's stiffness, at each depth of a press with one speed.

    Fung's quasi-linear law: F(t) is the integral of the relaxation ratio over the increments of the elastic force. The
    infill relaxes like the body.

    Args:
        path: Depth [mm] and elastic force [N], from the first depth above 0, shape (depths, 2).
        speed_mm_s: Of the indenter.
        reading_s: Time of the hardness reading.
    """
    known = np.vstack([[0.0, 0.0], path])
    depths = np.unique(np.concatenate([np.linspace(a, b, STEPS + 1) for a, b in pairwise(known[:, 0])]).round(9))
    forces = np.interp(depths, known[:, 0], known[:, 1])
    found = []
    for depth, force in path:
        past = depths[depths <= depth + 1e-9]
        middle = (past[1:] + past[:-1]) / 2
        gains = np.diff(forces[: len(past)])
        found.append(float(gains @ ratio((depth - middle) / speed_mm_s, reading_s=reading_s)) / force)
    return np.array(found)


def main() -> None:
    """Prints the curve beside the readings."""
    print(f"published curve: {FITTED_MPA} MPa after {stiffness_time_s():.1f} s")
    print(
        "| time after contact [s] | as published [MPa] | "
        + " | ".join(f"read at {each:g} s" for each in READING_S)
        + " |"
    )
    print("|---|---|---|---|")
    for time in (0.1, 1.0, 5.0, 15.0, 60.0, 300.0):
        ratios = " | ".join(f"{float(ratio(time, reading_s=each)):.2f}" for each in READING_S)
        print(f"| {time:g} | {float(relaxed_mpa(time)):.2f} | {ratios} |")


if __name__ == "__main__":
    main()
