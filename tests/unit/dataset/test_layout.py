from collections import Counter
from itertools import pairwise

from magicsim.dataset.assembly import Layout, split_of
from magicsim.dataset.recipes.draw import sensor_of

from .fakes import small_recipe


def test_every_episode_is_in_one_file_in_order():
    shards = Layout(small_recipe("episodes=23"))
    assert sorted(episode for shard in shards for episode in shard.episodes) == list(range(23))
    for shard in shards:
        assert len(shard.episodes) <= 2
        assert all(one < other for one, other in pairwise(shard.episodes))
        assert shard.file.startswith(f"data/{shard.split}-")


def test_splits_keep_their_shares_at_every_size():
    recipe = small_recipe("episodes=500", "splits={train=0.8,validation=0.1,test=0.1}")
    for count in (10, 50, 500):
        found = Counter(split_of(recipe, episode) for episode in range(count))
        for split, share in (("train", 0.8), ("validation", 0.1), ("test", 0.1)):
            assert abs(found[split] - share * count) <= 2


def test_no_sensor_is_in_two_splits_where_that_is_asked_for():
    recipe = small_recipe("episodes=200", "split_by=sensor")
    homes: dict[int, set[str]] = {}
    for episode in range(200):
        homes.setdefault(sensor_of(recipe, episode), set()).add(split_of(recipe, episode))
    assert {len(splits) for splits in homes.values()} == {1}
    assert {split for splits in homes.values() for split in splits} == {"train", "test"}


def test_files_that_are_full_stay_when_there_are_more_episodes():
    few, many = ({shard.file: shard.episodes for shard in Layout(small_recipe(f"episodes={n}"))} for n in (9, 40))
    for file, episodes in few.items():
        assert many[file][: len(episodes)] == episodes


def test_every_episode_knows_its_file():
    recipe = small_recipe("episodes=41", "splits={train=0.6,validation=0.2,test=0.2}")
    layout = Layout(recipe)
    for number, shard in enumerate(layout):
        assert {layout.number_of(episode) for episode in shard.episodes} == {number}
        assert {split_of(recipe, episode) for episode in shard.episodes} == {shard.split}
    assert [shard.file for shard in layout] == sorted(shard.file for shard in layout)


def test_splits_without_an_episode_have_no_file():
    layout = Layout(small_recipe("episodes=1", "splits={train=0.8,validation=0.1,test=0.1}"))
    assert [(shard.split, shard.episodes) for shard in layout] == [("train", (0,))]
    assert layout.splits == ["train"]
