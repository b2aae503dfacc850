import pytest

from magicsim.frame_class import FrameClass
from magicsim.report.tables import Phase, pick_frames, tell_phases, write_caption

from .synthetic import classes_of, make_episode, make_judgement


@pytest.fixture(scope="module")
def episode():
    return make_episode()


def test_story_has_every_phase_in_order(episode):
    phases = tell_phases(episode.scored)
    told = [phase for k, phase in enumerate(phases) if k == 0 or phases[k - 1] is not phase]
    assert told == [
        Phase.UNTOUCHED,
        Phase.APPROACH,
        Phase.NEAR,
        Phase.TOUCH,
        Phase.PRESS,
        Phase.SHEAR,
        Phase.RELEASE,
        Phase.NEAR,
        Phase.RETREAT,
        Phase.UNTOUCHED,
        Phase.FLASHLIGHT,
    ]


def test_hold_after_pressing_is_press():
    keyframes = [{"frame": 0, "gap_mm": 0.1}, {"frame": 4, "gap_mm": -1.0}, {"frame": 8, "gap_mm": -1.0}]
    assert tell_phases(make_episode(keyframes).scored)[-1] is Phase.PRESS


def test_picks_tell_the_whole_story_in_order(episode):
    frames, picks = episode.scored, pick_frames(episode.scored)
    phases = tell_phases(frames)
    assert len(picks) == 18
    assert picks == sorted(set(picks))
    assert {phases[k] for k in picks} == set(phases)
    assert {frames[k].truth.frame_class for k in picks} >= classes_of(episode)


@pytest.mark.parametrize("limit", [4, 6, 12])
def test_picks_cover_all_classes_within_a_small_limit(episode, limit):
    picks = pick_frames(episode.scored, limit)
    assert len(picks) == limit
    assert {episode.scored[k].truth.frame_class for k in picks} >= classes_of(episode)


def test_frames_that_look_alike_are_picked_once():
    assert len(pick_frames(make_episode([{"frame": 0}, {"frame": 40}]).scored)) == 1


def test_no_frames_give_no_picks():
    assert pick_frames([]) == []


def test_caption_states_depth_force_class_and_verdicts(episode):
    verdicts = make_judgement(episode, tau_g=0.6).verdicts
    place = next(k for k, one in enumerate(episode.scored) if one.truth.frame_class is FrameClass.CONTACT)
    caption = write_caption(episode.scored[place], verdicts[place])
    assert caption.distance == "depth 0.30\u00a0mm"
    assert caption.force == "0.15\u00a0N"
    assert caption.truth == "Contact"
    assert caption.proximity_right is None
    assert (caption.contact, caption.contact_right) == ("Untouched", False)


def test_caption_without_verdict_has_none(episode):
    caption = write_caption(episode.scored[0], None)
    assert (caption.distance, caption.proximity, caption.contact) == ("no object", None, None)
