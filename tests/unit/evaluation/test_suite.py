from pathlib import Path

import pytest

from magicsim.config.presets import preset_names
from magicsim.errors import ConfigError
from magicsim.evaluation.suite import load_suite
from magicsim.evaluation.take import list_cases
from magicsim.scenes.timeline import timeline

from .synthetic import write_suite


@pytest.mark.parametrize("name", preset_names("suite"))
def test_shipped_suite_holds_training_and_held_out_objects_with_every_class(name: str):
    suite = load_suite(name)
    once = [block.model_copy(update={"seeds": (1,)}) for block in suite.episodes]
    cases = list_cases(suite.model_copy(update={"episodes": tuple(once)}))
    assert len({case.name for case in cases}) == len(cases) >= 9
    assert {case.role for case in cases} == {"training", "held_out"}
    assert {case.light for case in cases} == {"dark", "flashlight"}
    for case in cases:
        states = timeline(case.scene)
        deepest = min(state.gap_mm for state in states if state.gap_mm is not None)
        assert deepest <= -0.3 or case.path == "approach"
        assert any(state.flashlight and not state.has_object for state in states)
        assert any(not state.flashlight and not state.has_object for state in states)
        assert (case.light == "flashlight") == any(state.flashlight and state.has_object for state in states)


def test_objects_of_the_published_tests_are_in_the_full_suite_and_never_in_the_calibration():
    roles = {each.name: each.role for each in load_suite("full").objects}
    published = {
        "finger", "silver-spanner", "red-screwdriver", "green-screwdriver", "white-pen", "yellow-scissors", "orange",
        "yellow-banana", "biscuit-packet",
    }  # fmt: skip
    assert {name for name, role in roles.items() if role == "held_out"} == published
    assert {"approach", "light-touch", "press", "slide", "slip", "release"} == {
        p.name for p in load_suite("full").paths
    }


def test_press_is_a_share_of_the_objects_own_depth(tmp_path: Path):
    path = write_suite(tmp_path, objects=2)
    path.write_text(path.read_text().replace("press_mm = 1.0", "press_mm = 0.7"))
    gaps = [state.gap_mm for state in timeline(list_cases(load_suite(path))[0].scene)]
    assert min(gap for gap in gaps if gap is not None) == -0.7


def test_jitter_is_the_same_for_a_seed_and_differs_between_seeds_and_objects(tmp_path: Path):
    path = write_suite(tmp_path, objects=2)
    one = load_suite(path, ["jitter_mm=1.0"])
    again = load_suite(path, ["jitter_mm=1.0"])
    places = [case.scene.keyframes[1].x_mm for case in list_cases(one)]
    assert places == [case.scene.keyframes[1].x_mm for case in list_cases(again)]
    assert len(set(places)) == 2
    assert all(0 < abs(place) <= 1 for place in places)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('paths = ["story"]', 'paths = ["stroy"]', "did you mean 'story'"),
        ("press = 1.0", "press = 1.0, gap_mm = 2.0", "both gap_mm and press"),
        ("frame = 9,", "frame = 2,", "must start at 0 and increase"),
        ('name = "ball-1"', 'name = "ball-0"', "given twice"),
        ('"sphere:radius_mm=3"', '"sphre:radius_mm=3"', "objects.ball-0: unknown object kind 'sphre'"),
        ("press_mm = 1.0", "press_mm = 9.0", "press_mm = 9.0 is not allowed"),
        ("[[episodes]]", "[[epsodes]]", "unknown key"),
    ],
)
def test_bad_suite_is_one_line_that_names_it(tmp_path: Path, old: str, new: str, words: str):
    path = write_suite(tmp_path, objects=2)
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(ConfigError) as caught:
        load_suite(path)
    assert words in str(caught.value)
    assert len(str(caught.value).splitlines()) == 1


def test_suite_without_episodes_is_refused(tmp_path: Path):
    path = tmp_path / "empty.toml"
    path.write_text('schema_version = 1\ndesign = "uniform-block"\nrig = "digit-rgb"\n')
    with pytest.raises(ConfigError, match="episodes and recordings are both empty"):
        load_suite(path)
