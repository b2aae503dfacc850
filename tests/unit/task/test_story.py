from magicsim.task.settings import GraspConfig
from magicsim.task.story import draw_story

CONFIG = GraspConfig(seed=3)


def test_episode_is_drawn_from_its_number_alone():
    stories = [draw_story(CONFIG, episode) for episode in range(60)]
    assert draw_story(CONFIG, 7) == stories[7]
    assert {story.item for story in stories} == set(CONFIG.items)
    assert 10 < sum(story.pull is not None for story in stories) < 50
    for story in stories:
        assert 60 <= story.speed_mm_s <= 250
        assert 1 <= story.near_mm <= 4
        if story.light_before is not None:
            assert story.light_before[1] < story.appears


def test_shares_of_nothing_and_of_all():
    never = GraspConfig(pull_share=0, light_share=0)
    always = GraspConfig(pull_share=1, light_share=1)
    for episode in range(10):
        quiet, busy = draw_story(never, episode), draw_story(always, episode)
        assert (quiet.pull, quiet.light_before, quiet.light_held) == (None, None, None)
        assert None not in (busy.pull, busy.light_before, busy.light_held)
