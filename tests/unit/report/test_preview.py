from dataclasses import replace

import pytest
from PIL import Image

from magicsim.errors import OutputError
from magicsim.report.episode_report import animate, strip_lines
from report.synthetic import make_episode, make_judgement


@pytest.fixture(scope="module")
def episode():
    return make_episode(size=(64, 48))


def test_preview_has_every_frame_and_loops(episode, tmp_path):
    path = animate(episode.scored, tmp_path / "preview.webp", 15.0, verdicts=make_judgement(episode).verdicts)
    with Image.open(path) as preview:
        assert preview.n_frames == len(episode.scored)
        assert preview.info["loop"] == 0
    assert [each.name for each in tmp_path.iterdir()] == ["preview.webp"]


def test_still_scene_keeps_every_frame(tmp_path):
    still = make_episode([{"frame": 0}, {"frame": 9}], size=(64, 48))
    same = [replace(frame, image=still.scored[0].image) for frame in still.scored]
    with Image.open(animate(same, tmp_path / "still.webp", 30.0, verdicts=())) as preview:
        assert preview.n_frames == 10


def test_preview_shrinks_to_the_size_asked_for(episode, tmp_path):
    frames = make_episode(size=(320, 240)).scored[:12]
    full = animate(frames, tmp_path / "full.webp", 15.0)
    limit = full.stat().st_size * 2 // 3
    small = animate(frames, tmp_path / "small.webp", 15.0, max_bytes=limit)
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


def test_preview_rejects_what_it_cannot_write(episode, tmp_path):
    frames = episode.scored
    with pytest.raises(OutputError, match="0 frames"):
        animate([], tmp_path / "preview.webp", 15.0)
    with pytest.raises(OutputError, match="0/s"):
        animate(frames, tmp_path / "preview.webp", 0.0)
    with pytest.raises(OutputError, match="1 verdicts for 90 frames"):
        animate(frames, tmp_path / "preview.webp", 15.0, verdicts=make_judgement(episode).verdicts[:1])
    assert not list(tmp_path.iterdir())
