from dataclasses import replace

import numpy as np
import pytest
from report.synthetic import make_episode

from magicsim.simulation.episode import story_frames


@pytest.fixture(scope="module")
def episode():
    return make_episode()


def test_episode_prints_in_one_line_without_arrays(episode):
    text = repr(episode)
    assert text.startswith(f"Episode({len(episode.references)} references and {len(episode.scored)} frames")
    assert "array" not in text
    assert "\n" not in text


def test_story_holds_the_first_the_deepest_and_the_last_frame(episode):
    told = [frame.truth.index for frame in story_frames(episode.scored)]
    deepest = max(episode.scored, key=lambda frame: frame.truth.depth_mm if frame.truth.contact else -1.0)
    assert told == sorted(told)
    assert {episode.scored[0].truth.index, deepest.truth.index, episode.scored[-1].truth.index} <= set(told)
    assert len(told) <= 6


def test_notebook_shows_the_story(episode):
    html = episode._repr_html_()
    assert html.count("<img") == len(story_frames(episode.scored))
    assert "untouched" in html


def test_saved_arrays_have_an_entry_a_frame(episode, tmp_path):
    episode.save(tmp_path / "episode.npz")
    with np.load(tmp_path / "episode.npz", allow_pickle=False) as stored:
        assert all(len(stored[name]) == len(episode.frames) for name in stored.files)
        assert (stored["images"] == episode.images).all()
        depths = [frame.truth.depth_mm for frame in episode.frames]
        assert stored["depth_mm"].tolist() == depths
        assert np.isnan(stored["gap_mm"]).tolist() == [each.truth.state.gap_mm is None for each in episode.frames]


def test_episode_without_frames_after_the_references_shows_those(episode):
    rest = replace(episode, frames=episode.references)
    assert "<img" in rest._repr_html_()


def test_a_frame_at_the_face_is_no_less_than_nothing_deep(episode):
    truth = episode.scored[0].truth
    at_the_face = replace(truth, state=replace(truth.state, gap_mm=0.0), depth_mm=0.0, force_n=(0.0, 0.0, 0.0))
    assert at_the_face.caption.removesuffix(", flashlight") == "0 mm deep, 0 N"
