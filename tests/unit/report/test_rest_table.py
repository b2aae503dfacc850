"""What the verdicts rest on: distances in standard deviations of the reference frames."""

from dataclasses import replace

import numpy as np
import pytest

from magicsim.detectors.verdict import FeatureAtRest
from magicsim.report.page import render_report
from magicsim.report.tables import rest_rows
from report.synthetic import make_episode, make_judgement


def test_distances_are_in_standard_deviations_of_rest():
    episode = make_episode()
    rest = FeatureAtRest(mean=0.9, sd=0.01)
    judgement = replace(make_judgement(episode), at_rest={"similarity": rest})
    parts, (row,) = rest_rows(episode.scored, judgement)
    assert row.name == "S"
    assert len(row.parts) == len(parts) > 2
    tau_g = judgement.thresholds["tau_g"]
    assert f"({(tau_g - 0.9) / 0.01:+.0f})" in row.threshold
    assert "What the verdicts rest on" in render_report(episode, [judgement], {})


def test_nothing_is_said_where_the_rest_is_not_known():
    episode = make_episode()
    assert rest_rows(episode.scored, make_judgement(episode))[1] == []
    assert "What the verdicts rest on" not in render_report(episode, [make_judgement(episode)], {})


@pytest.mark.parametrize(("value", "distance"), [(0.5, 0.0), (0.4, -np.inf), (0.6, np.inf)])
def test_a_camera_that_repeats_exactly_is_infinitely_far_from_all_else(value, distance):
    assert FeatureAtRest(mean=0.5, sd=0.0).distance(value) == distance
