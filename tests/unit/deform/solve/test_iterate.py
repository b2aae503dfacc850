"""What is said where an object went through the face instead of being pressed back."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from magicsim.deform.solve.iterate import LEAST_LIFT, Effort, lift, report_passage

AREA_MM2 = np.array([1.0, 2.0])


def problem() -> Any:
    return SimpleNamespace(face=SimpleNamespace(area_mm2=AREA_MM2))


def ended(*pressure_mpa: tuple[float, float, float]) -> Any:
    """Pressures as vectors along the object's normal."""
    vectors = np.array(pressure_mpa, float)
    size = np.linalg.norm(vectors, axis=1)
    normal = vectors / np.where(size > 0, size, 1)[:, None]
    return SimpleNamespace(contact=SimpleNamespace(pressure_mpa=size, normal=normal))


@pytest.mark.parametrize(
    ("pressure_mpa", "share"),
    [
        (((0, 0, 0.1), (0, 0, 0.3)), 1.0),  # pressed back
        (((0.1, 0, 0), (-0.05, 0, 0)), 0.0),  # squeezed at its flanks
        (((0, 0.3, 0.4), (0, -0.15, 0.2)), 0.8),
        (((0, 0, 0), (0, 0, 0)), 0.0),  # nothing touches
    ],
)
def test_lift_is_the_share_of_pressures_that_push_back(pressure_mpa: tuple[Any, Any], share: float) -> None:
    assert lift(problem(), ended(*pressure_mpa)) == pytest.approx(share, abs=1e-12)


def test_report_has_the_share_beside_the_least_one() -> None:
    effort = Effort(most=800, cutbacks=3, restarts=2, last=ended((0.1, 0, 0.0005), (-0.05, 0, 0)))
    told = report_passage(problem(), effort)
    assert told.startswith("the object passed through the contact face: 0.0025 of the pressures")
    assert f"(above {LEAST_LIFT:g}) after 0 iterations, 3 halved steps and 2 restarts" in told
