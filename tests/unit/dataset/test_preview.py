import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from dataset.fakes import small_recipe
from magicsim.dataset.preview import (
    captions,
    contact_sheet,
    metering_scene,
    preview_recipe,
    preview_scene,
    recipe_statistics,
    telling_state,
)
from magicsim.dataset.recipes.draw import draw_episodes
from magicsim.dataset.recipes.estimate import estimate
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.workers.attempt import WorkerOptions


@pytest.fixture(scope="module")
def episodes():
    return draw_episodes(small_recipe("episodes=12"))


def test_most_telling_state_is_the_deepest(episodes):
    for episode in episodes:
        state = telling_state(episode.scene)
        if episode.path_kind == "touch":
            assert -state.gap_mm == pytest.approx(episode.values["path.depth_mm"])
            assert captions(episode)[1:] == ["sphere", f"{episode.values['path.depth_mm']:.2f} mm deep"]
        else:
            assert state.flashlight


def test_preview_is_one_small_frame_of_the_same_object_in_the_same_place(episodes):
    for episode in episodes:
        scene = preview_scene(episode)
        assert (scene.frame_count, scene.references) == (1, 0)
        assert telling_state(scene) == telling_state(episode.scene)
        assert scene.object == episode.scene.object
        assert (scene.rig.camera.columns, scene.rig.camera.rows) == (8, 8)


def test_exposure_is_metered_on_the_sensor_without_tolerances(episodes):
    recipe = small_recipe("episodes=12")
    scene = metering_scene(recipe, episodes[0])
    assert (scene.design.skin_mm, scene.design.wall_mm) == (recipe.design.skin_mm, recipe.design.wall_mm)
    assert scene.rig.strips == recipe.rig.strips
    assert scene.object is None
    assert scene == metering_scene(recipe, episodes[1]).model_copy(update={"rig": scene.rig, "design": scene.design})


def test_statistics_count_what_will_be_written(episodes):
    found = recipe_statistics(small_recipe("episodes=12"), episodes)
    assert found["episodes"] == 12
    assert found["sensors"] == 4
    assert found["frames"] == sum(episode.scene.frame_count + 1 for episode in episodes)
    assert sum(found["frames_by_class"].values()) == found["frames"]
    assert found["frames_by_class"]["Reference"] == 12
    assert found["episodes_by_path"]["touch"] == sum(episode.path_kind == "touch" for episode in episodes)
    depths = [episode.values["path.depth_mm"] for episode in episodes if "path.depth_mm" in episode.values]
    assert found["drawn"]["path.depth_mm"]["max"] == pytest.approx(max(depths), abs=1e-6)
    assert json.loads(json.dumps(found)) == found


def test_estimate_grows_with_what_costs():
    def cost(*settings: str):
        recipe = small_recipe("episodes=12", *settings)
        return estimate(recipe, draw_episodes(recipe), processes=2)

    base = cost()
    assert cost("render.samples=40").core_seconds > base.core_seconds
    assert cost("rig.camera.rows=64").bytes - base.bytes > 68 * 24 * 32
    assert cost("labels.displacements=false").bytes < base.bytes
    assert base.seconds(4) == base.core_seconds / 4


def test_estimate_says_what_each_choice_saves():
    def saved(*settings: str) -> str:
        recipe = load_recipe("touches", ("episodes=40", *settings))
        return "; ".join(estimate(recipe, draw_episodes(recipe), processes=2).savings)

    assert re.search(r"labels\.displacements=false saves \d+% of the bytes; labels\.depth_map=false saves", saved())
    assert re.search(r"--tier fast saves \d+% of the time", saved())
    made = ("labels.displacements=false", "labels.depth_map=false", "render.tier=fast")
    assert re.fullmatch(r"contact\.quality=control saves \d+% of the time", saved(*made))
    assert saved(*made, "contact.quality=control") == ""


def test_frames_by_recorded_paths_are_estimated_cheaper():
    def seconds(*settings: str) -> float:
        recipe = load_recipe("default", settings)
        return estimate(recipe, draw_episodes(recipe), processes=1).core_seconds

    many = "render.samples=32"
    assert seconds(many, "render.anchor_samples=0") > 1.1 * seconds(many)


def test_sheet_shows_every_tile_and_crosses_out_a_missing_one():
    image = np.full((16, 12, 3), (250, 10, 20), np.uint8)
    sheet = contact_sheet([(image, ["0", "ball"]), (None, ["1", "box"]), (image, ["2", ""])], 16, 12)
    assert (sheet == (250, 10, 20)).all(2).sum() == 2 * 16 * 12
    noted = contact_sheet([(image, ["0", "ball"]), (None, ["1", "box"]), (image, ["2", ""])], 16, 12, note="coarse")
    np.testing.assert_array_equal(noted[: len(sheet)], sheet)
    assert (noted[len(sheet) :] < 200).any()


@pytest.mark.slow
def test_preview_leaves_a_sheet_and_statistics_and_no_dataset(tmp_path: Path):
    found = preview_recipe(small_recipe(), tmp_path, 4, WorkerOptions(workers=1))
    assert (found.samples, found.shards, found.failed) == (4, 0, 0)
    assert {path.name for path in tmp_path.iterdir()} == {"preview.json", "preview.png"}
    assert cv2.imread(str(tmp_path / "preview.png")).std() > 10
    assert json.loads((tmp_path / "preview.json").read_text()) == found.statistics


def test_estimate_of_many_episodes_is_that_of_some_of_them():
    recipes = [small_recipe(f"episodes={count}", "episodes_per_sensor=1000") for count in (2000, 2_000_000)]
    few, many = (estimate(recipe, draw_episodes(recipe), processes=1) for recipe in recipes)
    assert many.frames / few.frames == pytest.approx(1000, rel=0.05)
    assert many.bytes / few.bytes == pytest.approx(1000, rel=0.15)


def test_a_region_is_previewed_as_the_whole_image():
    recipe = small_recipe("rig.camera.region_px=[4,4,8,8]")
    episode = draw_episodes(recipe)[0]
    for scene in (preview_scene(episode), metering_scene(recipe, episode)):
        assert scene.rig.camera.region_px is None
