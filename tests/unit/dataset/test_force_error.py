"""The stated error of the force: its parts add up, and textures have the larger one."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from magicsim.dataset.card import dataset_card
from magicsim.dataset.columns import columns_of
from magicsim.dataset.features import schema_of_columns
from magicsim.dataset.force_error import force_error
from magicsim.dataset.recipes.recipe import load_recipe

ROUND = Path(__file__).with_name("small.toml")


def test_parts_add_up_by_squares_and_textures_are_worse() -> None:
    recipe = load_recipe(str(ROUND))
    lines = recipe.model_copy(update={"objects": (SimpleNamespace(kind="lines"),)})
    found, textured = force_error(recipe), force_error(lines)
    for side in (0, 1):
        parts = [found[cause][side] for cause in ("lattice", "time", "moduli")]
        assert abs(found["total"][side]) == pytest.approx(sum(part**2 for part in parts) ** 0.5, abs=1e-3)
    assert all(low < 0 < high for low, high in found.values())
    assert textured["lattice"][1] > found["lattice"][1]


def test_files_and_card_state_it() -> None:
    recipe = load_recipe("default")
    columns = columns_of(recipe)
    stated = schema_of_columns(columns).field("force_n").metadata[b"relative_error"]
    assert json.loads(stated)["total"] == list(force_error(recipe)["total"])
    assert "`force_n` comes with a stated error" in dataset_card(recipe, columns, {})
