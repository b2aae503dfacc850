"""What the search found: the sensors that fit, what is left of every distance, and what that says of the constants."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

import numpy as np

from laboratory.operating_point.front import exclusive, front, met
from laboratory.operating_point.search import CAMERA_NAMES, OPTICAL_NAMES, value_at
from laboratory.operating_point.targets import TARGETS, distances

BEST_SHARE = 0.05
"""Share of the filmed choices of optical constants whose best camera makes the ensemble."""
LEAST = 5
"""Members at least."""


def summarise(rows: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The result of a search.

    Args:
        rows: One a step, `candidates` best first.
    """
    leaders = sorted((row["candidates"][0] for row in rows if row["candidates"]), key=lambda each: each["distance"])
    members = leaders[: max(LEAST, round(BEST_SHARE * len(leaders)))]
    everything = [each for row in rows for each in row["candidates"]]
    together = [met(each["reading"]["quantities"]) for each in everything]
    return {
        "kind": "operating-point",
        "steps": len(rows),
        "refused": [row["refused"] for row in rows if "refused" in row],
        "candidates": len(everything),
        "cpu_seconds": round(sum(row["cpu_seconds"] for row in rows), 1),
        "targets": {
            name: asdict(each) | {"low": _finite(each.low), "high": _finite(each.high)}
            for name, each in TARGETS.items()
        },
        "distance": {"best": members[0]["distance"], "worst_member": members[-1]["distance"]},
        "best": {key: members[0][key] for key in ("distance", "optical", "camera", "reading")},
        "quantities": {name: _quantity(name, members, everything) for name in TARGETS},
        "constants": _narrowed(members),
        "front": [{"met": sorted(names), "sensors": count} for names, count in front(together)],
        "exclusive": exclusive(together),
        "ensemble": members,
    }


def _quantity(
    name: str, members: Sequence[Mapping[str, Any]], everything: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:
    """A quantity over the ensemble, what is left of its distance, and what any sensor of the search reached alone."""
    values = [each["reading"]["quantities"][name] for each in members]
    anywhere = [each["reading"]["quantities"][name] for each in everything]
    left = [distances(each["reading"]["quantities"])[name] for each in members]
    alone = [abs(TARGETS[name].distance(value)) for value in anywhere]
    return {
        "low": min(values),
        "median": float(np.median(values)),
        "high": max(values),
        "distance_low": min(left, key=abs),
        "distance_median": float(np.median(left)),
        "reached_alone": float(np.mean([each == 0 for each in alone])),
        "nearest_alone": min(alone),
        "searched_low": min(anywhere),
        "searched_high": max(anywhere),
    }


def _narrowed(members: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Every constant over the ensemble in shares of its range; a spread of 1 is that of an even distribution."""
    found = {}
    for part, names in (("optical", OPTICAL_NAMES), ("camera", CAMERA_NAMES)):
        kept = np.array([each[part] for each in members])
        for place, name in enumerate(names):
            found[name] = {
                "low": float(kept[:, place].min()),
                "median": float(np.median(kept[:, place])),
                "high": float(kept[:, place].max()),
                "spread": float(kept[:, place].std() * np.sqrt(12)),
                "values": [value_at(name, share) for share in kept[:, place]],
            }
    return found


def _finite(value: float) -> float | None:
    return float(value) if np.isfinite(value) else None
