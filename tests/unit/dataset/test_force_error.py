"""The stated error of the force: its parts add up, textures have the larger one, and thin blocks an unknown one."""

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from magicsim.dataset.card import NEAR_ERROR, TOUCH_ERROR, camera_noise, dataset_card, force_error
from magicsim.dataset.columns import columns_of
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.dataset.shard import schema_of_columns

ROUND = Path(__file__).with_name("small.toml")
FRAME_ERROR = Path(__file__).parents[3] / "docs" / "benchmarks" / "frame-error.json"


def test_parts_add_up_by_squares_and_textures_are_worse() -> None:
    recipe = load_recipe(str(ROUND))
    lines = recipe.model_copy(update={"objects": (SimpleNamespace(kind="lines"),)})
    found, textured = force_error(recipe), force_error(lines)
    for side in (0, 1):
        parts = [found[cause][side] for cause in ("lattice", "time", "moduli")]  # type: ignore[index]
        assert abs(found["total"][side]) == pytest.approx(sum(part**2 for part in parts) ** 0.5, abs=1e-3)  # type: ignore[index]
    assert all(share is not None and share[0] < 0 < share[1] for share in found.values())
    assert textured["lattice"][1] > found["lattice"][1]


def test_labels_of_control_are_stated_to_be_too_high_and_images_of_the_fast_tier_as_its_own() -> None:
    control = load_recipe("default", ["contact.quality=control", "render.tier=fast"])
    full, columns = load_recipe("default"), columns_of(control)
    assert "quality" not in force_error(full)
    assert force_error(control)["total"][0] < force_error(full)["total"][0] < 0  # type: ignore[index]
    card = dataset_card(control, columns, {})
    assert "quality -9% to +0%" in card
    assert "fast tier's error" in card
    assert "samples a pixel" not in card


def test_region_is_what_columns_and_readers_are_told_of() -> None:
    recipe = load_recipe("default", ["rig.camera.region_px=[4,8,32,48]", "labels.depth_map=true"])
    depth = next(each for each in columns_of(recipe) if each.name == "depth_map_mm")
    assert depth.feature["shape"] == [48, 32]


def test_files_and_card_state_it() -> None:
    recipe = load_recipe("default")
    columns = columns_of(recipe)
    stated = schema_of_columns(columns).field("force_n").metadata[b"relative_error"]
    assert json.loads(stated)["total"] == list(force_error(recipe)["total"])
    assert "`force_n` comes with a stated error" in dataset_card(recipe, columns, {})


def test_labels_of_a_relaxing_body_say_that_they_follow_time() -> None:
    recipe = load_recipe(str(ROUND))
    relaxing = recipe.model_copy(update={"contact": recipe.contact.model_copy(update={"rate_dependent": True})})
    found, card = force_error(relaxing), dataset_card(relaxing, columns_of(relaxing), {})
    # READING_S in benchmarks/relaxation_curve.py: 4.17 / 1.60 after 0.1 s, 1 after none.
    assert found["time"] == pytest.approx((0.0, 4.17 / 1.60 - 1), abs=0.01)
    assert "follow the body's relaxation" in card
    assert "quasi-static" not in card
    assert "quasi-static, for the stiffness 1 s after contact" in dataset_card(recipe, columns_of(recipe), {})


@pytest.mark.parametrize(("core_mm", "is_known"), [(1.0, False), (3.3, False), (3.4, True)])
def test_blocks_below_5_mm_have_an_unknown_error(core_mm: float, is_known: bool) -> None:
    recipe = load_recipe(str(ROUND))
    thin = recipe.model_copy(update={"design": recipe.design.model_copy(update={"core_mm": core_mm})})
    assert thin.design.height_mm == pytest.approx(core_mm + 1.6)
    found, columns = force_error(thin), columns_of(thin)
    stated = json.loads(schema_of_columns(columns).field("force_n").metadata[b"relative_error"])
    assert (found["moduli"] is not None, found["total"] is not None) == (is_known, is_known)
    assert (stated["total"] is None) == (not is_known)
    assert ("total unknown" in dataset_card(thin, columns, {})) == (not is_known)


def test_card_states_the_renderers_error_beside_the_cameras_noise() -> None:
    recipe = load_recipe("default")
    # 90 grey levels of 250,000 electrons at white, 50 of read noise: sqrt(88,235 + 2,500) / 250,000 of 255.
    camera = recipe.rig.camera.model_copy(
        update={"exposure_grey": 90.0, "full_well_e": 250_000.0, "read_noise_e": 50.0, "gamma": 1.0}
    )
    found = recipe.model_copy(update={"rig": recipe.rig.model_copy(update={"camera": camera})})
    assert camera_noise(found) == pytest.approx(0.307, abs=0.001)
    card = dataset_card(found, columns_of(found), {})
    assert "0.31 grey levels rms in the mean" in card
    assert f"these images have {found.render.samples} samples" in card
    # What the card says is what was measured.
    rows = json.loads(FRAME_ERROR.read_text("utf-8"))["results"]
    whole = {row["depth_mm"]: row["error"] for row in rows if row["region"] == "whole"}
    assert (whole[1.0], whole[-1.0]) == (pytest.approx(TOUCH_ERROR, abs=0.01), pytest.approx(NEAR_ERROR, abs=0.01))
