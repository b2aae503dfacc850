"""What all sensors of a search say together, beside the best of them."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from laboratory.operating_point.search import CAMERA_NAMES
from laboratory.operating_point.targets import TARGETS, distances

Rows = Sequence[Mapping[str, Any]]
SETTLED = (1 / 2, 2 / 3, 5 / 6, 1)
"""Shares of the steps after which the best distance is told."""


def counts(rows: Rows, default: Mapping[str, float] | None = None) -> dict[str, Any]:
    """Figures over all sensors.

    Args:
        rows: One a step, `candidates` best first.
        default: Quantities of the default sensor, if it was read.

    Returns:
        `settled`: best distance after so many steps; `crosstalk`: mean C near an object in the lowest and the highest
        third of the crosstalk; `as_near`: distances of those that are at least as near as the default in every
        quantity; `contact`: best balanced accuracy of contact by the published thresholds, and that of the sensors that
        also see nothing at rest, see near objects and tell the flashlight.
    """
    everything = [each for row in rows for each in row["candidates"]]
    place = CAMERA_NAMES.index("crosstalk")
    near = {
        part: [each["reading"]["quantities"]["c_near"] for each in everything if low <= each["camera"][place] <= high]
        for part, (low, high) in {"lowest": (0, 1 / 3), "highest": (2 / 3, 1)}.items()
    }
    contact = {
        "best": _best_contact(everything),
        "with_proximity": _best_contact([each for each in everything if _has_proximity(each["reading"])]),
    }
    ends = [round(share * len(rows)) for share in SETTLED]
    aim = distances(default) if default is not None else None
    return {
        "settled": {end: _best(rows[:end]) for end in ends},
        "crosstalk": {part: float(np.mean(values)) if values else None for part, values in near.items()},
        "contact": contact,
        "as_near": None if aim is None else sorted(
            each["distance"] for each in everything
            if all(abs(left) <= abs(aim[name]) for name, left in distances(each["reading"]["quantities"]).items())
        ),
    }  # fmt: skip


def _has_proximity(reading: Mapping[str, Any]) -> bool:
    """Whether nothing is seen at rest, near objects are, and the flashlight is told apart."""
    is_quiet = TARGETS["e_rest"].distance(reading["quantities"]["e_rest"]) == 0
    return is_quiet and reading["right"]["near"] == reading["right"]["light"] == 1


def _best_contact(sensors: Rows) -> float | None:
    right = [each["reading"]["right"] for each in sensors]
    return max(((each["untouched"] + each["touched"]) / 2 for each in right), default=None)


def _best(rows: Rows) -> float | None:
    return min((row["candidates"][0]["distance"] for row in rows if row["candidates"]), default=None)
