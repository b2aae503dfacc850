import re
from xml.etree import ElementTree as ET

import matplotlib as mpl
import pytest

from magicsim.judge.score import contact_right, proximity_right
from magicsim.report.plots import plot_features, plot_force_depth, plot_forces

from .synthetic import make_episode, make_judgement


@pytest.fixture(scope="module")
def episode():
    return make_episode()


def _element(svg: str, name: str) -> ET.Element:
    return next(each for each in ET.fromstring(svg).iter() if each.get("id") == name)


def _marks(svg: str, name: str) -> int:
    return len(list(_element(svg, name).iter("{http://www.w3.org/2000/svg}use")))


def _curve(svg: str, name: str) -> int:
    paths = [each for each in _element(svg, name) if each.tag.endswith("path")]
    return len(re.findall("[ML]", paths[0].get("d", "")))


@pytest.mark.parametrize("field", ["entropy", "correlation", "similarity"])
def test_features_have_a_point_for_every_frame(episode, field):
    svg = plot_features(episode.scored, make_judgement(episode), name="x")
    assert _curve(svg, f"x-{field}") == len(episode.scored)


def test_features_mark_every_wrong_verdict(episode):
    judgement = make_judgement(episode, tau_e=1.9, tau_g=0.6)
    svg = plot_features(episode.scored, judgement, name="x")
    pairs = [(one, frame.truth.frame_class) for one, frame in zip(judgement.verdicts, episode.scored, strict=True)]
    near = sum(proximity_right(*pair) is False for pair in pairs)
    touch = sum(contact_right(*pair) is False for pair in pairs)
    assert near > 0
    assert touch > 0
    assert _marks(svg, "x-wrong-entropy") == _marks(svg, "x-wrong-correlation") == near
    assert _marks(svg, "x-wrong-similarity") == touch


def test_features_state_their_thresholds(episode):
    svg = plot_features(episode.scored, make_judgement(episode, tau_e=1.25, tau_g=0.75), name="x")
    assert "threshold 1.25" in svg
    assert "threshold 0.75" in svg


@pytest.mark.parametrize("curve", ["force-z", "force-xy", "depth"])
def test_forces_have_a_point_for_every_frame(episode, curve):
    assert _curve(plot_forces(episode.scored, name="f"), f"f-{curve}") == len(episode.scored)


def test_gap_has_a_point_for_every_frame_with_an_object(episode):
    present = sum(frame.truth.state.has_object for frame in episode.scored)
    assert _curve(plot_forces(episode.scored, name="f"), "f-gap") == present


def test_force_depth_shows_every_frame_in_contact_once(episode):
    svg = plot_force_depth(episode.scored, name="d")
    drawn = [_marks(svg, f"d-{each}") for each in ("loading", "held", "unloading")]
    assert sum(drawn) == sum(frame.truth.contact for frame in episode.scored)
    assert all(drawn)


def test_drawing_leaves_the_settings_of_matplotlib_alone(episode):
    before = dict(mpl.rcParams)
    plot_forces(episode.scored, name="f")
    assert dict(mpl.rcParams) == before


def test_drawing_ignores_the_settings_of_matplotlib(episode):
    plain = plot_forces(episode.scored, name="f")
    with mpl.rc_context({"font.size": 30.0, "svg.fonttype": "path", "axes.grid": True}):
        assert plot_forces(episode.scored, name="f") == plain


def test_one_frame_is_enough_for_every_plot():
    episode = make_episode([{"frame": 0, "gap_mm": -0.5}])
    assert _curve(plot_features(episode.scored, make_judgement(episode), name="x"), "x-entropy") == 1
    assert _curve(plot_forces(episode.scored, name="f"), "f-depth") == 1
    assert _marks(plot_force_depth(episode.scored, name="d"), "d-loading") == 1
