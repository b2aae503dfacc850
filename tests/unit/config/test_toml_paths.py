from pathlib import Path

import pytest

from magicsim.config.toml_paths import read_with_paths
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.geometry.objects.kinds import find_object
from magicsim.scenes.scene import load_scene


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder of one's own beside the current one."""
    (tmp_path / "here").mkdir()
    monkeypatch.chdir(tmp_path / "here")
    mine = tmp_path / "mine"
    (mine / "meshes").mkdir(parents=True)
    (mine / "meshes" / "nut.stl").write_bytes(b"solid")
    (mine / "nut.toml").write_text('kind = "mesh"\npath = "meshes/nut.stl"\n')
    return mine


def test_mesh_of_an_object_is_found_beside_its_file(folder: Path):
    assert find_object(folder / "nut.toml").path == str(folder / "meshes" / "nut.stl")


def test_mesh_of_a_scene_and_of_an_object_that_it_names_are_found_beside_them(folder: Path):
    keyframes = "[[keyframes]]\nframe = 0\ngap_mm = 1.0\n"
    begin = 'schema_version = 1\ndesign = "mini-magictac"\nrig = "digit-rgb"\n'
    (folder / "one.toml").write_text(f'{begin}object = "nut.toml"\n{keyframes}')
    (folder / "two.toml").write_text(f'{begin}{keyframes}[object]\nkind = "mesh"\npath = "meshes/nut.stl"\n')
    for name in ("one", "two"):
        assert load_scene(folder / f"{name}.toml").object.path == str(folder / "meshes" / "nut.stl")


def test_folder_of_meshes_of_a_recipe_is_found_beside_it(folder: Path):
    text = (Path(__file__).parents[1] / "dataset" / "small.toml").read_text()
    (folder / "recipe.toml").write_text(f'{text}\n[[objects]]\nkind = "mesh"\nfolder = "meshes"\n')
    assert load_recipe(folder / "recipe.toml").objects[-1].folder == str(folder / "meshes")


def test_path_below_the_current_folder_stays_short(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(folder.parent)
    assert read_with_paths(folder / "nut.toml")["path"] == "mine/meshes/nut.stl"


def test_path_that_is_not_beside_the_file_is_left_to_the_current_folder(folder: Path):
    (folder / "far.toml").write_text('kind = "mesh"\npath = "bolt.stl"\n')
    assert read_with_paths(folder / "far.toml")["path"] == "bolt.stl"


def test_picture_of_a_room_is_found_beside_the_rig_and_names_stay(folder: Path):
    (folder / "hall.png").write_bytes(b"")
    (folder / "rig.toml").write_text('room = "hall.png"\n')
    assert read_with_paths(folder / "rig.toml")["room"] == str(folder / "hall.png")
    (folder / "rig.toml").write_text('room = "office"\n')
    assert read_with_paths(folder / "rig.toml")["room"] == "office"
