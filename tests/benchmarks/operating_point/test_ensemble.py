import json
from dataclasses import asdict, replace

import numpy as np
import pytest
from laboratory.operating_point.counts import counts
from laboratory.operating_point.ensemble import LEAST, summarise
from laboratory.operating_point.filming import GAPS_MM, TOUCHES_MM
from laboratory.operating_point.reading import Reading
from laboratory.operating_point.search import (
    CAMERA_NAMES,
    OPTICAL_NAMES,
    Candidate,
    as_row,
    camera_values,
    grid_reading,
    optical_fields,
)
from laboratory.operating_point.tables import tables
from laboratory.operating_point.targets import TARGETS, total_distance


def candidate(place: int) -> Candidate:
    """The farther from place 0, the farther from the targets, in the entropy at rest alone."""
    random = np.random.default_rng(place)
    quantities = {name: each.low if np.isfinite(each.low) else each.high for name, each in TARGETS.items()} | {
        "e_rest": 0.4 + 0.1 * place
    }
    return Candidate(
        optical=random.random(len(OPTICAL_NAMES)).tolist(),
        camera=random.random(len(CAMERA_NAMES)).tolist(),
        distance=total_distance(quantities),
        reading=Reading(
            quantities=quantities, correlation=[0.1], entropy=[1.0], similarity=[0.8], evenness=[0.5, 1.0, 0.5],
            disparity={"rest": 0.3, "touch": 0.2, "light": 0.1},
            right={"untouched": 1.0, "touched": (place % 3) / 2, "near": float(place % 3 < 2), "light": 1.0},
        ),
    )  # fmt: skip


def rows() -> list[dict]:
    found = [
        {"candidates": as_row([candidate(place), candidate(place + 1)]), "cpu_seconds": 1.0} for place in range(20)
    ]
    return [*found, {"candidates": [], "refused": "no light", "cpu_seconds": 0.5}]


def test_ensemble_is_the_best_candidate_of_the_best_steps():
    found = summarise(rows())
    assert [each["reading"]["quantities"]["e_rest"] for each in found["ensemble"]] == [0.4, 0.5, 0.6, 0.7, 0.8]
    assert len(found["ensemble"]) == LEAST
    assert found["distance"]["best"] == 0
    assert (found["steps"], found["candidates"], found["refused"]) == (21, 40, ["no light"])
    assert found["quantities"]["e_rest"]["high"] == 0.8
    assert found["quantities"]["e_rest"]["reached_alone"] == 3 / 40
    assert found["quantities"]["s_light"]["distance_median"] == 0
    assert set(found["constants"]) == {*OPTICAL_NAMES, *CAMERA_NAMES}


def test_summary_is_json_and_its_tables_name_every_target_and_constant():
    summary = summarise(rows()) | {"counts": counts(rows(), candidate(9).reading.quantities)}
    text = tables(json.loads(json.dumps(summary, allow_nan=False)))
    assert all(each.says in text for each in TARGETS.values())
    assert "| 3 of 40 |" in text  # e_rest is met up to 0.5: by place 0 once, by place 1 twice
    assert all(f"`{name}`" in text for name in (*OPTICAL_NAMES, *CAMERA_NAMES))
    widths = {line.count("|") for line in text.splitlines() if line.startswith("|")}
    assert widths == {3, 4, 7, 8}


def test_the_sensor_nearest_to_right_verdicts_is_told_state_by_state():
    states = len(GAPS_MM) + len(TOUCHES_MM)
    sensor = asdict(replace(candidate(1), reading=replace(
        candidate(1).reading, entropy=[1.0] * states, correlation=[0.0] * states, similarity=[0.7] * states,
    )))  # fmt: skip
    check = {"verdicts": {"searched": sensor, "careful": None}}
    text = tables(summarise(rows()) | {"counts": counts(rows()), "check": check})
    assert "| 40 mm away | 1.00 | 0.00 | 0.70 |" in text
    assert "| 1 mm deep | 1.00 | 0.00 | 0.70 |" in text
    assert "| untouched | 0.50 | - | 0.83 |" in text


def test_candidates_are_read_back():
    one = candidate(3)
    assert Candidate.read_back(json.loads(json.dumps(as_row([one])[0]))).reading.evenness == one.reading.evenness


def test_points_of_the_cube_become_values_in_the_ranges():
    low, high = optical_fields([0.0] * len(OPTICAL_NAMES)), optical_fields([1.0] * len(OPTICAL_NAMES))
    assert (low["design.wall_mm"], high["design.wall_mm"]) == (0.1, 0.2)
    assert (low["rig.strips.*.coupling"], high["contact.coupling"]) == ("contact", "dry")
    assert camera_values([1.0] * len(CAMERA_NAMES))["gamma"] == 2.4
    assert grid_reading([0.0] * len(CAMERA_NAMES)) == ("dark", "recall")
    assert grid_reading([1.0] * len(CAMERA_NAMES)) == ("bright", "iou")


def test_counts_are_those_of_all_sensors():
    found = counts(rows(), candidate(3).reading.quantities)
    # Places 0 to 20, the inner ones twice: the default's e_rest of 0.7 is reached by places 0 to 3.
    assert len(found["as_near"]) == 7
    assert found["as_near"][0] == 0
    assert found["settled"] == {10: 0, 14: 0, 18: 0, 21: 0}
    assert counts(rows()[5:15])["settled"][5] == pytest.approx(candidate(5).distance, abs=1e-4)
    assert counts(rows())["as_near"] is None


def test_best_contact_is_told_with_and_without_proximity():
    # Up to place 1 nothing is seen at rest, and places 2, 5, ... touch right and see no near object.
    assert counts(rows())["contact"] == {"best": 1.0, "with_proximity": 0.75}
    assert counts(rows()[2:])["contact"]["with_proximity"] is None
    assert counts([])["contact"] == {"best": None, "with_proximity": None}
