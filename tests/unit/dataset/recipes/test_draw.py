from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import trimesh

from dataset.fakes import FOLDER, SMALL, small_recipe
from magicsim.config.documents import read_toml
from magicsim.config.models import apply_overrides, read_whole, validate
from magicsim.config.presets import find_preset
from magicsim.dataset.card import dataset_card
from magicsim.dataset.columns import columns_of
from magicsim.dataset.recipes.draw import (
    differing_units,
    draw_episodes,
    draw_sensors,
    drawn_names,
    episode_seed,
)
from magicsim.dataset.recipes.entries import ObjectRecipe
from magicsim.dataset.recipes.estimate import estimate
from magicsim.dataset.recipes.recipe import Recipe, load_recipe
from magicsim.errors import ConfigError
from magicsim.geometry.objects.kinds import OBJECT_KINDS
from magicsim.light.records.untouched import untouched_key
from magicsim.scenes.timeline import timeline


@pytest.fixture(scope="module")
def default() -> Recipe:
    return load_recipe("default", ["episodes=256"])


@pytest.fixture(scope="module")
def episodes(default: Recipe):
    return draw_episodes(default)


def recipe_with(**changes: object) -> Recipe:
    data = read_whole(FOLDER / "small.toml", SMALL)
    return validate(Recipe, data | changes, source="recipe")


def test_presses_are_those_that_the_sensor_was_tested_with(episodes):
    states = [state for episode in episodes for state in timeline(episode.scene)]
    deepest = [-state.gap_mm for state in states if state.gap_mm is not None and state.gap_mm < 0]
    assert 1.9 < max(deepest) <= 2.0
    twists = [state.twist_deg for state in states if state.gap_mm is not None]
    assert min(twists) < -80
    assert 80 < max(twists) <= 90
    shear = [episode.values["path.shear_mm"] for episode in episodes if "path.shear_mm" in episode.values]
    assert 0.9 < max(shear) <= 1.0


def test_paths_and_objects_come_as_often_as_they_weigh(default: Recipe, episodes):
    paths = Counter(episode.path_kind for episode in episodes)
    weights = {path.kind: path.weight for path in default.paths}
    for kind, weight in weights.items():
        assert paths[kind] == pytest.approx(256 * weight / sum(weights.values()), abs=1)
    touched = [episode.scene.object.kind for episode in episodes if episode.scene.object is not None]
    weights = {entry.kind: entry.weight for entry in default.objects}
    for kind, weight in weights.items():
        assert Counter(touched)[kind] / len(touched) == pytest.approx(weight / sum(weights.values()), abs=0.03)


def test_every_drawn_value_has_a_column_and_lies_in_its_interval(default: Recipe, episodes):
    names = set(drawn_names(default))
    assert set().union(*(episode.values for episode in episodes)) == names
    forces = [episode.values["path.force_n"] for episode in episodes if "path.force_n" in episode.values]
    assert 0.1 <= min(forces) < 0.2
    for episode in episodes:
        assert ("path.force_n" in episode.values) == (episode.path_kind == "touch")
        assert ("object.radius_mm" in episode.values) <= (episode.scene.object is not None)


def test_drawn_values_are_those_of_the_scene():
    for episode in draw_episodes(small_recipe()):
        values, scene = episode.values, episode.scene
        assert scene.design.skin_mm == pytest.approx(0.8 + values["sensor.skin_mm"])
        assert scene.rig.strips[2].radiance[1] == pytest.approx(5 * values["sensor.led_strength.2"])
        if scene.object is not None:
            assert scene.object.radius_mm == values["object.radius_mm"]
            assert scene.object.color == (0.8, values["object.color.1"], 0.2)
            depth = max(-state.gap_mm for state in timeline(scene) if state.gap_mm is not None)
            assert depth == pytest.approx(values["path.depth_mm"])


def test_each_light_has_a_strength_and_a_colour_of_its_own():
    ring = {"radiance": (0.5, 0.6, 0.7), "radius_mm": 8.0}
    led = {"place_mm": (0.0, 0.0, -20.0), "direction": (0.0, 0.0, 1.0), "radiance": (2.0, 3.0, 0.0)}
    drawn = {"led_strength": {"mean": 1.0, "sd": 0.05}, "led_color": {"low": 0.9, "high": 1.1}}
    plain = small_recipe()
    rig = plain.rig.model_dump() | {"leds": [led], "ring": ring}
    recipe = recipe_with(tolerances=drawn, design=plain.design.model_dump(), rig=rig)
    one, other = draw_sensors(recipe, 2)
    for sensor in (one, other):
        for number, (found, nominal) in enumerate(zip(sensor.rig.lamps, recipe.rig.lamps, strict=True)):
            strength = sensor.values[f"sensor.led_strength.{number}"]
            colors = [sensor.values[f"sensor.led_color.{number}.{channel}"] for channel in ("red", "green", "blue")]
            assert found == pytest.approx([strength * a * b for a, b in zip(nominal, colors, strict=True)])
            assert 0.9 <= min(colors) < max(colors) <= 1.1
    assert one.rig.lamps != other.rig.lamps
    assert set(one.values) <= set(drawn_names(recipe))


def test_each_print_has_a_pitch_and_a_skin_of_its_own():
    recipe = small_recipe(
        "tolerances.pitch_scale={mean=1.0,sd=0.002}", "tolerances.pitch_drift={low=-0.01,high=0.01}",
        "tolerances.skin_spread_mm={low=0.01,high=0.02}", "tolerances.torn_share={low=0.0,high=0.02}",
        "design.unevenness.pitch_scale=[1.01,1.0,1.0]",
    )  # fmt: skip
    sensors = draw_sensors(recipe, 3)
    for sensor in sensors:
        found, values = sensor.design.unevenness, sensor.values
        scales = [values[f"sensor.pitch_scale.{axis}"] for axis in "xyz"]
        assert found.pitch_scale == pytest.approx([1.01 * scales[0], *scales[1:]])
        assert found.pitch_drift == pytest.approx([values[f"sensor.pitch_drift.{axis}"] for axis in "xyz"])
        assert found.skin_sd_mm == values["sensor.skin_spread_mm"]
        assert found.torn_share == values["sensor.torn_share"]
    assert len({sensor.design.unevenness for sensor in sensors}) == 3


def test_walls_grow_at_the_cost_of_the_cells():
    recipe = small_recipe()
    pitch = recipe.design.cell_mm + recipe.design.wall_mm
    sensors = draw_sensors(recipe, 20)
    assert len({sensor.design.wall_mm for sensor in sensors}) == 20
    for sensor in sensors:
        assert sensor.design.cell_mm + sensor.design.wall_mm == pytest.approx(pitch, abs=1e-8)


def test_episodes_of_one_sensor_share_it_and_each_has_its_own_seed():
    episodes = draw_episodes(small_recipe("episodes=7"))
    assert [episode.sensor for episode in episodes] == [0, 0, 0, 1, 1, 1, 2]
    assert len({episode.scene.design for episode in episodes}) == 3
    assert [episode.scene.seed for episode in episodes] == [episode_seed(3, index) for index in range(7)]
    assert len({episode.scene.seed for episode in episodes}) == 7


@pytest.mark.parametrize("sampling", ["sobol", "stratified", "random"])
def test_first_episodes_stay_when_there_are_more(sampling: str):
    few, many = (draw_episodes(small_recipe(f"episodes={n}", f"sampling={sampling}")) for n in (3, 12))
    assert many[:3] == list(few)


def test_flashlight_and_empty_episodes_bring_no_object():
    recipe = recipe_with(paths=[{"kind": "flashlight", "strength": 0.5, "travel_mm": 3.0}, {"kind": "clear"}])
    for episode in draw_episodes(recipe):
        assert episode.scene.object is None
        states = timeline(episode.scene)
        assert all(state.flashlight == (episode.path_kind == "flashlight") for state in states)
        if episode.path_kind == "flashlight":
            assert episode.scene.rig.flashlight.radiance == (0.5, 0.5, 0.5)
            assert [state.light_x_mm for state in states] == [0.0, 1.0, 2.0, 3.0]


def test_path_presses_shears_twists_and_leaves():
    path = {
        "kind": "touch", "x_mm": 1.0, "gap_mm": 4.0, "depth_mm": 0.5, "shear_mm": 0.4, "shear_direction_deg": 90.0,
        "twist_deg": 30.0, "approach_frames": 2, "press_frames": 1, "shear_frames": 1, "twist_frames": 1,
        "hold_frames": 2, "release_frames": 1, "friction": 0.7,
    }  # fmt: skip
    episode = draw_episodes(recipe_with(paths=[path], episodes=1))[0]
    found = [(s.gap_mm, s.x_mm, s.y_mm, s.twist_deg) for s in timeline(episode.scene)]
    np.testing.assert_allclose(
        found,
        [
            (4, 1, 0, 0), (2.05, 1, 0, 0), (0.1, 1, 0, 0), (-0.5, 1, 0, 0), (-0.5, 1, 0.4, 0), (-0.5, 1, 0.4, 30),
            (-0.5, 1, 0.4, 30), (-0.5, 1, 0.4, 30), (4, 1, 0.4, 30),
        ],
        atol=1e-8,
    )  # fmt: skip
    assert episode.scene.contact.friction == 0.7


def test_gloss_is_drawn_for_each_episode_and_recorded():
    gloss = {"specular": {"low": 0.1, "high": 0.5}, "roughness": {"choices": [0.1, 0.3]}}
    recipe = recipe_with(
        objects=[{"kind": "sphere", "radius_mm": 3.0, **gloss}], paths=[{"kind": "hover", "nearest_mm": 1}]
    )
    drawn = draw_episodes(recipe)
    assert len({episode.scene.object.specular for episode in drawn}) == len(drawn)
    for episode in drawn:
        assert episode.scene.object.specular == episode.values["object.specular"]
        assert episode.scene.object.roughness == episode.values["object.roughness"]
    assert {"object_specular", "object_roughness", "drawn.object.specular"} <= {
        each.name for each in columns_of(recipe)
    }


@pytest.mark.parametrize("kind", OBJECT_KINDS)
def test_every_key_of_every_kind_of_object_may_stand_in_a_recipe(kind: str):
    assert set(OBJECT_KINDS[kind].model_fields) <= set(ObjectRecipe.model_fields)


def test_everyday_objects_are_drawn():
    objects = [{"kind": "screwdriver", "radius_mm": {"low": 9.0, "high": 12.0}, "flutes": 6}]
    episode = draw_episodes(recipe_with(objects=objects, paths=[{"kind": "hover", "nearest_mm": 1}]))[0]
    assert (episode.scene.object.kind, episode.scene.object.flutes) == ("screwdriver", 6)
    assert episode.scene.object.radius_mm == episode.values["object.radius_mm"]


def test_meshes_of_a_folder_are_equally_likely(tmp_path: Path):
    for name in ("b.stl", "a.ply"):
        trimesh.creation.box().export(tmp_path / name)
    (tmp_path / "notes.txt").touch()
    objects = [{"kind": "mesh", "folder": str(tmp_path), "scale": {"low": 2.0, "high": 3.0}}]
    paths = [{"kind": "hover", "nearest_mm": 1.0}]
    drawn = draw_episodes(recipe_with(objects=objects, paths=paths, episodes=16))
    files = Counter(Path(episode.scene.object.path).name for episode in drawn)
    assert files == {"a.ply": 8, "b.stl": 8}


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"objects": [{"kind": "sphere"}]}, "objects.0: radius_mm is missing: object kind 'sphere' needs it"),
        ({"objects": [{"kind": "sphere", "size_mm": 1.0}]}, "unknown key of object kind 'sphere' 'size_mm'"),
        ({"objects": [{"kind": "mesh"}]}, "needs either path or folder"),
        ({"objects": [{"kind": "sphere", "radius_mm": 1.0, "folder": "a"}]}, "folder is not a key of object kind"),
        ({"objects": []}, "objects are missing"),
        ({"paths": []}, "paths = "),
        ({"paths": [{"kind": "poke", "depth_mm": 1.0}]}, "available: clear, flashlight, hover, touch"),
        ({"paths": [{"kind": "touch"}]}, "paths.0: depth_mm is missing: a touch needs depth_mm, force_n, or both"),
        (
            {"paths": [{"kind": "touch", "force_n": {"low": 0.0, "high": 6.0}}]},
            "force_n = 0 is not allowed: must be abo",
        ),
        ({"paths": [{"kind": "touch", "force_n": {"mean": 1.0, "sd": 0.5}}]}, "force_n = -0.5 is not allowed"),
        ({"paths": [{"kind": "touch", "force_n": {"choices": [2.0, -1.0]}}]}, "force_n = -1 is not allowed"),
        (
            {"paths": [{"kind": "touch", "force_n": 1.0}], "contact": {"rate_dependent": True}},
            "paths.0.force_n is not allowed with contact.rate_dependent",
        ),
        ({"contact": {"friction": 0.5}}, "contact.friction = 0.5 is not allowed in a recipe: set paths.friction"),
        ({"touches": 9}, "touches = 9 is not allowed: paths.1 is of kind 'flashlight' and not a touch; set episodes"),
        ({"touches": 0}, "touches = 0 is not allowed"),
        ({"paths": [{"kind": "touch", "depth_mm": {"low": 1.0}}]}, "needs either low and high"),
        ({"splits": {"train": 0.0, "validation": 0.0, "test": 0.0}}, "one of them above 0"),
        ({"tolerances": {"skin": 0.1}}, "unknown key in .tolerances. 'skin'"),
    ],
)
def test_recipe_that_cannot_be_drawn_from_is_one_line(changes: dict[str, object], named: str):
    with pytest.raises(ConfigError, match=named):
        recipe_with(**changes)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"objects": [{"kind": "sphere", "radius_mm": {"low": -1.0, "high": 1.0}}]}, "radius_mm = -"),
        ({"tolerances": {"skin_mm": -2.0}}, "sensor 0: skin_mm = -1.2 is not allowed"),
        ({"objects": [{"kind": "mesh", "folder": "no-such-folder"}]}, "folder = 'no-such-folder' holds no mesh file"),
    ],
)
def test_drawn_values_that_are_not_allowed_are_one_line_before_any_work(changes: dict[str, object], named: str):
    with pytest.raises(ConfigError, match=named):
        list(draw_episodes(recipe_with(**changes)))


def test_recipe_hash_knows_what_rows_depend_on():
    recipe = small_recipe()
    assert recipe.config_hash() == small_recipe("episodes=99", "timeout_s=5").config_hash()
    assert recipe.config_hash() != small_recipe("render.samples=3").config_hash()
    assert recipe.config_hash() != small_recipe(seed=4).config_hash()


def test_override_reaches_into_the_default_recipe():
    data = apply_overrides(read_toml(find_preset("recipe", "default")), ["objects=[]"])
    assert data["objects"] == []
    assert load_recipe("default", ["design.skin_mm=0.6"]).design.skin_mm == 0.6


@pytest.mark.parametrize("sampling", ["sobol", "stratified", "random"])
def test_episode_is_the_same_whenever_it_is_asked_for(sampling: str):
    recipe = small_recipe("episodes=5000", f"sampling={sampling}")
    forwards, backwards = draw_episodes(recipe), draw_episodes(recipe)
    numbers = [0, 1023, 1024, 4999]
    assert [forwards[number] for number in numbers] == [backwards[number] for number in numbers[::-1]][::-1]
    assert forwards[-1] == forwards[4999]
    assert [each.index for each in forwards[10:13]] == [10, 11, 12]
    with pytest.raises(IndexError):
        forwards[5000]


def test_more_sensors_than_a_table_should_hold_are_refused():
    with pytest.raises(ConfigError, match="are 625000 sensors: at most 100000 are allowed; raise episodes_per_sensor"):
        load_recipe("default", ["episodes=10000000"])
    assert len(draw_episodes(load_recipe("default", ["episodes=10000000", "episodes_per_sensor=1000"]))) == 10_000_000


def test_names_in_a_recipe_cannot_change_the_header_of_its_card():
    names = "a\n---\nlicense: none\n|<script>"
    recipe = recipe_with(objects=[{"kind": "mesh", "path": f"{names}.stl", "scale": 2.0}])
    plain = recipe_with(objects=[{"kind": "mesh", "path": "a.stl", "scale": 2.0}])
    cards = [dataset_card(each, columns_of(each), {"magicsim": "1"}) for each in (recipe, plain)]
    assert cards[0] == cards[1]


def test_sensor_without_strips_has_no_column_of_their_radiance():
    names = [{each.name for each in columns_of(small_recipe(*more))} for more in ((), ("rig.strips=[]",))]
    assert "led_radiance" in names[0] - names[1]


def test_effects_of_the_camera_are_drawn_into_their_tables_and_named_by_row():
    drawn = {"flicker_depth": {"low": 0.0, "high": 0.3}, "dark_e": {"low": 1.0, "high": 9.0}, "glare_share": 0.1}
    recipe = recipe_with(camera=drawn)
    assert {"camera.flicker_depth", "camera.dark_e"} <= set(drawn_names(recipe))
    episodes = draw_episodes(recipe)
    for episode in episodes:
        camera = episode.scene.rig.camera
        assert camera.flicker is not None
        assert camera.flicker.depth == episode.values["camera.flicker_depth"]
        assert camera.faults.dark_e == episode.values["camera.dark_e"]
        assert camera.glare is not None
        assert (camera.glare.share, camera.glare.radius_px) == (0.1, 40.0)
        assert camera.live is None
    assert len({episode.values["camera.flicker_depth"] for episode in episodes}) == len(episodes)


def test_drawn_camera_that_is_not_allowed_is_one_line():
    episodes = draw_episodes(recipe_with(camera={"flicker_depth": 1.5}))
    with pytest.raises(ConfigError, match=r"episode 0: rig\.camera\.flicker\.depth = 1\.5 is not allowed") as error:
        episodes[0]
    assert len(str(error.value).splitlines()) == 1


def test_card_says_that_frames_depend_on_those_before():
    plain, live = recipe_with(), recipe_with(camera={"live_frames": 5.0})
    assert "depends on those of its episode" not in dataset_card(plain, columns_of(plain), {})
    card = dataset_card(live, columns_of(live), {})
    assert "A frame depends on those of its episode before it (rig.camera.live: gains follow)." in card


def test_rooms_come_as_often_as_they_weigh_and_stand_in_every_row():
    rooms = [{"room": "office", "weight": 3, "ambient": {"low": 0.05, "high": 0.2}}, {"room": "dark"}]
    recipe = recipe_with(rooms=rooms, episodes=288, episodes_per_sensor=3)
    sensors = draw_sensors(recipe, 96)
    assert Counter(sensor.rig.room for sensor in sensors) == {"office": 72, "dark": 24}
    lit = [sensor for sensor in sensors if sensor.rig.room == "office"]
    assert all(sensor.rig.ambient == (sensor.values["sensor.ambient"],) * 3 for sensor in lit)
    assert {"room", "room_radiance", "drawn.sensor.ambient"} <= {column.name for column in columns_of(recipe)}
    assert draw_episodes(recipe)[4].scene.rig.room == sensors[1].rig.room


def test_a_room_that_does_not_exist_is_one_line():
    with pytest.raises(ConfigError, match=r"rooms\.0.*kitchen.*office"):
        recipe_with(rooms=[{"room": "kitchen"}])


def test_each_print_has_flaws_of_its_own_and_every_row_names_them():
    flaws = {
        "skin_roughness": {"low": 0.0, "high": 0.2},
        "wall_roughness": 0.1,
        "bubbles_per_mm3": {"low": 0.5, "high": 1.0},
        "flakes_per_mm3": 0.25,
    }
    recipe = recipe_with(tolerances=flaws)
    sensors = draw_sensors(recipe, 4)
    for number, sensor in enumerate(sensors):
        roughness, inclusions = sensor.design.roughness, sensor.design.inclusions
        assert roughness.skin == sensor.values["sensor.skin_roughness"]
        assert inclusions.bubbles_per_mm3 == sensor.values["sensor.bubbles_per_mm3"]
        assert (roughness.walls, inclusions.flakes_per_mm3, inclusions.seed) == (0.1, 0.25, number)
    assert len({sensor.design.roughness.skin for sensor in sensors}) == len(sensors)
    assert {"drawn.sensor.skin_roughness", "drawn.sensor.bubbles_per_mm3"} <= {each.name for each in columns_of(recipe)}


def test_rows_say_where_somebody_passes_in_rooms_where_somebody_does():
    names = [
        {each.name for each in columns_of(recipe_with(rooms=[{"room": "bench"}, {"room": room}]))}
        for room in ("office", "corridor")
    ]
    assert names[1] - names[0] == {"passing_x_mm"}


def test_touch_that_ends_at_a_force_notes_it_and_how_deep_it_may_go():
    by_force = {"kind": "touch", "force_n": {"low": 0.1, "high": 6.0}}
    alone, beside = (recipe_with(paths=[by_force | more], episodes=8) for more in ({}, {"depth_mm": 1.5}))
    assert "drawn.path.force_n" in {each.name for each in columns_of(alone)}
    for recipe, limit_mm, must_reach in ((alone, 2.5, True), (beside, 1.5, False)):  # 2.5 mm are the design's limit
        for episode in draw_episodes(recipe):
            assert episode.force_n == episode.values["path.force_n"]
            assert episode.must_reach is must_reach
            assert min(state.gap_mm for state in timeline(episode.scene)) == -limit_mm
    assert draw_episodes(small_recipe())[0].force_n is None


def test_touch_without_an_approach_begins_pressed():
    path = {
        "kind": "touch", "depth_mm": 0.6, "approach_frames": 0, "press_frames": 3, "shear_frames": 1, "shear_mm": 0.5,
        "twist_frames": 0, "hold_frames": 0, "release_frames": 0,
    }  # fmt: skip
    episode = draw_episodes(recipe_with(paths=[path], episodes=1))[0]
    found = [(state.gap_mm, state.x_mm) for state in timeline(episode.scene)]
    np.testing.assert_allclose(found, [(-0.2, 0), (-0.4, 0), (-0.6, 0), (-0.6, 0.5)], atol=1e-8)


def test_touches_are_counted_in_touches():
    recipe = load_recipe("touches", ["touches=40"])
    assert (recipe.episodes, load_recipe("touches", ["episodes=7"]).episodes) == (40, 7)
    kinds = set()
    for episode in draw_episodes(recipe):
        assert episode.path_kind == "touch"
        assert all(state.gap_mm < 0 for state in timeline(episode.scene))  # no frames before contact
        kinds.add(episode.scene.object.kind)
    assert kinds == {"sphere", "box", "cylinder", "domed_cylinder", "spanner", "screwdriver", "banana"}


def test_default_recipe_has_textures_and_everyday_things_at_forces_that_the_print_bears(default: Recipe, episodes):
    assert {"lines", "dots", "spanner", "screwdriver", "banana"} <= {entry.kind for entry in default.objects}
    forces = [episode.force_n for episode in episodes if episode.force_n is not None]
    assert 0.1 <= min(forces) < 0.3
    assert 5.7 < max(forces) <= default.design.limits.force_n


def test_places_are_drawn_inside_of_the_picture_unless_that_is_switched_off():
    wide = {"kind": "touch", "depth_mm": 0.5, "y_mm": {"low": -7.0, "high": 7.0}, "x_mm": {"choices": [-9.0, 0.0, 1.0]}}
    seen = recipe_with(paths=[wide], episodes=32)  # 24 x 32 pixels of 10 mm along x: 13 mm along y
    places = np.array([[each.values["path.x_mm"], each.values["path.y_mm"]] for each in draw_episodes(seen)])
    assert 5.5 < np.abs(places[:, 1]).max() <= 6.7
    assert set(places[:, 0]) == {0.0, 1.0}
    free = recipe_with(paths=[wide], episodes=32, inside=False)
    assert max(abs(each.values["path.y_mm"]) for each in draw_episodes(free)) > 6.7
    normal = recipe_with(paths=[wide | {"x_mm": {"mean": 0.0, "sd": 5.0}}], episodes=64)
    across = [each.values["path.x_mm"] for each in draw_episodes(normal)]
    assert len(set(across)) == 64  # none is moved to the picture's edge
    assert 4.0 < np.abs(across).max() < 5.0
    told = estimate(free, draw_episodes(free), processes=1).view
    assert "the picture covers" in told
    assert "of the touches are outside of it" in told
    assert not estimate(load_recipe("default"), draw_episodes(load_recipe("default")), processes=1).view
    with pytest.raises(
        ConfigError, match=r"paths\.0\.y_mm is not allowed: all of it is outside of the picture.*inside = fal"
    ):
        draw_episodes(recipe_with(paths=[wide | {"y_mm": {"low": 20.0, "high": 21.0}}]))


def test_units_that_differ_in_nothing_are_one():
    def keys(**changes: object) -> set[str]:
        recipe = recipe_with(**changes)
        units = [untouched_key(each.design, each.rig, recipe.render) for each in draw_sensors(recipe, 5)]
        assert differing_units(recipe, 5) == len(set(units))
        # Those that differ do not share the noise of an untouched image, which stands still in all frames of one.
        scenes = [
            each.scene for each in draw_episodes(recipe.model_copy(update={"episodes": 5, "episodes_per_sensor": 1}))
        ]
        assert len({each.render.anchor_seed for each in scenes}) == len(set(units))
        return set(units)

    assert len(keys(tolerances={})) == 1
    assert len(keys(tolerances={"skin_mm": 0.05})) == 1  # all alike
    assert len(keys(tolerances={"skin_mm": {"mean": 0.0, "sd": 0.02}})) == 5
    assert len(keys(tolerances={"flakes_per_mm3": 0.25})) == 5
    assert len(keys(tolerances={}, rooms=[{"room": "office", "ambient": {"low": 0.05, "high": 0.2}}])) == 5


def test_stiffness_of_a_print_is_that_at_every_time():
    recipe = load_recipe("default", ["design=mini-magictac-rate", "tolerances={stiffness=1.5}"])
    printed, drawn = draw_sensors(recipe, 1)[0].design.materials.body, recipe.design.materials.body
    assert printed.instantaneous_shear_modulus_mpa == pytest.approx(1.5 * drawn.instantaneous_shear_modulus_mpa)
    assert printed.shear_modulus_mpa == pytest.approx(1.5 * drawn.shear_modulus_mpa)
