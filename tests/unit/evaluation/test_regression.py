"""The promises of the benchmark: injected regressions are caught, reruns with other seeds are not."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import permutation_test

from evaluation.synthetic import PROFILE, judged
from magicsim.errors import ConfigError
from magicsim.evaluation.answers import SeenFrames
from magicsim.evaluation.baseline import Baseline, Comparison, load_baseline, save_baseline, set_beside
from magicsim.evaluation.detector import Detection, ProfileDetector
from magicsim.evaluation.footage import film_case
from magicsim.evaluation.suite import SuiteConfig
from magicsim.evaluation.take import list_cases
from magicsim.judge.measures import SCORE_MEANS
from magicsim.judge.regression import Change, compare
from magicsim.judge.tally import JudgedEpisode

Judge = Callable[..., list[JudgedEpisode]]
NAMES = [f"take-{number}" for number in range(10)]


@pytest.fixture(scope="module")
def baseline(judge: Judge, tmp_path_factory: pytest.TempPathFactory) -> Baseline:
    path = tmp_path_factory.mktemp("baseline") / "tiny.json"
    save_baseline(path, judge(), suite="tiny", detector="built-in")
    return load_baseline(path)


class SwappedChannels(ProfileDetector):
    """Frames come as BGR, references as RGB."""

    def __init__(self) -> None:
        super().__init__(PROFILE)

    def step(self, frame: np.ndarray) -> Detection:
        return super().step(np.ascontiguousarray(frame[..., ::-1]))


def beside(baseline: Baseline, episodes: list[JudgedEpisode], *, detector: str = "built-in") -> Comparison:
    return set_beside(baseline, episodes, suite="tiny", detector=detector, seed=0)


def changes(baseline: Baseline, episodes: list[JudgedEpisode]) -> list[Change]:
    return beside(baseline, episodes).changes


def fallen(baseline: Baseline, episodes: list[JudgedEpisode]) -> set[str]:
    return {each.measure for each in changes(baseline, episodes) if each.is_regression}


def test_same_detector_on_the_same_frames_changes_nothing(judge: Judge, baseline: Baseline):
    found = changes(baseline, judge())
    assert {each.condition for each in found} == {"dark/rig", "dark/high"}
    assert all(each.fall == 0 for each in found)
    assert not any(each.is_regression or each.is_improvement for each in found)


def test_ten_reruns_with_other_seeds_raise_no_alarm(judge: Judge, baseline: Baseline):
    differ = 0
    for seed in range(1, 11):
        rerun = beside(baseline, judge(seed=seed))
        found = rerun.changes
        assert rerun.frames_changed == []
        assert not [each for each in found if each.is_regression]
        differ += any(each.fall != 0 for each in found)
    assert differ > 0  # the frames are others indeed


@pytest.mark.parametrize(
    ("change", "measure"),
    [
        ({"grid_blur_px": 9}, "contact_balanced_accuracy"),
        ({"tau_g": 0.8 * PROFILE.tau_g}, "contact_balanced_accuracy"),
        ({"tau_g": 0.8 * PROFILE.tau_g}, "onset_mm"),
        ({"tau_e": 1.2 * PROFILE.tau_e}, "lead_mm"),
        ({"tau_e": 0.8 * PROFILE.tau_e}, "clear_score"),
        ({"tau_b": 48}, "contact_score"),
        ({"tau_b": 72}, "contact_score"),
        ({"tau_c": 0.3}, "contact_balanced_accuracy"),
    ],
)
def test_wrong_kernel_or_threshold_is_caught(judge: Judge, baseline: Baseline, change: dict[str, object], measure: str):
    assert measure in fallen(baseline, judge(**change))


def test_swapped_channel_is_caught(judge: Judge, baseline: Baseline):
    assert "proximity_balanced_accuracy" in fallen(baseline, judge(SwappedChannels))


def test_improvement_is_told_and_is_no_regression(judge: Judge, tmp_path: Path):
    save_baseline(tmp_path / "worse.json", judge(tau_g=0.64), suite="tiny", detector="worse")
    found = changes(load_baseline(tmp_path / "worse.json"), judge())
    assert not any(each.is_regression for each in found)
    assert "contact_balanced_accuracy" in {each.measure for each in found if each.is_improvement}


def test_regression_names_the_frames_whose_verdict_became_wrong():
    before = [judged(name) for name in NAMES]
    now = [judged(name, miss=(4, 5, 10)) for name in NAMES]
    found = compare(list(zip(before, now, strict=True)), ["one"] * len(NAMES), standard="one", seed=0)
    near = next(each for each in found if each.measure == "proximity_balanced_accuracy")
    assert near.is_regression
    assert [(run.episode, run.first, run.last) for run in near.frames] == [(f"{name}/rig", 4, 5) for name in NAMES]
    assert {(run.truth, run.baseline, run.current) for run in near.frames} == {("Near", "Approaching", "Normal")}
    touch = next(each for each in found if each.measure == "onset_mm")
    assert [(run.first, run.last, run.truth) for run in touch.frames] == [(4, 5, "Near"), (10, 10, "Contact")] * 10


def test_fall_of_one_episode_among_ten_is_not_significant():
    now = [judged(NAMES[0], miss=range(4, 14)), *(judged(name) for name in NAMES[1:])]
    found = compare(
        [(judged(name), each) for name, each in zip(NAMES, now, strict=True)], ["one"] * 10, standard="one", seed=0
    )
    fallen = next(each for each in found if each.measure == "proximity_balanced_accuracy")
    assert fallen.fall > fallen.matters
    assert fallen.p_fall == 0.5
    assert not fallen.is_regression


def shifted(name: str, *, near: float = 0.0, clear: float = 0.0) -> JudgedEpisode:
    """The episode with other scores of an approach and the same verdicts."""
    episode = judged(name)
    return replace(episode, approach=episode.approach + np.repeat([clear, near, 0.0], [4, 6, 8]))


def test_scores_that_lose_margin_without_any_other_verdict_are_a_regression_of_a_detector_and_its_former_self():
    pairs = [(judged(name), shifted(name, near=-0.1, clear=-0.1)) for name in NAMES]
    assert not any(each.is_regression for each in compare(pairs, ["one"] * 10, standard="one", seed=0))
    found = {each.measure: each for each in compare(pairs, ["one"] * 10, standard="one", seed=0, same_scale=True)}
    near = found["near_score"]
    assert near.is_regression
    assert near.p_fall is None
    assert near.fall == pytest.approx(0.1)
    means = [np.mean([judged(name).approach[part] for name in NAMES]) for part in (slice(4, 10), slice(0, 4))]
    assert near.matters == pytest.approx(0.01 * (means[0] - means[1]))
    assert {(run.first, run.last, run.truth) for run in near.frames} == {(4, 9, "Near")}
    told = near.frames[0]
    assert float(told.baseline.split()[1]) - float(told.current.split()[1]) == pytest.approx(0.1, abs=0.02)
    assert found["clear_score"].is_improvement


def test_scores_of_a_detector_that_tells_nothing_apart_are_not_compared():
    blind = [replace(judged(name), approach=np.zeros(18), touch=np.zeros(18)) for name in NAMES]
    found = compare([(each, each) for each in blind], ["one"] * 10, standard="one", seed=0, same_scale=True)
    assert not {each.measure for each in found} & set(SCORE_MEANS)


def test_p_value_is_that_of_the_exact_sign_flip_test():
    """Misses that differ from episode to episode: the share of Near frames noticed falls by 0 to 3 frames in 6."""
    counts = [3, 2, 2, 1, 1, 1, 0, 0, 1, 2]
    before = [judged(name, miss=(4,) if number == 6 else ()) for number, name in enumerate(NAMES)]
    now = [judged(name, miss=range(4, 4 + count)) for name, count in zip(NAMES, counts, strict=True)]
    found = compare(list(zip(before, now, strict=True)), ["one"] * 10, standard="one", seed=0)
    fallen = next(each for each in found if each.measure == "proximity_balanced_accuracy")
    differences = np.array(counts) - np.array([number == 6 for number in range(10)])
    signs = np.array(np.meshgrid(*[[-1, 1]] * 10)).reshape(10, -1)
    expected = np.mean(differences @ signs >= differences.sum())
    assert fallen.p_fall == pytest.approx(expected)
    assert fallen.fall == pytest.approx(differences.sum() / 60 / 3)
    library = permutation_test(
        (np.array(counts, float), np.array([number == 6 for number in range(10)], float)),
        lambda x, y, axis: np.mean(x, axis=axis) - np.mean(y, axis=axis),
        permutation_type="samples", vectorized=True, alternative="greater",
    )  # fmt: skip
    assert fallen.p_fall == pytest.approx(library.pvalue)


def test_false_alarms_stay_below_the_significance_where_nothing_changed():
    """Two runs that both miss frames at random differ, but in no direction; 30 comparisons of all measures."""
    random = np.random.default_rng(5)
    alarms = 0
    for _ in range(30):
        runs = [
            [judged(name, miss=np.flatnonzero(random.random(18) < 0.1), seed=seed) for name in NAMES]
            for seed in random.integers(0, 1000, 2)
        ]
        alarms += any(
            each.is_regression for each in compare(list(zip(*runs, strict=True)), ["one"] * 10, standard="one", seed=0)
        )
    assert alarms <= 4  # 5 % of 30 are 1.5; 5 or more have a probability of 2 %


def test_baseline_is_read_back_as_it_was_written(judge: Judge, baseline: Baseline):
    pairs = beside(baseline, judge()).alike
    assert len(pairs) == len(baseline.episodes) == 16
    for before, now in pairs:
        assert before.seen.digest == now.seen.digest
        assert before.proximity == now.proximity
        assert before.contact == now.contact
        assert np.array_equal(before.approach, now.approach)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("{", "not valid JSON"),
        ('{"format": 1}', "format = 1 is not allowed: must be 2; make it anew with --save-baseline"),
        ('{"format": 2, "suite": "x"}', "not one that magicsim wrote"),
        (
            '{"format": 2, "suite": "x", "detector": "y", "made_on": "z", "made_by": {}, "episodes": {"a": {"classes": '
            '"c", "proximity": "nn", "contact": "u", "approach": "0", "touch": "0", "levels": "0", "digest": ""}}}',
            "lists of different length",
        ),
    ],
)
def test_bad_baseline_is_refused(tmp_path: Path, text: str, words: str):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(ConfigError, match=words):
        load_baseline(path)


def test_baseline_of_another_suite_or_of_other_episodes_is_refused(judge: Judge, baseline: Baseline):
    with pytest.raises(ConfigError, match="no episode in common with suite 'tiny'; make it anew with --save-"):
        beside(baseline, [judged("elsewhere")])
    other = replace(baseline, suite="other")
    assert beside(other, judge()).frames_changed == []  # the same frames under another name
    with pytest.raises(ConfigError, match="'other' has no frames in common with suite 'tiny'"):
        beside(other, [dimmed(each) for each in judge()])


def dimmed(episode: JudgedEpisode) -> JudgedEpisode:
    """The episode as another simulator would have shown it: half a grey level darker."""
    seen = replace(episode.seen, digest="0" * 16, levels=tuple(each - 0.5 for each in episode.seen.levels))
    return replace(episode, seen=seen)


def test_frames_that_changed_are_told_apart_from_verdicts_that_changed(judge: Judge, baseline: Baseline):
    faulty = judge(tau_g=0.8 * PROFILE.tau_g)
    by_detector = beside(baseline, faulty)
    assert by_detector.frames_changed == []
    assert len(by_detector.verdicts_changed) > 8
    by_frames = beside(baseline, [dimmed(each) for each in faulty])
    assert len(by_frames.frames_changed) == 16
    assert by_frames.verdicts_changed == []
    assert by_frames.changes == []
    assert {each.measure for each in by_frames.moved if each.is_regression} >= {"contact_balanced_accuracy"}
    assert "(simulator): 16 of 16 episodes since the baseline was made by the present code on 20" in by_frames.lines[0]
    both = beside(baseline, [dimmed(faulty[0]), *faulty[1:]])
    assert both.frames_changed == [faulty[0].tag.name]
    assert {*both.verdicts_changed, faulty[0].tag.name} == {*by_detector.verdicts_changed}


def test_other_noise_and_other_rounding_are_the_same_frames(judge: Judge, baseline: Baseline):
    assert beside(baseline, judge(seed=7)).frames_changed == []
    sound = judge()
    levels = tuple(each + 0.01 for each in sound[0].seen.levels)
    rounded = replace(sound[0], seen=replace(sound[0].seen, digest="0" * 16, levels=levels))
    assert beside(baseline, [rounded]).frames_changed == []


@pytest.mark.parametrize(
    "change",
    [
        lambda frame: frame[:, ::-1],
        lambda frame: frame[..., ::-1],
        lambda frame: np.clip(frame + 2.0 * (np.indices(frame.shape).sum(0) % 2) - 1, 0, 255).astype(np.uint8),
        lambda frame: np.roll(frame, 1, axis=0),
    ],
    ids=["mirrored", "exchanged colours", "grainier", "moved by a pixel"],
)
def test_frames_that_keep_their_levels_and_change_their_look_are_changed_frames(
    tiny: tuple[SuiteConfig, Path], change: Callable[[np.ndarray], np.ndarray]
):
    film = film_case(list_cases(tiny[0])[0], *tiny)[0]
    seen, others = SeenFrames(film.images.references()), SeenFrames([])
    list(seen.passed(film.images.frames()))
    list(others.passed(map(change, film.images.frames())))
    assert others.seen.levels == pytest.approx(seen.seen.levels, abs=0.05)
    assert not seen.seen.is_alike(others.seen)
    assert seen.seen.is_alike(replace(others.seen, look=()))  # of an older baseline levels alone are known


def test_frames_of_other_classes_are_changed_frames(judge: Judge, baseline: Baseline):
    [first, *others] = judge()
    found = beside(baseline, [replace(judged("x"), tag=first.tag), *others])
    assert found.frames_changed == [first.tag.name]
    assert len(found.alike) == 15
