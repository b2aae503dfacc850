from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from magicsim.notebook.screen import EDGE_PX, to_srgb
from magicsim.report.episode_report import animate, strip_lines
from report.synthetic import make_episode, make_judgement


@pytest.fixture(scope="module")
def episode():
    return make_episode(size=(64, 48))


def test_preview_has_every_frame_and_loops(episode, tmp_path):
    path = animate(episode, tmp_path / "preview.webp", verdicts=make_judgement(episode).verdicts)
    with Image.open(path) as preview:
        assert preview.n_frames == len(episode.scored)
        assert preview.info["loop"] == 0
    assert [each.name for each in tmp_path.iterdir()] == ["preview.webp"]


def test_preview_shows_each_frame_beside_its_change_on_a_screen(tmp_path):
    large = make_episode([{"frame": 0}], size=(320, 240))
    with Image.open(animate(large, tmp_path / "preview.webp")) as preview:
        picture = np.asarray(preview.convert("RGB"), float)[:320]
    assert picture.shape == (320, 480 + EDGE_PX, 3)
    frame = large.scored[0].image
    assert picture[:, :240].mean() == pytest.approx(255 * to_srgb(frame / 255).mean(), abs=3)
    assert picture[:, 244:].mean() == pytest.approx(128, abs=3)


def test_still_scene_keeps_every_frame(tmp_path):
    still = make_episode([{"frame": 0}, {"frame": 9}], size=(64, 48))
    same = replace(still, frames=tuple(replace(frame, image=still.scored[0].image) for frame in still.frames))
    with Image.open(animate(same, tmp_path / "still.webp", verdicts=())) as preview:
        assert preview.n_frames == 10


def test_preview_shrinks_to_the_size_asked_for(episode, tmp_path):
    large = make_episode(size=(320, 240))
    short = replace(large, frames=large.frames[:15])
    full = animate(short, tmp_path / "full.webp")
    limit = full.stat().st_size * 2 // 3
    small = animate(short, tmp_path / "small.webp", max_bytes=limit)
    assert small.stat().st_size <= limit
    with Image.open(full) as one, Image.open(small) as other:
        assert other.height < one.height


def test_strip_states_truth_and_marks_wrong_verdicts(episode):
    verdicts = make_judgement(episode, tau_e=1.2, tau_g=0.3).verdicts
    place = next(k for k, frame in enumerate(episode.scored) if frame.truth.depth_mm > 1.0)
    lines = strip_lines(episode.scored[place], verdicts[place])
    assert "depth" in lines[0][0]
    assert lines[1:] == [
        ("truth: Contact", False),
        ("proximity: Approaching", False),
        ("contact: Untouched (wrong)", True),
    ]
    assert len(strip_lines(episode.scored[place], None)) == 2
