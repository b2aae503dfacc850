"""What the entry points add to `magicsim`."""

import json
from typing import Any

import pytest
from cli.conftest import Shell
from cli.test_schema import accepts

from magicsim.cli.schema import schema_of
from magicsim.config.documents import read_toml
from magicsim.config.presets import find_preset, preset_names
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.scenes.scene import load_scene
from magicsim_experiments.study.study_file import load_study
from magicsim_experiments.task.settings import load_item

RECIPES = {"cylinders", "localisation", "ranging", "textures", "wear"}
PRESETS = [(kind, name) for kind in ("study", "item") for name in preset_names(kind)]


@pytest.mark.parametrize("words", ["study", "estimate", "task grasp", "task assembly", "task alignment"])
def test_every_command_takes_json_set_and_seed(shell: Shell, words: str):
    done = shell(*words.split(), "--help")
    assert done.code == 0
    assert all(option in done.out for option in ("--json", "--set", "--seed"))


def test_help_names_the_commands(shell: Shell):
    assert all(f" {command} " in shell("--help").out for command in ("study", "estimate", "task"))


def test_number_that_is_no_whole_one_is_refused(shell: Shell):
    refused = shell.refusal("task", "grasp", "--out", "g", "--episodes", "2.5")
    assert "--episodes: 2.5 is not allowed: must be a whole num" in refused


def test_presets_that_users_rely_on_are_listed(shell: Shell):
    found: Any = shell.json("list")
    assert {"localisation", "ranging", "wear"} <= {each["name"] for each in found["studies"]}
    assert {"orange", "banana", "biscuit-packet", "pen"} <= {each["name"] for each in found["items"]}
    assert RECIPES | {"default"} <= {each["name"] for each in found["recipes"]}
    assert all(len(each["description"]) > 10 for kind in ("studies", "items") for each in found[kind])


@pytest.mark.parametrize(("kind", "name"), PRESETS)
def test_every_preset_satisfies_its_schema_and_loads(kind: str, name: str):
    schema = schema_of(kind)
    data = read_toml(find_preset(kind, name))
    assert accepts(schema, data, schema)
    assert not accepts(schema, data | {"misspelt": 1}, schema)
    if kind == "item":
        assert load_item(name).mass_g > 0
    else:
        assert load_study(name).config.schema_version == 1
        assert load_study(name, quick=True).stages()


@pytest.mark.parametrize("name", sorted(RECIPES))
def test_every_recipe_draws_rooms(name: str):
    recipe = load_recipe(name)
    assert recipe.episodes >= 1
    assert {"office", "dark"} < {each.room for each in recipe.rooms}


def test_scene_of_the_plug_loads(shell: Shell):
    assert load_scene("assembly").frame_count >= 1
    assert json.loads(shell("schema", "item").out)["title"] == "Item"
