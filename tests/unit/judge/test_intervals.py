import numpy as np
import pytest
from evaluation.synthetic import judged

from magicsim.judge.measures import estimate, exact_share, weights_of
from magicsim.judge.tally import tally

TAKES = [f"take-{number}" for number in range(24)]


def episodes(seed: int, *, share: float = 0.3):
    """Episodes that are wrong on all Near frames or on none: frames of one episode fail together."""
    random = np.random.default_rng(seed)
    return [judged(name, miss=range(4, 10) if random.random() < share else ()) for name in TAKES]


def test_weights_count_how_often_an_episode_was_drawn():
    drawn = weights_of(np.array([[0, 0, 2], [1, 1, 1]]), 4)
    assert drawn.tolist() == [[2, 0, 1, 0], [0, 3, 0, 0]]


def test_interval_covers_the_truth_about_as_often_as_it_says():
    """Of 95 % intervals of a share of 0.7 from 24 episodes; the binomial law of 60 trials allows 52 to 60."""
    covered = 0
    for seed in range(60):
        found = estimate("approach_recall", tally(episodes(seed)), TAKES, resamples=199, seed=seed)
        covered += found.low <= 0.7 <= found.high
    assert 51 <= covered <= 60  # percentile intervals of few episodes are a little short


def test_interval_is_that_of_episodes_not_of_frames():
    """A share p of n episodes that fail as a whole has the standard error sqrt(p (1 - p) / n)."""
    found = estimate("approach_recall", tally(episodes(3)), TAKES, resamples=1999, seed=0)
    share = found.value
    half = 1.96 * np.sqrt(share * (1 - share) / len(TAKES))
    assert (found.high - found.low) / 2 == pytest.approx(half, rel=0.15)


def test_noises_of_one_take_are_drawn_together():
    once = tally(episodes(3))
    twice = tally(episodes(3) * 2)
    one = estimate("approach_recall", once, TAKES, resamples=1999, seed=0)
    two = estimate("approach_recall", twice, TAKES * 2, resamples=1999, seed=0)
    assert (two.low, two.high, two.episodes) == (one.low, one.high, one.episodes)


def test_few_episodes_have_no_interval_and_faultless_ones_an_exact_share():
    found = estimate("approach_recall", tally(episodes(3)[:2]), TAKES[:2], resamples=99, seed=0)
    assert found.value is not None
    assert (found.low, found.high) == (None, None)
    share = exact_share(10, 10)
    assert share.high == 1
    assert share.low == pytest.approx(0.025 ** (1 / 10))
