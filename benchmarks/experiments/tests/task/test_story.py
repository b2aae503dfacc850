from dataclasses import replace

from magicsim_experiments.task.settings import GraspConfig
from magicsim_experiments.task.story import Since, draw_story

CONFIG = GraspConfig(seed=3)


def test_episode_is_drawn_from_its_number_alone():
    stories = [draw_story(CONFIG, episode) for episode in range(60)]
    assert draw_story(CONFIG, 7) == stories[7]
    assert {story.item for story in stories} == set(CONFIG.items)
    assert 10 < sum(story.pull is not None for story in stories) < 50
    for story in stories:
        assert 60 <= story.speed_mm_s <= 250
        assert 1 <= story.near_mm <= 4
        for light in story.lights:
            assert light.since in (Since.BEGINNING, Since.TRANSPORT)
            if light.since is Since.BEGINNING:
                assert light.begin + light.frames < story.appears


def test_shares_of_nothing_and_of_all():
    never = GraspConfig(pull_share=0, light_share=0)
    always = GraspConfig(pull_share=1, light_share=1)
    for episode in range(10):
        quiet, busy = draw_story(never, episode), draw_story(always, episode)
        assert (quiet.pull, quiet.lights) == (None, ())
        assert busy.pull is not None
        assert [light.since for light in busy.lights] == [Since.BEGINNING, Since.TRANSPORT]


def test_flashlights_anywhere_come_at_every_stage_and_change_nothing_else_of_the_story():
    anywhere = CONFIG.model_copy(update={"flashlight": "any"})
    stories = [draw_story(anywhere, episode) for episode in range(200)]
    assert draw_story(anywhere, 7) == stories[7]
    assert {light.since for story in stories for light in story.lights} == set(Since)
    for episode, story in enumerate(stories):
        usual = draw_story(CONFIG, episode)
        assert replace(story, lights=(), appears=0) == replace(usual, lights=(), appears=0)
        sinces = [light.since for light in story.lights]
        assert len(set(sinces)) == len(sinces) <= 2
        assert (Since.DELIVERED if story.pull is not None else Since.PULL) not in sinces
        for light in story.lights:
            covered = light.since is not Since.BEGINNING
            assert covered == (abs(light.x_mm) >= 20)
            assert covered or light.begin + light.frames < story.appears
    assert 0.4 < sum(len(story.lights) for story in stories) / 400 < 0.6


def test_story_of_a_seed_stays_what_it_was():
    story = draw_story(CONFIG, 7)
    assert (story.item, story.appears, story.pull) == ("biscuit-packet", 8, 10)
    assert [(light.begin, light.frames, round(light.x_mm, 6)) for light in story.lights] == [(2, 8, -27.156901)]
