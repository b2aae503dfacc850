from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from magicsim.config.named_files import FILE_KEYS, named_files, read_with_paths
from magicsim.config.presets import preset_root
from magicsim.dataset.recipes.recipe import load_recipe
from magicsim.errors import ConfigError, PresetError
from magicsim.geometry.design import ElastomerDesign, load_design
from magicsim.geometry.objects.kinds import find_object, parse_object
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


@pytest.fixture
def design(folder: Path) -> Path:
    """A design whose face and markers are files of its folder."""
    (folder / "art").mkdir()
    np.save(folder / "art" / "hill.npy", np.outer(np.hanning(9), np.hanning(9)) / 10)
    Image.new("RGBA", (8, 8), (0, 0, 0, 255)).save(folder / "art" / "dots.png")
    path = folder / "domed.toml"
    path.write_text(
        (preset_root() / "geometry" / "mini-magictac.toml").read_text()
        + '[face]\nkind = "height_map"\nfile = "art/hill.npy"\nfootprint_mm = [24, 32]\n'
        + '[markers]\nkind = "picture"\nfile = "art/dots.png"\nwidth_mm = 4\n'
    )
    return path


def assert_whole(design: ElastomerDesign, folder: Path) -> None:
    assert (design.face.file, design.markers.file) == (str(folder / "art/hill.npy"), str(folder / "art/dots.png"))
    assert design.face.rise_mm(np.array([[12.0, 16.0]]))[0] == pytest.approx(0.1)
    assert design.markers.pixels().shape == (8, 8, 4)


def test_face_and_markers_of_a_design_are_found_beside_it(folder: Path, design: Path):
    assert_whole(load_design(design), folder)
    assert_whole(load_design("../mine/domed.toml", ["skin_mm=0.9"]), folder)


def test_face_and_markers_of_a_design_that_a_scene_or_a_setting_names_are_found_beside_it(folder: Path, design: Path):
    head = 'schema_version = 1\nrig = "digit-rgb"\nobject = "nut.toml"\n'
    frames = "[[keyframes]]\nframe = 0\ngap_mm = 1.0\n"
    (folder / "named.toml").write_text(f'{head}design = "domed.toml"\n{frames}')
    inner = design.read_text().replace("\n[", "\n[design.")
    (folder / "whole.toml").write_text(f"{head}{frames}[design]\n{inner}")
    assert_whole(load_scene(folder / "named.toml").design, folder)
    assert_whole(load_scene(folder / "whole.toml").design, folder)
    assert_whole(load_scene("rest", [f"design={design}"]).design, folder)
    assert_whole(load_scene("rest", ["design=../mine/domed.toml"]).design, folder)


def test_file_in_a_setting_starts_in_the_current_folder(folder: Path, design: Path):
    with pytest.raises(ConfigError, match=r"markers\.file = 'art/dots\.png' does not exist"):
        load_design(design, ["markers.file=art/dots.png"])


def test_every_file_that_counts_for_a_hash_is_found_beside_its_table(folder: Path):
    for kind, keys in FILE_KEYS.items():
        for key in keys:
            (folder / "each.toml").write_text(f'kind = "{kind}"\n{key} = "nut.toml"\n')
            found = read_with_paths(folder / "each.toml")
            assert found[key] == str(folder / "nut.toml")
            assert named_files(found) == {found[key]}


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


def test_file_of_a_setting_is_that_of_the_current_folder_and_of_a_scene_that_beside_it(folder: Path):
    rig = (preset_root() / "scenes" / "rigs" / "white-ring.toml").read_text()
    (folder / "rig.toml").write_text(rig + "[flashlight]\nradius_mm = 7\n")
    scene = (preset_root() / "scenes" / "rest.toml").read_text()
    (folder / "scene.toml").write_text(scene.replace('rig = "digit-office"', 'rig = "rig.toml"'))
    assert load_scene(folder / "scene.toml", ["rig=rig.toml"]).rig.flashlight.radius_mm == 7
    Path("rig.toml").write_text(rig + "[flashlight]\nradius_mm = 6\n")
    assert load_scene(folder / "scene.toml", ["rig=rig.toml"]).rig.flashlight.radius_mm == 6
    assert load_scene(folder / "scene.toml").rig.flashlight.radius_mm == 7


def test_name_that_is_too_long_for_a_file_is_told(folder: Path):
    with pytest.raises(PresetError, match=r"rig file '.*' does not exist"):
        load_scene("rest", [f"rig={'a' * 300}.toml"])


def test_tilde_is_the_home_folder_in_files_and_on_the_line(folder: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setenv("HOME", str(folder))
    (folder / "home.toml").write_text('kind = "mesh"\npath = "~/meshes/nut.stl"\n')
    for found in (find_object("~/home.toml"), parse_object("mesh:path=~/meshes/nut.stl")):
        assert found.path == str(folder / "meshes" / "nut.stl")
