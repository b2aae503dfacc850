from dataclasses import replace

import numpy as np
import pytest

from dataset.fakes import small_recipe
from magicsim.dataset import rows
from magicsim.dataset.recipes.draw import DrawnEpisode, draw_episodes
from magicsim.dataset.rows import at_force
from magicsim.deform.indentation.force import FORCE_SHARE, Reached
from magicsim.errors import ConfigError
from magicsim.scenes.timeline import timeline
from magicsim.simulation.sensor import Sensor


@pytest.fixture
def episode() -> DrawnEpisode:
    path = (
        "paths=[{kind='touch',force_n=4.0,shear_frames=1,twist_frames=0,hold_frames=0,press_frames=2,release_frames=1}]"
    )
    return draw_episodes(small_recipe(path))[0]


def answer(monkeypatch: pytest.MonkeyPatch, depth_mm: float, force_n: float) -> None:
    reached = Reached(depth_mm=depth_mm, force_n=force_n, is_met=force_n == 4.0, power=1.5, solves=3)
    monkeypatch.setattr(rows, "press_to_force", lambda *_, **__: reached)


def test_keyframes_press_as_deep_as_the_force_does(episode: DrawnEpisode, monkeypatch: pytest.MonkeyPatch):
    answer(monkeypatch, 0.75, 4.0)
    found = at_force(episode)[0].scene.keyframes
    assert [each.gap_mm for each in found] == [10.0, 0.1, -0.75, -0.75, 10.0]
    assert [each.frame for each in found] == [each.frame for each in episode.scene.keyframes]
    plain = replace(episode, force_n=None)
    assert at_force(plain) == (plain, None)
    assert at_force(plain)[0] is plain


def test_force_that_an_object_does_not_reach_is_one_line(episode: DrawnEpisode, monkeypatch: pytest.MonkeyPatch):
    answer(monkeypatch, 2.5, 3.1)
    with pytest.raises(
        ConfigError, match=r"force_n = 4 is not reached: 'sphere' presses with 3.1 N at the depth limit of 2.5 mm"
    ):
        at_force(episode)
    assert at_force(replace(episode, must_reach=False))[0].scene.keyframes[2].gap_mm == -2.5


def test_equilibrium_of_the_search_is_the_frame_s_own_and_is_not_solved_again():
    path = "paths=[{kind='touch',force_n=0.3,shear_frames=1,twist_frames=0,hold_frames=0,press_frames=1,friction=0.6}]"
    episode, known = at_force(draw_episodes(small_recipe(path))[0])
    assert known is not None
    state = next(each for each in timeline(episode.scene) if each.can_touch)
    sensor = Sensor.for_scene(episode.scene)
    own = sensor.deform(state, sensor.rest)
    np.testing.assert_array_equal(own.displacements_mm, known.displacements_mm)
    assert own.force_n[2] == pytest.approx(0.3, rel=FORCE_SHARE)
    sensor.known = known
    assert sensor.deform(state, sensor.rest) is known
    assert sensor.deform(state, own) is own  # on the way from another state it does not serve
