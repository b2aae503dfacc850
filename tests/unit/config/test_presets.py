from pathlib import Path

import pytest

from magicsim.config import presets
from magicsim.config.models import load_preset
from magicsim.config.presets import FOLDERS, find_preset, preset_names, preset_root
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.detectors.profile import load_profile
from magicsim.errors import PresetError
from magicsim.evaluation.suite import load_suite
from magicsim.geometry.design import ElastomerDesign
from magicsim.geometry.elastomer import build_elastomer
from magicsim.geometry.objects.kinds import find_object
from magicsim.scenes.rig import Rig
from magicsim.scenes.scene import load_scene
from magicsim.sweep.designs import design_with, list_designs, values_at
from magicsim.sweep.sweep_file import load_sweep

ALL = [(kind, name) for kind in FOLDERS for name in preset_names(kind)]


@pytest.mark.parametrize(
    ("kind", "names"),
    [
        ("design", {"mini-magictac", "uniform-block"}),
        ("scene", {"demo", "rest", "near", "pressed", "flashlight"}),
        ("rig", {"digit-rgb", "digit-office"}),
        ("recipe", {"default"}),
        ("profile", {"published", "calibrated", "facing"}),
        ("object", {"finger", "silver-spanner", "red-screwdriver", "green-screwdriver", "white-pen", "orange"}),
        ("object", {"yellow-scissors", "yellow-banana", "biscuit-packet"}),
        ("suite", {"small", "full"}),
        ("sweep", {"cell-skin", "print-sobol", "print-search"}),
    ],
)
def test_presets_that_users_rely_on_are_shipped(kind: str, names: set[str]):
    assert names <= set(preset_names(kind))
    assert preset_names(kind) == sorted(preset_names(kind))


@pytest.mark.parametrize(("kind", "name"), ALL)
def test_every_shipped_preset_loads(kind: str, name: str):
    if kind == "design":
        assert load_preset(ElastomerDesign, kind, name).schema_version == 1
    elif kind == "rig":
        assert load_preset(Rig, kind, name).schema_version == 1
    elif kind == "scene":
        assert load_scene(name).frame_count >= 1
    elif kind == "object":
        assert find_object(name).color != (0.7, 0.7, 0.7)
    elif kind == "suite":
        assert load_suite(name).schema_version == 1
    elif kind == "recipe":
        recipe = load_recipe(name)
        assert recipe.episodes >= 1
        assert {"office", "dark"} < {each.room for each in recipe.rooms}
    elif kind == "sweep":
        sweep = load_sweep(name)
        assert (sweep.sampling == "search") == (not list_designs(sweep))
        ends = [design_with(sweep, 0, values_at(sweep, [end] * len(sweep.swept))) for end in (0.0, 1.0)]
        assert ends[0].sensor != ends[1].sensor
    else:
        assert load_profile(name).schema_version == 1


@pytest.mark.parametrize(("kind", "name"), ALL)
def test_every_shipped_preset_opens_with_a_comment_that_says_what_it_is(kind: str, name: str):
    first = find_preset(kind, name).read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("# ")


@pytest.mark.parametrize("name", preset_names("design"))
def test_every_shipped_design_can_be_built(name: str):
    build_elastomer(load_preset(ElastomerDesign, "design", name))


def test_file_of_the_user_works_in_the_place_of_a_name(tmp_path: Path):
    mine = tmp_path / "mine.toml"
    mine.write_bytes(find_preset("design", "uniform-block").read_bytes())
    assert find_preset("design", mine) == mine
    assert find_preset("design", str(mine)) == mine


def test_file_in_the_current_folder_is_found_by_its_suffix(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    (tmp_path / "mine.toml").write_text("schema_version = 1\n")
    monkeypatch.chdir(tmp_path)
    assert find_preset("design", "mine.toml").is_file()


@pytest.mark.parametrize("kind", FOLDERS)
def test_unknown_name_lists_the_choices(kind: str):
    with pytest.raises(PresetError) as caught:
        find_preset(kind, "no-such-thing")
    assert f"unknown {kind} 'no-such-thing'" in str(caught.value)
    assert all(name in str(caught.value) for name in preset_names(kind))


def test_misspelt_name_names_the_nearest():
    with pytest.raises(PresetError, match="did you mean 'mini-magictac'"):
        find_preset("design", "mini-magitac")


@pytest.mark.parametrize("name", ["missing.toml", "folder/missing", "folder\\missing"])
def test_missing_file_is_named_with_the_shipped_names(name: str):
    with pytest.raises(PresetError) as caught:
        find_preset("design", name)
    assert f"design file '{name}' does not exist" in str(caught.value)
    assert "mini-magictac" in str(caught.value)


def test_packaged_copy_is_preferred_to_the_checkout(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(presets, "_PACKAGE", tmp_path / "magicsim")
    assert preset_root() == tmp_path
    (tmp_path / "magicsim" / "_presets").mkdir(parents=True)
    assert preset_root() == tmp_path / "magicsim" / "_presets"
