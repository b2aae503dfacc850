"""What a study's page and plots say."""

import re

import pytest

from magicsim_experiments.study.plots import Series, plot_series
from magicsim_experiments.study.running import headed, in_words


@pytest.mark.parametrize(
    ("key", "said"),
    [
        ("f_x_n", "f x [N]"),
        ("r_z_deg", "r z [deg]"),
        ("dots_error_mm", "dots error [mm]"),
        ("dots_right_within_0.1_mm", "dots right within 0.1 mm"),
        ("drift.late_alarms", "drift late alarms"),
        ("frames", "frames"),
    ],
)
def test_headline_names_units_and_keeps_numbers(key: str, said: str):
    assert headed(key) == said
    assert "_" not in in_words(key)


def test_logarithmic_axis_is_labelled_at_its_points():
    series = [
        Series(name="model", x=[16.0, 31.0], y=[2.0, 1.0]),
        Series(name="constant answer", x=[], y=[3.0], is_level=True),
    ]
    svg = plot_series(series, x_title="training frames", y_title="error", name="curve", label="Curve", log_x=True)
    labels = [each.strip() for each in re.findall(r"<text[^>]*>([^<]*)</text>", svg)]
    assert {"16", "31"} <= set(labels)
    assert not any("10" in each for each in labels)
